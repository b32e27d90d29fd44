"""Turns points in device memory into what the compiled part takes, or into an error that helps."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from . import _core
from ._device import DeviceArray, WorkStream, find_device_array, is_on_device, work_stream
from ._device_rays import count_rows, read_limit, require_float32


class DevicePoints(NamedTuple):
    """Points in device memory."""

    core: _core.DevicePoints
    shape: tuple[int, ...]
    arrays: list[DeviceArray]
    """points first; kept until the call has enqueued its work"""
    stream: WorkStream


def find_device_points(points: Any, max_distance: Any, stream: Any) -> DevicePoints | None:
    """Read points on a device; None where they lie on the host."""
    places = find_device_array(points, "points")
    if places is None:
        if is_on_device(max_distance):
            raise TypeError(
                "max_distance lies on a CUDA device and the points on the host: copy one of them to where "
                "the other is"
            )
        return None
    require_float32(places, "points")
    if not places.shape or places.shape[-1] != 3:
        raise ValueError(f"points must have shape (..., 3), not {places.shape}")
    radii = read_limit(max_distance, "max_distance", "points")
    own = () if isinstance(radii, float) else radii.shape
    shape = _match_shapes(places.shape[:-1], own)
    rows = (
        count_rows(places.shape, (*shape, 3), 3, "points"),
        count_rows(own, shape, 1, "max_distance"),
    )
    address, value = (0, radii) if isinstance(radii, float) else (radii.address, 0.0)
    core = _core.DevicePoints(math.prod(shape), places.address, address, *rows, value)
    arrays = [places] if isinstance(radii, float) else [places, radii]
    return DevicePoints(core, shape, arrays, work_stream(stream, places))


def _match_shapes(points: tuple[int, ...], radii: tuple[int, ...]) -> tuple[int, ...]:
    try:
        return np.broadcast_shapes(points, radii)
    except ValueError:
        raise ValueError(
            f"points for {points} and max_distance for {radii} cannot be broadcast against each other"
        ) from None
