"""All hits of rays with trees on CUDA devices; `_hit_lists.py` has those of trees on the host."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from . import _core, _host_blocks
from ._core import DeviceBvh as CompiledDeviceBvh
from ._device import after_reading, before_reading
from ._device_queries import require_local
from ._device_rays import DeviceRays, find_device_rays
from ._device_results import make_outputs
from ._hit_lists import AllHits, as_limit
from ._inputs import Rays, as_flag, as_rays
from ._offset import Offset

_NO_LIMIT = 2**32 - 1
_HITS = ("float32", "int32", "float32", "float32")
_BYTES_A_HIT, _BYTES_A_RAY = 16, 40  # in a block of rays from the host


class DeviceHitLists:
    """Every crossing of a ray with the mesh: `HitLists` of a tree on the host, with the same answers."""

    _core: CompiledDeviceBvh
    _offset: Offset

    def intersect_all(
        self,
        origins: Any,
        directions: Any,
        t_min: Any = 0.0,
        t_max: Any = math.inf,
        *,
        limit: int | None = None,
        reorder: bool = False,
        stream: Any = None,
    ) -> AllHits:
        """Find all hits of each ray with t in [t_min, t_max]. As `Bvh.intersect_all`.

        Rays are counted, the counts added up, and the hits written to where these sums say. The call waits
        once, between: only then is known how much memory the answer takes. Where triangles were split
        (`presplit`, `sbvh`), a ray is traced again for every 64 or so of its hits.

        Args:
            origins: see `intersect`, as for all but limit.
            directions: ...
            t_min: ...
            t_max: ...
            limit: keep the first so many hits of each ray; by default all.
            reorder: ...
            stream: ...

        Returns:
            AllHits(offsets, t, face, u, v): int64 offsets of one more than there are rays, then float32,
            int32, float32, float32 arrays of all hits. Its `ray` is for numpy arrays.

        Raises:
            ValueError: as `intersect`, and for a limit less than 1.
            TypeError: as `intersect`, and for a limit that is no whole number.
            RuntimeError: where CUDA fails, as for want of memory: cut the batch into parts then.
        """
        most = min(as_limit(limit), _NO_LIMIT)
        is_sorted = as_flag(reorder, "reorder")
        rays = find_device_rays(origins, directions, t_min, t_max, stream)
        if rays is None:
            host_rays = as_rays(origins, directions, t_min, t_max, self._offset)
            _refuse_stream(stream)
            return self._list_from_host(host_rays, most, is_sorted)
        require_local(self._offset)
        return self._list(rays, most, is_sorted)

    def count_hits(
        self,
        origins: Any,
        directions: Any,
        t_min: Any = 0.0,
        t_max: Any = math.inf,
        *,
        reorder: bool = False,
        stream: Any = None,
    ) -> Any:
        """Count the hits that `intersect_all` lists. Arguments and errors as there; nothing waits.

        Returns:
            int64 array of the rays' shape.
        """
        is_sorted = as_flag(reorder, "reorder")
        rays = find_device_rays(origins, directions, t_min, t_max, stream)
        if rays is None:
            host_rays = as_rays(origins, directions, t_min, t_max, self._offset)
            _refuse_stream(stream)
            return self._count_from_host(host_rays, _NO_LIMIT, is_sorted).reshape(host_rays.shape)
        require_local(self._offset)
        counts = make_outputs(rays.arrays[0], rays.shape, ("int64",), self._core.device, rays.stream)
        before_reading(rays.arrays, rays.stream)
        self._core.count_hits(rays.core, *counts.addresses, rays.stream.address, is_sorted)
        after_reading(rays.arrays, rays.stream)
        return counts.finish()[0]

    def _list(self, rays: DeviceRays, limit: int, reorder: bool) -> AllHits:
        like, stream, device = rays.arrays[0], rays.stream, self._core.device
        offsets = make_outputs(like, (math.prod(rays.shape) + 1,), ("int64",), device, stream)
        before_reading(rays.arrays, stream)
        count = self._core.offset_hits(rays.core, *offsets.addresses, limit, stream.address, reorder)
        hits = make_outputs(like, (count,), _HITS, device, stream)
        self._core.list_hits(rays.core, *offsets.addresses, *hits.addresses, stream.address, reorder)
        after_reading(rays.arrays, stream)
        return AllHits(*offsets.finish(), *hits.finish())

    def _count_from_host(self, rays: Rays, limit: int, reorder: bool) -> np.ndarray[Any, Any]:
        return self._core.stream_count_hits(*rays.arguments, limit, reorder, _host_blocks.STREAMED_BYTES)

    def _list_from_host(self, rays: Rays, limit: int, reorder: bool) -> AllHits:
        """Block by block; each knows from the counts where its hits lie."""
        counts = self._count_from_host(rays, limit, reorder)
        offsets = np.zeros(len(counts) + 1, np.int64)
        np.cumsum(counts, out=offsets[1:])
        hits = [np.empty(offsets[-1], dtype) for dtype in _HITS]
        ends = _BYTES_A_HIT * offsets + _BYTES_A_RAY * np.arange(len(offsets))
        for begin, end in _host_blocks.cut(ends, _host_blocks.STREAMED_BYTES):
            block = _host_blocks.Block(self._core.device)
            part = slice(offsets[begin], offsets[end])
            room = [block.make((part.stop - part.start,), dtype) for dtype in _HITS]
            places = block.send(offsets[begin : end + 1] - offsets[begin])
            self._core.list_hits(
                _send(block, rays, begin, end), places, *(address for address, _ in room), 0, reorder
            )
            for array, (_, found) in zip(hits, room, strict=True):
                array[part] = found.numpy()
        return AllHits(offsets, *hits)


def _send(block: _host_blocks.Block, rays: Rays, begin: int, end: int) -> _core.DeviceRays:
    arrays = [_host_blocks.rows(array, begin, end) for array in rays.arguments[1:]]
    return _core.DeviceRays(end - begin, *map(block.send, arrays), *map(len, arrays), 0.0, 0.0)


def _refuse_stream(stream: Any) -> None:
    if stream is not None:
        raise TypeError("stream is for arrays on a CUDA device, and the rays lie on the host")
