"""The tree in the memory of a CUDA device: what `treelet.build` returns for arrays that lie there."""

from __future__ import annotations

import math
from contextlib import nullcontext
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from . import _core
from ._device import DeviceArray, Output, as_device_array, empty_like, is_on_device, stream_address
from ._inputs import as_recipe
from .report import Report

if TYPE_CHECKING:
    from .bvh import Bvh, Hits, Work

_INDEX_BYTES = {"int32": 4, "uint32": 4, "int64": 8, "uint64": 8}


class DeviceBvh:
    """A bounding volume hierarchy on a CUDA device, with the answers of the CPU's `Bvh`, bit for bit.

    Takes arrays of torch, cupy, jax, numba or any library with `__cuda_array_interface__` that lie on the
    same device, without copying, and answers in arrays of the same library. They must be float32 and
    C-contiguous. Work is enqueued on `stream`, by default the current stream of the arrays' library; no
    query waits for it.
    """

    def __init__(self, core: _core.DeviceBvh) -> None:
        """Not for users: call `treelet.build` or `Bvh.to`."""
        self._core = core
        self._report = Report(core, 0.0, nullcontext)

    def intersect(
        self, origins: Any, directions: Any, t_min: Any = 0.0, t_max: Any = math.inf, *, stream: Any = None
    ) -> Hits:
        """Find the closest hit of each ray. As `Bvh.intersect`, with arrays on the device.

        Args:
            origins: (..., 3) float32.
            directions: (..., 3) float32; one of the two may be a single row (3,) for all rays.
            t_min: (...) float32 or a number.
            t_max: (...) float32 or a number, included.
            stream: an address, a stream of torch or cupy, or anything with `__cuda_stream__`.

        Returns:
            Hits(t, face, u, v): float32, int32, float32, float32 arrays of the rays' shape.

        Raises:
            ValueError: where shapes do not fit each other or an array is not contiguous.
            TypeError: where an array lies on the host or has another dtype.
            RuntimeError: where CUDA fails.
        """
        from .bvh import Hits

        rays = _read_rays(origins, directions, t_min, t_max, stream)
        outputs = [rays.empty(dtype) for dtype in ("float32", "int32", "float32", "float32")]
        self._core.intersect(rays.core, *(output.address for output in outputs), rays.stream)
        return Hits(*(output.finish(self._core.device) for output in outputs))

    def occluded(
        self, origins: Any, directions: Any, t_min: Any = 0.0, t_max: Any = math.inf, *, stream: Any = None
    ) -> Any:
        """Whether each ray hits anything in [t_min, t_max]. Arguments and errors as `intersect`.

        Returns:
            bool array of the rays' shape.
        """
        rays = _read_rays(origins, directions, t_min, t_max, stream)
        output = rays.empty("bool")
        self._core.occluded(rays.core, output.address, rays.stream)
        return output.finish(self._core.device)

    def traversal_cost(
        self, origins: Any, directions: Any, t_min: Any = 0.0, t_max: Any = math.inf, *, stream: Any = None
    ) -> Work:
        """Count the work that `intersect` does for each ray. Arguments and errors as `intersect`.

        Returns:
            Work(nodes, triangles), int32 arrays. They may differ by a few from the CPU's: boxes are tested in
            another arithmetic.
        """
        from .bvh import Work

        rays = _read_rays(origins, directions, t_min, t_max, stream)
        outputs = [rays.empty("int32"), rays.empty("int32")]
        self._core.traversal_cost(rays.core, *(output.address for output in outputs), rays.stream)
        return Work(*(output.finish(self._core.device) for output in outputs))

    def refit(self, vertices: Any, *, stream: Any = None) -> None:
        """Move the triangles and fit the boxes, but leave the tree's shape. As `Bvh.refit`; nothing waits."""
        points = _as_vertices(vertices)
        self._core.refit(points.address, points.shape[0], stream_address(stream, points))

    def rebuild(self, vertices: Any, *, stream: Any = None) -> None:
        """Run the whole recipe again over moved vertices, in the memory that the tree has.

        Nothing waits and nothing is allocated, so a CUDA graph can record it. Call `check` before you rely on
        the answers: a tree that did not fit is empty until then.
        """
        points = _as_vertices(vertices)
        self._core.rebuild(points.address, points.shape[0], stream_address(stream, points))

    def check(self, *, stream: Any = None) -> None:
        """Wait for the last rebuild and bring `report` up to date.

        Raises:
            RuntimeError: where the tree did not fit its memory; it has more now: rebuild once more.
        """
        self._core.check(stream_address(stream))
        self._report = Report(self._core, 0.0, nullcontext)

    def to(self, device: str, *, stream: Any = None) -> Bvh | DeviceBvh:
        """The same tree elsewhere: "cpu" copies it to the host and waits; "cuda" is this one."""
        if device == "cuda":
            return self
        if device != "cpu":
            raise ValueError(f"device must be 'cpu' or 'cuda', not {device!r}")
        from .bvh import Bvh

        return Bvh(self._core.download(stream_address(stream)))

    @property
    def device(self) -> str:
        """As "cuda:0"."""
        return f"cuda:{self._core.device}"

    @property
    def report(self) -> Report:
        """What the build did: times (of the device, by stage), costs, counts, bytes."""
        return self._report

    @property
    def face_count(self) -> int:
        """Faces that were given, left-out ones included."""
        return self._report.faces

    @property
    def bounds(self) -> np.ndarray[tuple[int, int], np.dtype[np.float32]]:
        """(2, 3) float32 on the host: lower and upper corner; inf and -inf for an empty tree."""
        return np.array(self._core.bounds, dtype=np.float32)

    def __repr__(self) -> str:
        report = self._report
        return (
            f"<treelet.DeviceBvh on {self.device} of {report.faces:,} faces: {report.recipe}, "
            f"depth {report.depth}, {report.bytes / 2**20:.1f} MiB, "
            f"built in {report.build_seconds * 1e3:.2f} ms>"
        )


def build_on_device(
    vertices: Any, faces: Any, recipe: str, *, updatable: bool, validate: bool, stream: Any = None
) -> DeviceBvh:
    """`treelet.build` for arrays on a device."""
    points = _as_vertices(vertices)
    corners = as_device_array(faces, "faces")
    if corners.dtype.name not in _INDEX_BYTES:
        raise TypeError(f"faces must hold integers of 32 or 64 bits on the device, not {corners.dtype}")
    if len(corners.shape) != 2 or corners.shape[1] != 3:
        raise ValueError(f"faces must have shape (F, 3), not {corners.shape}")
    core = _core.device_build(
        points.address,
        points.shape[0],
        corners.address,
        corners.shape[0],
        _INDEX_BYTES[corners.dtype.name],
        as_recipe(recipe),
        validate,
        updatable,
        stream_address(stream, points),
    )
    return DeviceBvh(core)


def move_to_device(core: _core.Bvh, stream: Any = None) -> DeviceBvh:
    """`Bvh.to("cuda")`."""
    return DeviceBvh(_core.device_upload(core, stream_address(stream)))


def _as_vertices(vertices: Any) -> DeviceArray:
    array = _as_float32(vertices, "vertices")
    if len(array.shape) != 2 or array.shape[1] != 3:
        raise ValueError(f"vertices must have shape (V, 3), not {array.shape}")
    return array


def _as_float32(values: Any, name: str) -> DeviceArray:
    array = as_device_array(values, name)
    if array.dtype != np.float32:
        raise TypeError(f"{name} must be float32 on the device, not {array.dtype}: convert them there first")
    return array


class _Rays(NamedTuple):
    core: _core.DeviceRays
    shape: tuple[int, ...]
    like: DeviceArray
    stream: int
    keep: list[DeviceArray]  # until the call has enqueued its work

    def empty(self, dtype: str) -> Output:
        return empty_like(self.like, self.shape, dtype, self.stream)


def _read_rays(origins: Any, directions: Any, t_min: Any, t_max: Any, stream: Any) -> _Rays:
    points, vectors = _as_float32(origins, "origins"), _as_float32(directions, "directions")
    for array, name in ((points, "origins"), (vectors, "directions")):
        if not array.shape or array.shape[-1] != 3:
            raise ValueError(f"{name} must have shape (..., 3), not {array.shape}")
    shape = max(points.shape, vectors.shape, key=math.prod)[:-1]
    count = math.prod(shape)
    low, high = _read_limit(t_min, "t_min"), _read_limit(t_max, "t_max")
    rows = [
        _count_rows(points, 3, count, "origins"),
        _count_rows(vectors, 3, count, "directions"),
        _count_rows(low, 1, count, "t_min"),
        _count_rows(high, 1, count, "t_max"),
    ]
    addresses = [0 if isinstance(part, float) else part.address for part in (points, vectors, low, high)]
    values = [limit if isinstance(limit, float) else 0.0 for limit in (low, high)]
    core = _core.DeviceRays(count, *addresses, *rows, *values)
    keep = [part for part in (points, vectors, low, high) if not isinstance(part, float)]
    return _Rays(core, shape, points, stream_address(stream, points), keep)


def _read_limit(limit: Any, name: str) -> DeviceArray | float:
    return _as_float32(limit, name) if is_on_device(limit) else float(limit)


def _count_rows(part: DeviceArray | float, width: int, count: int, name: str) -> int:
    """1 for a row that all rays share, else the number of rays."""
    if isinstance(part, float):
        return 1
    rows = math.prod(part.shape) // width
    if rows not in (1, count):
        raise ValueError(f"{name} {part.shape} must have one row for all {count} rays or one a ray")
    return rows
