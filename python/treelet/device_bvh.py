"""The tree in the memory of a CUDA device: what `treelet.build` returns for arrays that lie there."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import nullcontext
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _core
from ._answers import Hits, Work
from ._device import (
    DeviceArray,
    after_reading,
    as_device_array,
    before_reading,
    is_on_device,
    require_rows_of_3,
    stream_address,
    work_stream,
)
from ._device_rays import DeviceRays, find_device_rays, require_float32
from ._device_results import make_outputs
from ._inputs import as_flag, as_rays, as_recipe
from .report import Report

if TYPE_CHECKING:
    from .bvh import Bvh

_STREAMED_BYTES = 2**28  # that rays of the host take on the device at a time
_HIT_DTYPES = ("float32", "int32", "float32", "float32")
_INDEX_DTYPES = tuple(np.dtype(name) for name in ("int32", "uint32", "int64", "uint64"))


class DeviceBvh:
    """A bounding volume hierarchy on a CUDA device, with the answers of the CPU's `Bvh`, bit for bit.

    Takes arrays of torch, cupy, jax, numba or any library with `__cuda_array_interface__` that lie on the
    same device, without copying. They must be float32 and C-contiguous. Answers are arrays of torch, cupy or
    jax where the origins are, and `treelet.cuda.Array` for all other libraries, which can read those. Rays in
    numpy arrays are sent there and answered in numpy arrays.

    Work is enqueued on `stream`, by default the current stream of the arrays' library. Queries and updates
    wait for nothing, but where an array names another stream that writes it, they wait for that one, and
    where one is jax's, which has no streams to name, for their own work.
    """

    def __init__(self, core: _core.DeviceBvh, *, is_moved: bool = False) -> None:
        """Not for users: call `treelet.build` or `Bvh.to`."""
        self._core, self._is_moved = core, is_moved
        self._report: Report | None = None

    def intersect(
        self,
        origins: Any,
        directions: Any,
        t_min: Any = 0.0,
        t_max: Any = math.inf,
        *,
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
            reorder: sort the rays for coherence before they are traced. Pays for incoherent batches of a
                million and more; answers stay in the order of the rays. Takes 16 bytes a ray, of 16 million
                rays at most, on the device.
            stream: an address, a stream of torch or cupy, or anything with `__cuda_stream__`; for arrays on
                the device.

        Returns:
            Hits(t, face, u, v): float32, int32, float32, float32 arrays of the rays' shape.

        Raises:
            ValueError: where shapes do not fit each other or an array is not contiguous.
            TypeError: where arrays lie on the host and on the device, or one has another dtype there.
            RuntimeError: where CUDA fails.
        """
        rays = find_device_rays(origins, directions, t_min, t_max, stream)
        if rays is None:
            host_rays = origins, directions, t_min, t_max
            return Hits(*self._query_from_host(self._core.stream_intersect, host_rays, reorder, stream))
        return Hits(*self._query(self._core.intersect, rays, reorder, _HIT_DTYPES))

    def occluded(
        self,
        origins: Any,
        directions: Any,
        t_min: Any = 0.0,
        t_max: Any = math.inf,
        *,
        reorder: bool = False,
        stream: Any = None,
    ) -> Any:
        """Whether each ray hits anything in [t_min, t_max]. Arguments and errors as `intersect`.

        Returns:
            bool array of the rays' shape.
        """
        rays = find_device_rays(origins, directions, t_min, t_max, stream)
        if rays is None:
            host_rays = origins, directions, t_min, t_max
            [occluded] = self._query_from_host(self._core.stream_occluded, host_rays, reorder, stream)
        else:
            [occluded] = self._query(self._core.occluded, rays, reorder, ("bool",))
        return occluded

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
            Work(nodes, triangles), int32 arrays, for rays on the host uint32. They may differ by a few from
            the CPU's: boxes are tested in another arithmetic, and leaves in another order.
        """
        rays = find_device_rays(origins, directions, t_min, t_max, stream)
        if rays is None:
            host_rays = origins, directions, t_min, t_max
            return Work(*self._query_from_host(self._core.stream_traversal_cost, host_rays, reorder, stream))
        return Work(*self._query(self._core.traversal_cost, rays, reorder, ("int32", "int32")))

    def _query(
        self, enqueue: Callable[..., None], rays: DeviceRays, reorder: bool, dtypes: tuple[str, ...]
    ) -> list[Any]:
        stream = rays.stream
        outputs = make_outputs(rays.arrays[0], rays.shape, dtypes, self._core.device, stream)
        before_reading(rays.arrays, stream)
        enqueue(rays.core, *outputs.addresses, stream.address, as_flag(reorder, "reorder"))
        after_reading(rays.arrays, stream)
        return outputs.finish()

    def _query_from_host(
        self, query: Callable[..., Any], host_rays: tuple[Any, ...], reorder: bool, stream: Any
    ) -> list[Any]:
        if stream is not None:
            raise TypeError("stream is for arrays on a CUDA device, and the rays lie on the host")
        rays = as_rays(*host_rays)
        answers = query(*rays.arguments, as_flag(reorder, "reorder"), _STREAMED_BYTES)
        return [array.reshape(rays.shape) for array in answers]

    def refit(self, vertices: Any, *, stream: Any = None) -> None:
        """Move the triangles and fit the boxes, but leave the tree's shape. As `Bvh.refit`; nothing waits.

        Args:
            vertices: (V, 3) float32 on the tree's device, as many as at the build.
            stream: the CUDA stream to enqueue on; that of the array's library by default.

        Raises:
            RuntimeError: for a tree built without `updatable=True`, and for one that was moved here.
            ValueError: for a wrong shape or another number of vertices.
            TypeError: where the vertices lie on the host or are not float32.
        """
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
        points = _as_vertices(vertices)
        used = work_stream(stream, points)
        before_reading([points], used)
        enqueue(points.address, points.shape[0], used.address)
        after_reading([points], used)

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
    used = work_stream(stream, points)
    before_reading([points, corners], used)
    core = _core.device_build(
        points.address,
        points.shape[0],
        corners.address,
        corners.shape[0],
        corners.dtype.itemsize,
        as_recipe(recipe),
        validate,
        updatable,
        used.address,
    )
    after_reading([points, corners], used)
    return DeviceBvh(core)


def move_to_device(core: _core.Bvh, stream: Any = None) -> DeviceBvh:
    """`Bvh.to("cuda")`."""
    return DeviceBvh(_core.device_upload(core, stream_address(stream)), is_moved=True)


def _as_vertices(vertices: Any, advice: str = "copy them there") -> DeviceArray:
    array = as_device_array(vertices, "vertices", advice)
    require_float32(array, "vertices")
    require_rows_of_3(array, "vertices", "V")
    return array
