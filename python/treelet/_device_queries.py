"""Ray queries of trees on CUDA devices; `_ray_queries.py` has those of trees on the host."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Literal

from ._answers import Hits, Work
from ._core import DeviceBvh as CompiledDeviceBvh
from ._device import after_reading, before_reading
from ._device_rays import DeviceRays, find_device_rays
from ._device_results import make_outputs
from ._inputs import as_flag, as_rays
from ._offset import ORIGIN, Offset

_NOT_LOCAL = (
    "float32 on the device is too coarse for this tree's coordinates: query bvh.local, with "
    "float32(origins - bvh.offset) as origins, computed in float64"
)
_STREAMED_BYTES = 2**28  # that rays of the host take on the device at a time
_HITS = ("float32", "int32", "float32", "float32")
_COUNTS = ("int32", "int32")  # torch has no arithmetic on uint32


_INSTEAD = {
    "active": "give the rays that are off a t_max of -inf",
    "face_mask": "query a copy of the tree on the host, bvh.to('cpu')",
    "cull": "query a copy of the tree on the host, bvh.to('cpu')",
    "out": "copy the answer",
}


def refuse_options(**options: Any) -> None:
    """Raise an error that says what to do instead of an option that devices do not have yet."""
    for name, value in options.items():
        if value is not None and not (isinstance(value, str) and value == "none"):
            raise NotImplementedError(f"{name} is not there on CUDA devices yet: {_INSTEAD[name]}")


class DeviceRayQueries:
    """Closest hit, any hit, and what finding them costs. Rays may lie on the device or on the host."""

    _core: CompiledDeviceBvh
    _offset: Offset

    def intersect(
        self,
        origins: Any,
        directions: Any,
        t_min: Any = 0.0,
        t_max: Any = math.inf,
        *,
        active: None = None,
        face_mask: None = None,
        cull: Literal["none"] = "none",
        out: None = None,
        reorder: bool = False,
        stream: Any = None,
    ) -> Hits:
        """Find the closest hit of each ray. As `Bvh.intersect`, with arrays on the device or on the host.

        Rays on the host are sent to the device in chunks, 256 MiB at a time, and the answers come back as
        numpy arrays; the call waits for them. Contiguous float32 arrays are read in place, memory-mapped ones
        from their file. Copies and tracing overlap, the more so where memory is pinned.

        Args:
            origins: (..., 3) float32.
            directions: (..., 3) float32. Shapes are broadcast as on the host, but nothing is repeated in
                device memory: every array has one row for all rays, or a row for each.
            t_min: (...) float32 or a number.
            t_max: (...) float32 or a number, included.
            active: not on devices yet, as the three that follow: give rays that are off a t_max of -inf.
            face_mask: query a copy of the tree on the host, `bvh.to("cpu")`.
            cull: ...
            out: ...
            reorder: sort the rays for coherence before they are traced. Pays for incoherent batches of a
                million and more; answers stay in the order of the rays. Takes 16 bytes a ray, of 16 million
                rays at most, on the device.
            stream: the CUDA stream to enqueue on, for arrays on the device: an address, a stream of torch or
                cupy, or anything with `__cuda_stream__`; by default the current stream of the library that
                the origins are of.

        Returns:
            Hits(t, face, u, v): float32, int32, float32, float32 arrays of the rays' shape.

        Raises:
            ValueError: where shapes do not fit each other or an array is not contiguous, and for arrays on
                the device where the tree has an `offset`: see `local`.
            NotImplementedError: for `active`, `face_mask`, `cull` and `out`.
            TypeError: where some arrays lie on the host and some on the device, or one has another dtype
                there; for a stream given with rays on the host, or of another kind.
            RuntimeError: where CUDA fails.
        """
        refuse_options(active=active, face_mask=face_mask, cull=cull, out=out)
        queries = self._core.intersect, self._core.stream_intersect
        return Hits(*self._trace(queries, (origins, directions, t_min, t_max), reorder, stream, _HITS))

    def occluded(
        self,
        origins: Any,
        directions: Any,
        t_min: Any = 0.0,
        t_max: Any = math.inf,
        *,
        active: None = None,
        face_mask: None = None,
        cull: Literal["none"] = "none",
        out: None = None,
        reorder: bool = False,
        stream: Any = None,
    ) -> Any:
        """Whether each ray hits anything in [t_min, t_max]. Arguments and errors as `intersect`.

        Returns:
            bool array of the rays' shape.
        """
        refuse_options(active=active, face_mask=face_mask, cull=cull, out=out)
        queries = self._core.occluded, self._core.stream_occluded
        return self._trace(queries, (origins, directions, t_min, t_max), reorder, stream, ("bool",))[0]

    def traversal_cost(
        self,
        origins: Any,
        directions: Any,
        t_min: Any = 0.0,
        t_max: Any = math.inf,
        *,
        reorder: bool = False,
        stream: Any = None,
    ) -> Work:
        """Count the work that `intersect` does for each ray. Arguments and errors as `intersect`.

        Returns:
            Work(nodes, triangles), arrays of the rays' shape: int32 on the device, because torch cannot
            compute with uint32, and uint32 for rays on the host, as `Bvh.traversal_cost`. They may differ by
            a few from the CPU's: boxes are tested in another arithmetic, and leaves in another order.
        """
        queries = self._core.traversal_cost, self._core.stream_traversal_cost
        return Work(*self._trace(queries, (origins, directions, t_min, t_max), reorder, stream, _COUNTS))

    def _trace(
        self,
        queries: tuple[Callable[..., None], Callable[..., Any]],
        rays: tuple[Any, Any, Any, Any],
        reorder: bool,
        stream: Any,
        dtypes: tuple[str, ...],
    ) -> list[Any]:
        """What one of two queries answers: the first takes rays on the device, the second on the host."""
        enqueue, trace_from_host = queries
        device_rays = find_device_rays(*rays, stream)
        if device_rays is not None:
            require_local(self._offset)
            return self._enqueue(enqueue, device_rays, as_flag(reorder, "reorder"), dtypes)
        if stream is not None:
            raise TypeError("stream is for arrays on a CUDA device, and the rays lie on the host")
        host_rays = as_rays(*rays, self._offset)
        answers = trace_from_host(*host_rays.arguments, as_flag(reorder, "reorder"), _STREAMED_BYTES)
        return [array.reshape(host_rays.shape) for array in answers]

    def _enqueue(
        self, query: Callable[..., None], rays: DeviceRays, reorder: bool, dtypes: tuple[str, ...]
    ) -> list[Any]:
        stream = rays.stream
        outputs = make_outputs(rays.arrays[0], rays.shape, dtypes, self._core.device, stream)
        before_reading(rays.arrays, stream)
        query(rays.core, *outputs.addresses, stream.address, reorder)
        after_reading(rays.arrays, stream)
        return outputs.finish()


def require_local(offset: Offset) -> None:
    """Refuse rays on the device for a tree that has an offset."""
    if offset != ORIGIN:
        raise ValueError(_NOT_LOCAL)
