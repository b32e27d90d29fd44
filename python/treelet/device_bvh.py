"""The tree in the memory of a CUDA device: what `treelet.build` returns for arrays that lie there."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import nullcontext
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from . import _core
from ._device import (
    DeviceArray,
    as_device_array,
    is_on_device,
    reading,
    require_rows_of_3,
    stream_address,
)
from ._device_results import empty_like
from ._inputs import as_recipe, broadcast_rays
from .report import Report

if TYPE_CHECKING:
    from .bvh import Bvh, Hits, Work

_INDEX_DTYPES = tuple(np.dtype(name) for name in ("int32", "uint32", "int64", "uint64"))


class DeviceBvh:
    """A bounding volume hierarchy on a CUDA device, with the answers of the CPU's `Bvh`, bit for bit.

    Takes arrays of torch, cupy, jax, numba or any library with `__cuda_array_interface__` that lie on the
    same device, without copying. They must be float32 and C-contiguous. Answers are arrays of torch, cupy or
    jax where the origins are, and `treelet.cuda.Array` for all other libraries, which can read those.

    Work is enqueued on `stream`, by default the current stream of the arrays' library. Queries and updates
    wait for nothing, but where an array names another stream that writes it, they wait for that one, and
    where one is jax's, which has no streams to name, for their own work.
    """

    def __init__(self, core: _core.DeviceBvh, *, is_moved: bool = False) -> None:
        """Not for users: call `treelet.build` or `Bvh.to`."""
        self._core, self._is_moved = core, is_moved
        self._report: Report | None = None

    def intersect(
        self, origins: Any, directions: Any, t_min: Any = 0.0, t_max: Any = math.inf, *, stream: Any = None
    ) -> Hits:
        """Find the closest hit of each ray. As `Bvh.intersect`, with arrays on the device.

        Args:
            origins: (..., 3) float32.
            directions: (..., 3) float32. Shapes are broadcast as on the host, but nothing is repeated in
                device memory: every array has one row for all rays, or a row for each.
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
        return Hits(*self._query(self._core.intersect, rays, "float32", "int32", "float32", "float32"))

    def occluded(
        self, origins: Any, directions: Any, t_min: Any = 0.0, t_max: Any = math.inf, *, stream: Any = None
    ) -> Any:
        """Whether each ray hits anything in [t_min, t_max]. Arguments and errors as `intersect`.

        Returns:
            bool array of the rays' shape.
        """
        rays = _read_rays(origins, directions, t_min, t_max, stream)
        [occluded] = self._query(self._core.occluded, rays, "bool")
        return occluded

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
        return Work(*self._query(self._core.traversal_cost, rays, "int32", "int32"))

    def _query(self, enqueue: Callable[..., None], rays: _Rays, *dtypes: str) -> list[Any]:
        device = self._core.device
        outputs = [empty_like(rays.arrays[0], rays.shape, dtype, device, rays.stream) for dtype in dtypes]
        with reading(rays.arrays, rays.stream):
            enqueue(rays.core, *(output.address for output in outputs), rays.stream)
        return [output.finish() for output in outputs]

    def refit(self, vertices: Any, *, stream: Any = None) -> None:
        """Move the triangles and fit the boxes, but leave the tree's shape. As `Bvh.refit`; nothing waits."""
        self._update(self._core.refit, vertices, stream)
        self._report = None

    def rebuild(self, vertices: Any, *, stream: Any = None) -> None:
        """Run the whole recipe again over moved vertices, in the memory that the tree has.

        Nothing waits and nothing is allocated, so a CUDA graph can record it. Call `check` before you rely on
        the answers: a tree that did not fit is empty until then.

        Raises:
            RuntimeError: for a tree built without `updatable=True`, and for one that was moved here.
            ValueError: for a wrong shape or another number of vertices.
            TypeError: where the vertices lie on the host or are not float32.
        """
        self._update(self._core.rebuild, vertices, stream)

    def _update(self, enqueue: Callable[..., None], vertices: Any, stream: Any) -> None:
        if self._is_moved:
            raise RuntimeError(
                "this tree was moved here from the host, and a moved tree cannot be updated: build it from "
                "arrays on the device with treelet.build(vertices, faces, updatable=True)"
            )
        points = _as_vertices(vertices, "copy them there")
        address = stream_address(stream, points)
        with reading([points], address):
            enqueue(points.address, points.shape[0], address)

    def check(self, *, stream: Any = None) -> None:
        """Wait for the last rebuild and bring `report` up to date.

        Raises:
            RuntimeError: where the tree did not fit its memory; it has more now: rebuild once more.
        """
        self._core.check(stream_address(stream))
        self._report = None

    def to(self, device: str, *, stream: Any = None) -> Bvh | DeviceBvh:
        """The same tree elsewhere: "cpu" copies it to the host and waits; "cuda", or its own `device` as
        "cuda:0", is this one.

        A copy cannot be updated, even where this tree can.

        Raises:
            ValueError: for any other device.
        """
        if device in ("cuda", self.device):
            return self
        if device != "cpu":
            raise ValueError(f"device must be 'cpu' or 'cuda' or {self.device!r}, not {device!r}")
        from .bvh import Bvh

        return Bvh(self._core.download(stream_address(stream)), is_moved=True)

    def validate(self, vertices: Any = None, faces: Any = None) -> list[str]:
        """`Bvh.validate` of a copy on the host; the mesh, if given, in host arrays too."""
        for array, name in ((vertices, "vertices"), (faces, "faces")):
            if is_on_device(array):
                raise TypeError(f"{name} must lie on the host, where validation runs: copy them there")
        return self.to("cpu").validate(vertices, faces)

    @property
    def device(self) -> str:
        """As "cuda:0"."""
        return f"cuda:{self._core.device}"

    @property
    def report(self) -> Report:
        """What the build did: times (of the device, by stage), costs, counts, bytes.

        The first look after a build, a refit or `check` waits for the device.
        """
        if self._report is None:
            self._report = Report(self._core, 0.0, nullcontext)
        return self._report

    @property
    def face_count(self) -> int:
        """Faces that were given, left-out ones included."""
        return self.report.faces

    @property
    def bounds(self) -> np.ndarray[tuple[int, int], np.dtype[np.float32]]:
        """(2, 3) float32 on the host: lower and upper corner; inf and -inf for an empty tree."""
        return np.array(self._core.bounds, dtype=np.float32)

    def __repr__(self) -> str:
        report = self.report
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
    corners = as_device_array(faces, "faces", "copy them there, or the vertices to the host")
    if corners.dtype not in _INDEX_DTYPES:
        raise TypeError(f"faces must hold integers of 32 or 64 bits on the device, not {corners.dtype}")
    require_rows_of_3(corners, "faces", "F")
    address = stream_address(stream, points)
    with reading([points, corners], address):
        core = _core.device_build(
            points.address,
            points.shape[0],
            corners.address,
            corners.shape[0],
            corners.dtype.itemsize,
            as_recipe(recipe),
            validate,
            updatable,
            address,
        )
    return DeviceBvh(core)


def move_to_device(core: _core.Bvh, stream: Any = None) -> DeviceBvh:
    """`Bvh.to("cuda")`."""
    return DeviceBvh(_core.device_upload(core, stream_address(stream)), is_moved=True)


def _as_vertices(vertices: Any, *advice: str) -> DeviceArray:
    array = _as_float32(vertices, "vertices", *advice)
    require_rows_of_3(array, "vertices", "V")
    return array


def _as_float32(values: Any, name: str, *advice: str) -> DeviceArray:
    array = as_device_array(values, name, *advice)
    if array.dtype != np.float32:
        raise TypeError(f"{name} must be float32 on the device, not {array.dtype}: convert them there first")
    return array


class _Rays(NamedTuple):
    core: _core.DeviceRays
    shape: tuple[int, ...]
    arrays: list[DeviceArray]  # origins first; kept until the call has enqueued its work
    stream: int


def _read_rays(origins: Any, directions: Any, t_min: Any, t_max: Any, stream: Any) -> _Rays:
    points, vectors = _as_float32(origins, "origins"), _as_float32(directions, "directions")
    for array, name in ((points, "origins"), (vectors, "directions")):
        if not array.shape or array.shape[-1] != 3:
            raise ValueError(f"{name} must have shape (..., 3), not {array.shape}")
    low, high = _read_limit(t_min, "t_min"), _read_limit(t_max, "t_max")
    parts = (points, vectors, low, high)
    shapes = [() if isinstance(part, float) else part.shape for part in parts]
    shape = broadcast_rays(*shapes)
    rows = [
        _count_rows(shapes[0], (*shape, 3), 3, "origins"),
        _count_rows(shapes[1], (*shape, 3), 3, "directions"),
        _count_rows(shapes[2], shape, 1, "t_min"),
        _count_rows(shapes[3], shape, 1, "t_max"),
    ]
    addresses = [0 if isinstance(part, float) else part.address for part in parts]
    values = [limit if isinstance(limit, float) else 0.0 for limit in (low, high)]
    core = _core.DeviceRays(math.prod(shape), *addresses, *rows, *values)
    arrays = [part for part in parts if not isinstance(part, float)]
    return _Rays(core, shape, arrays, stream_address(stream, points))


def _read_limit(limit: Any, name: str) -> DeviceArray | float:
    if is_on_device(limit):
        return _as_float32(limit, name)
    number = np.asarray(limit)
    if number.ndim > 0 or number.dtype.kind not in "fiu":
        raise TypeError(
            f"{name} must be a number, or an array on the CUDA device as the rays are, not a "
            f"{type(limit).__name__} on the host"
        )
    with np.errstate(over="ignore"):  # beyond float32 is infinite, as on the host
        return float(number.astype(np.float32))


def _count_rows(own: tuple[int, ...], whole: tuple[int, ...], width: int, name: str) -> int:
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
