"""The tree in the memory of a CUDA device: what `treelet.build` returns for arrays that lie there."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from . import _core
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
from ._device_hit_lists import DeviceHitLists
from ._device_point_queries import DevicePointQueries
from ._device_queries import DeviceRayQueries
from ._device_rays import require_float32
from ._inputs import as_recipe
from ._offset import ORIGIN, Bounds, Offset, add_offset
from .report import Report

if TYPE_CHECKING:
    from .bvh import Bvh

_ON_THE_CPU = ("stream_hits", "winding_number", "overlap_boxes", "overlap_spheres")
_INDEX_DTYPES = tuple(np.dtype(name) for name in ("int32", "uint32", "int64", "uint64"))


class DeviceBvh(DeviceRayQueries, DeviceHitLists, DevicePointQueries):
    """A bounding volume hierarchy on a CUDA device, with the answers of the CPU's `Bvh`, bit for bit.

    Takes arrays of torch, cupy, jax, numba or any library with `__cuda_array_interface__` that lie on the
    same device, without copying. They must be float32 and C-contiguous. Answers are arrays of torch, cupy or
    jax where the origins are, and `treelet.cuda.Array` for all other libraries, which can read those. Rays in
    numpy arrays are sent there and answered in numpy arrays.

    Work is enqueued on `stream`, by default the current stream of the arrays' library. Queries and updates
    wait for nothing, but where an array names another stream that writes it, they wait for that one, and
    where one is jax's, which has no streams to name, for their own work.
    """

    def __init__(
        self,
        core: _core.DeviceBvh,
        *,
        is_moved: bool = False,
        offset: Offset = ORIGIN,
        vertex_rounding: float = 0.0,
    ) -> None:
        """Not for users: call `treelet.build` or `Bvh.to`."""
        self._core, self._is_moved = core, is_moved
        self._offset, self._vertex_rounding = offset, vertex_rounding
        self._report: Report | None = None

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
        """The same tree elsewhere: "cpu" copies it to the host and waits; "cuda" is where it is.

        A copy cannot be updated, even where this tree can.

        Args:
            device: "cpu", "cuda" or this tree's own `device`, as "cuda:0".
            stream: the CUDA stream to copy in, as for queries; the default stream if None.

        Raises:
            ValueError: for any other device.
            TypeError: for a stream of another kind.
            RuntimeError: where CUDA fails.
        """
        if device in ("cuda", self.device):
            return self
        if device != "cpu":
            raise ValueError(f"device must be 'cpu' or 'cuda' or {self.device!r}, not {device!r}")
        from .bvh import Bvh

        core = self._core.download(stream_address(stream))
        _core.place(core, self._offset, self._vertex_rounding)
        return Bvh(core, is_moved=True)

    @property
    def offset(self) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        """(3,) float64, on the host: what was subtracted from the vertices, as `Bvh.offset`."""
        return np.array(self._offset)

    @property
    def local(self) -> DeviceBvh:
        """This tree in coordinates relative to `offset`, which rays in device memory have to be in.

        Subtract the offset from their origins there, in float64, and round to float32. The tree is the same
        one in the same memory. Where the offset is zero, so is this.
        """
        return DeviceBvh(self._core, is_moved=self._is_moved, vertex_rounding=self._vertex_rounding)

    def __getattr__(self, name: str) -> NoReturn:
        reason = f": it runs on the CPU alone, bvh.to('cpu').{name}(...)" if name in _ON_THE_CPU else ""
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}{reason}")

    def __reduce__(self) -> NoReturn:
        raise TypeError("a tree on a CUDA device cannot be pickled: move it with bvh.to('cpu') first")

    def validate(self, vertices: Any = None, faces: Any = None) -> list[str]:
        """List what is wrong with the tree: `Bvh.validate` of a copy on the host, where this waits.

        Args:
            vertices: (V, 3), where the mesh is now, on the host.
            faces: (F, 3) integers on the host.

        Raises:
            ValueError: for a wrong shape, or a face index out of range.
            TypeError: for vertices without faces or faces without vertices, and for arrays that do not hold
                numbers or lie on a CUDA device: copy those to the host first.
            RuntimeError: where CUDA fails.
        """
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
            self._report = Report(self._core, self._vertex_rounding, nullcontext)
        return self._report

    @property
    def face_count(self) -> int:
        """Faces that were given, left-out ones included."""
        return self.report.faces

    @property
    def bounds(self) -> Bounds:
        """(2, 3) on the host: lower and upper corner, as `Bvh.bounds`; inf and -inf for an empty tree."""
        return add_offset(np.array(self._core.bounds, dtype=np.float32), self._offset)

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
    offset, rounding = _core.placement(core)
    uploaded = _core.device_upload(core, stream_address(stream))
    return DeviceBvh(uploaded, is_moved=True, offset=offset, vertex_rounding=rounding)


def _as_vertices(vertices: Any, advice: str = "copy them there") -> DeviceArray:
    array = as_device_array(vertices, "vertices", advice)
    require_float32(array, "vertices")
    require_rows_of_3(array, "vertices", "V")
    return array
