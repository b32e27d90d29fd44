"""Turns arrays of rays in device memory into what the compiled part takes, or into an error that helps.

A query of a million rays takes the device a tenth of a millisecond, so microseconds count here: what is asked
of an array is asked once, and the usual shapes are recognised before the general rules run.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from . import _core
from ._device import DeviceArray, WorkStream, as_device_array, find_device_array, is_on_device, work_stream
from ._inputs import broadcast_rays

_FLOAT32 = np.dtype(np.float32)
_MAX_FLOAT32 = float(np.finfo(np.float32).max)


class DeviceRays(NamedTuple):
    """Rays in device memory."""

    core: _core.DeviceRays
    shape: tuple[int, ...]
    arrays: list[DeviceArray]
    """origins first; kept until the call has enqueued its work"""
    stream: WorkStream


def find_device_rays(origins: Any, directions: Any, t_min: Any, t_max: Any, stream: Any) -> DeviceRays | None:
    """Read rays on a device; None where all of them lie on the host."""
    points = find_device_array(origins, "origins")
    if points is None:
        _require_all_on_host(directions=directions, t_min=t_min, t_max=t_max)
        return None
    vectors = as_device_array(directions, "directions", "copy it there, or the origins to the host")
    for array, name in ((points, "origins"), (vectors, "directions")):
        require_float32(array, name)
        if not array.shape or array.shape[-1] != 3:
            raise ValueError(f"{name} must have shape (..., 3), not {array.shape}")
    parts = (points, vectors, read_limit(t_min, "t_min"), read_limit(t_max, "t_max"))
    shape, rows = _match_shapes(*parts)
    addresses = [0 if isinstance(part, float) else part.address for part in parts]
    values = [limit if isinstance(limit, float) else 0.0 for limit in parts[2:]]
    core = _core.DeviceRays(math.prod(shape), *addresses, *rows, *values)
    arrays = [part for part in parts if not isinstance(part, float)]
    return DeviceRays(core, shape, arrays, work_stream(stream, points))


def require_float32(array: DeviceArray, name: str) -> None:
    """Refuse other numbers: nothing is converted on the device."""
    if array.dtype != _FLOAT32:
        raise TypeError(f"{name} must be float32 on the device, not {array.dtype}: convert them there first")


def _require_all_on_host(**parts: Any) -> None:
    for name, part in parts.items():
        if is_on_device(part):
            raise TypeError(
                f"{name} lies on a CUDA device and the origins on the host: copy one of them to where the "
                "other is"
            )


def read_limit(limit: Any, name: str, of: str = "rays") -> DeviceArray | float:
    """A float32 array on the device, or the number that holds for all."""
    if type(limit) is float and (-_MAX_FLOAT32 <= limit <= _MAX_FLOAT32 or limit == math.inf):
        return limit
    array = find_device_array(limit, name)
    if array is not None:
        require_float32(array, name)
        return array
    number = np.asarray(limit)
    if number.ndim > 0 or number.dtype.kind not in "fiu":
        raise TypeError(
            f"{name} must be a number, or an array on the CUDA device as the {of} are, not a "
            f"{type(limit).__name__} on the host"
        )
    with np.errstate(over="ignore"):  # beyond float32 is infinite, as on the host
        return float(number.astype(np.float32))


def _match_shapes(
    origins: DeviceArray, directions: DeviceArray, t_min: DeviceArray | float, t_max: DeviceArray | float
) -> tuple[tuple[int, ...], list[int]]:
    """The rays' shape, and how many rows each part has: 1 or one a ray."""
    limits = [() if isinstance(limit, float) else limit.shape for limit in (t_min, t_max)]
    if origins.shape == directions.shape and limits == [(), ()]:
        count = math.prod(origins.shape[:-1])
        return origins.shape[:-1], [count, count, 1, 1]
    shape = broadcast_rays(origins.shape, directions.shape, *limits)
    return shape, [
        count_rows(origins.shape, (*shape, 3), 3, "origins"),
        count_rows(directions.shape, (*shape, 3), 3, "directions"),
        count_rows(limits[0], shape, 1, "t_min"),
        count_rows(limits[1], shape, 1, "t_max"),
    ]


def count_rows(own: tuple[int, ...], whole: tuple[int, ...], width: int, name: str) -> int:
    """1 for a row that all rays share, else the number of rays."""
    size = math.prod(own)
    if size == width:
        return 1
    if size != math.prod(whole):
        raise ValueError(
            f"{name} {own} must have one row for all rays or one for each, {whole}: broadcast it on the "
            "device first"
        )
    return size // width
