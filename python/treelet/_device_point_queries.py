"""Point queries of trees on CUDA devices; `_point_queries.py` has those of trees on the host."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from . import _core, _host_blocks
from ._core import DeviceBvh as CompiledDeviceBvh
from ._device import after_reading, before_reading
from ._device_points import DevicePoints, find_device_points
from ._device_results import make_outputs
from ._inputs import Volumes, as_spheres
from ._offset import ORIGIN, Offset
from ._point_queries import ClosestPoints

_NOT_LOCAL = (
    "float32 on the device is too coarse for this tree's coordinates: query bvh.local, with "
    "float32(points - bvh.offset) as points, computed in float64; nearest points are local, too"
)
_PLACE, _REST = ("float32",), ("float32", "int32", "float32", "float32")
_BYTES_A_POINT = 48  # and its answers, at most


class DevicePointQueries:
    """Nearest points, inside and outside: those of a tree on the host, with the same answers.

    Points may lie on the device or on the host, whose are sent there in blocks of 256 MiB and answered in
    numpy arrays.
    """

    _core: CompiledDeviceBvh
    _offset: Offset

    def closest_point(
        self, points: Any, max_distance: Any = math.inf, *, stream: Any = None
    ) -> ClosestPoints:
        """Find the point of the mesh that is nearest to each point. As `Bvh.closest_point`.

        Args:
            points: (..., 3) float32 on the device, or anything on the host.
            max_distance: (...) float32 or a number; where the points are.
            stream: the CUDA stream to enqueue on, as for `intersect`.

        Returns:
            ClosestPoints(point, distance, face, u, v), float32 but for int32 faces, of the points' shape.

        Raises:
            ValueError: where shapes do not fit each other or an array is not contiguous, and for points on
                the device where the tree has an `offset`: see `local`.
            TypeError: where points and max_distance lie apart, or have another dtype on the device; for a
                stream given with points on the host, or of another kind.
            RuntimeError: where CUDA fails.
        """
        places = find_device_points(points, max_distance, stream)
        if places is not None:
            return ClosestPoints(*self._answer(self._core.closest_point, places, (_PLACE, _REST)))
        balls = as_spheres(points, max_distance, ("points", "max_distance"), self._offset)
        _refuse_stream(stream)
        found = self._answer_host(self._core.closest_point, balls, ((3,), (), (), (), ()), _PLACE + _REST)
        if self._offset != ORIGIN:
            found[0] = found[0] + np.array(self._offset)
        return ClosestPoints(*found)

    def distance(self, points: Any, *, stream: Any = None) -> Any:
        """The distance of each point (..., 3) from the mesh, float32 (...). As `closest_point`."""
        return self._answer_each(self._find_distance, points, "float32", stream)

    def signed_distance(self, points: Any, *, stream: Any = None) -> Any:
        """`distance`, negative where the mesh `contains` the point, float32 (...)."""
        return self._answer_each(self._core.signed_distance, points, "float32", stream)

    def contains(self, points: Any, *, stream: Any = None) -> Any:
        """Whether each point (..., 3) is inside of the mesh, bool (...). As `Bvh.contains`, as exact."""
        return self._answer_each(self._core.contains, points, "bool", stream)

    def _find_distance(self, points: _core.DevicePoints, distance: int, stream: int) -> None:
        self._core.closest_point(points, 0, distance, 0, 0, 0, stream)

    def _answer_each(self, query: Callable[..., None], points: Any, dtype: str, stream: Any) -> Any:
        """One answer a point."""
        places = find_device_points(points, math.inf, stream)
        if places is not None:
            return self._answer(query, places, ((), (dtype,)))[0]
        balls = as_spheres(points, math.inf, ("points", "max_distance"), self._offset)
        _refuse_stream(stream)
        return self._answer_host(query, balls, ((),), (dtype,))[0]

    def _answer(
        self,
        query: Callable[..., None],
        points: DevicePoints,
        dtypes: tuple[tuple[str, ...], tuple[str, ...]],
    ) -> list[Any]:
        """Arrays of three values a point, then arrays of one."""
        if self._offset != ORIGIN:
            raise ValueError(_NOT_LOCAL)
        like, stream, device = points.arrays[0], points.stream, self._core.device
        vectors = make_outputs(like, (*points.shape, 3), dtypes[0], device, stream)
        values = make_outputs(like, points.shape, dtypes[1], device, stream)
        before_reading(points.arrays, stream)
        query(points.core, *vectors.addresses, *values.addresses, stream.address)
        after_reading(points.arrays, stream)
        return [*vectors.finish(), *values.finish()]

    def _answer_host(
        self,
        query: Callable[..., None],
        points: Volumes,
        widths: tuple[tuple[int, ...], ...],
        dtypes: tuple[str, ...],
    ) -> list[Any]:
        """Block by block."""
        count, *arrays = points.arguments
        answers = [np.empty((count, *width), dtype) for width, dtype in zip(widths, dtypes, strict=True)]
        ends = _BYTES_A_POINT * np.arange(count + 1)
        for begin, end in _host_blocks.cut(ends, _host_blocks.STREAMED_BYTES):
            block = _host_blocks.Block(self._core.device)
            room = [block.make((end - begin, *each.shape[1:]), each.dtype.name) for each in answers]
            sent = [_host_blocks.rows(array, begin, end) for array in arrays]
            core = _core.DevicePoints(end - begin, *map(block.send, sent), *map(len, sent), 0.0)
            query(core, *(address for address, _ in room), 0)
            for answer, (_, found) in zip(answers, room, strict=True):
                answer[begin:end] = found.numpy()
        return [answer.reshape(points.shape + answer.shape[1:]) for answer in answers]


def _refuse_stream(stream: Any) -> None:
    if stream is not None:
        raise TypeError("stream is for arrays on a CUDA device, and the points lie on the host")
