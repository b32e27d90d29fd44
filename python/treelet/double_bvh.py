"""Trees in float64: what `treelet.build(..., precision="float64")` returns."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, NoReturn

import numpy as np
from numpy.typing import ArrayLike

from . import _core
from ._double_inputs import DoubleArray, as_double_rays, as_double_vertices
from ._hit_lists import OffsetArray, as_limit
from ._inputs import as_faces, as_flag, as_recipe
from .report import Report

_FaceArray = np.ndarray[tuple[int, ...], np.dtype[np.int32]]

_MISSING = {
    "to": "trees in float64 are on the CPU alone",
    "refit": "trees in float64 do not move: build another one over the moved vertices",
    "rebuild": "trees in float64 do not move: build another one over the moved vertices",
    "save": "trees in float64 have no files yet: save vertices and faces, and build again",
    "stream_hits": "call intersect_all for parts of the rays",
    "mesh_hash": "it is that of a mesh in float32: treelet.mesh_hash(vertices, faces)",
}
_IN_FLOAT32 = (
    "this is in float32 alone: treelet.build(vertices, faces) without precision has it, for vertices rounded "
    "to float32 after an offset was subtracted exactly"
)


class DoubleHits(NamedTuple):
    """Closest hits, one a ray, in the rays' shape. The hit point is (1-u-v) P0 + u P1 + v P2 of `face`.

    t, u and v are the exact ones for the vertices and rays as given, rounded to the nearest float64.
    """

    t: DoubleArray
    """float64, in units of the direction's length; inf for a miss."""
    face: _FaceArray
    """int32 index into the faces that were given; -1 for a miss."""
    u: DoubleArray
    """float64; 0 for a miss."""
    v: DoubleArray
    """float64; 0 for a miss."""


class DoubleAllHits(NamedTuple):
    """All hits of N rays: `treelet.AllHits` in float64. Those of ray i are `offsets[i]:offsets[i + 1]`."""

    offsets: OffsetArray
    """(N + 1,) int64; rays of any leading shape are numbered as in C order."""
    t: DoubleArray
    """(hits,) float64, in units of the direction's length."""
    face: _FaceArray
    """(hits,) int32 index into the faces that were given."""
    u: DoubleArray
    """(hits,) float64."""
    v: DoubleArray
    """(hits,) float64."""

    @property
    def ray(self) -> np.ndarray[tuple[int, ...], np.dtype[np.int64]]:
        """(hits,) int64: the number of each hit's ray."""
        return np.repeat(np.arange(len(self.offsets) - 1), np.diff(self.offsets))


class DoubleBvh:
    """A bounding volume hierarchy over a mesh in float64, for rays in float64; on the CPU.

    Nothing is rounded to float32 but the boxes, and those outwards: a hit is reported if and only if the ray
    and the triangle, as given in float64, meet. It holds for all finite float64, however large or small; far
    beyond 1e90 or below 1e-90 answers take longer. It owns a copy of the triangles, never changes, and may
    be queried from many threads.

    Origins and directions (..., 3) and t_min and t_max (...) are broadcast against each other, and answers
    have the broadcast shape. Rays with a NaN or infinite origin or direction, a zero direction or a NaN limit
    miss. Give float64: what is float32 has been rounded before.
    """

    def __init__(self, core: _core.DoubleBvh) -> None:
        """Not for users: call `treelet.build` with `precision="float64"`."""
        self._core = core
        self._report = Report(core, 0.0)

    def intersect(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
    ) -> DoubleHits:
        """Find the closest hit of each ray: the smallest t in [t_min, t_max], of equal t the smaller face.

        Watertight, and t is compared after it has been rounded to float64.

        Args:
            origins: (..., 3) float.
            directions: (..., 3) float, of any length but zero; t counts in it.
            t_min: (...) or scalar, included.
            t_max: (...) or scalar, included.

        Returns:
            DoubleHits(t, face, u, v), arrays of the broadcast leading shape.

        Raises:
            ValueError: where the shapes do not fit each other.
            TypeError: where an array does not hold numbers, or lies on a CUDA device.
        """
        shape, arguments = as_double_rays(origins, directions, t_min, t_max)
        return DoubleHits(*(array.reshape(shape) for array in self._core.intersect(*arguments)))

    def occluded(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
    ) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
        """Whether each ray hits anything in [t_min, t_max]. Arguments and errors as `intersect`."""
        shape, arguments = as_double_rays(origins, directions, t_min, t_max)
        return self._core.occluded(*arguments).reshape(shape)

    def intersect_all(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
        *,
        limit: int | None = None,
    ) -> DoubleAllHits:
        """Find all hits of each ray with t in [t_min, t_max], sorted by (t, face).

        A ray crosses a surface once, also at edges and vertices: the rule of `Bvh.intersect_all`. The sign of
        t is exact.

        Args:
            origins: see `intersect`, as for the limits on t.
            directions: ...
            t_min: ...
            t_max: ... Hits beyond the largest float64 have t = inf and belong to rays whose t_max is inf.
            limit: keep the first so many hits of each ray; by default all.

        Returns:
            DoubleAllHits(offsets, t, face, u, v).

        Raises:
            ValueError: where the shapes do not fit each other, or limit is less than 1.
            TypeError: where an array does not hold numbers, or lies on a CUDA device.
        """
        _, arguments = as_double_rays(origins, directions, t_min, t_max)
        most = as_limit(limit)
        return DoubleAllHits(*self._core.intersect_all(*arguments, most))

    def count_hits(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
    ) -> np.ndarray[tuple[int, ...], np.dtype[np.int64]]:
        """Count the hits that `intersect_all` lists, int64 of the rays' shape. Arguments and errors as there.

        On a closed mesh counts are even from outside and odd from inside, without exception.
        """
        shape, arguments = as_double_rays(origins, directions, t_min, t_max)
        return self._core.count_hits(*arguments).reshape(shape)

    @property
    def report(self) -> Report:
        """What the build did. `epo` is NaN: it is not computed for trees in float64."""
        return self._report

    @property
    def face_count(self) -> int:
        """Faces that were given, left-out ones included."""
        return self._report.faces

    @property
    def bounds(self) -> DoubleArray:
        """(2, 3) float64: lower and upper corner, exactly; inf and -inf for an empty tree."""
        return np.array(self._core.bounds, dtype=np.float64)

    def __getattr__(self, name: str) -> NoReturn:
        # What a Bvh has and this has not: say what to do instead.
        from .bvh import Bvh

        message = f"{type(self).__name__!r} object has no attribute {name!r}"
        if not name.startswith("_") and hasattr(Bvh, name):
            message += f": {_MISSING.get(name, _IN_FLOAT32)}"
        raise AttributeError(message)

    def __reduce__(self) -> NoReturn:
        raise TypeError(
            "a treelet.DoubleBvh cannot be pickled yet: send vertices and faces, and build it again"
        )

    def __copy__(self) -> DoubleBvh:
        return self  # it never changes

    def __deepcopy__(self, memo: dict[int, Any]) -> DoubleBvh:
        return self

    def __repr__(self) -> str:
        report = self._report
        size = f"depth {report.depth}, {report.bytes / 2**20:.1f} MiB"
        return (
            f"<treelet.DoubleBvh of {report.faces:,} faces: {report.recipe}, SAH {report.sah:.1f}, {size}, "
            f"built in {report.build_seconds * 1e3:.0f} ms>"
        )


def build_double(
    vertices: ArrayLike,
    faces: ArrayLike,
    choose_recipe: Callable[[tuple[int, ...]], str],
    *,
    updatable: bool,
    validate: bool,
) -> DoubleBvh:
    """`treelet.build` for precision="float64"; the recipe may depend on the faces' shape."""
    if as_flag(updatable, "updatable"):
        raise ValueError(
            'precision="float64" and updatable=True do not go together: a tree in float64 cannot be updated, '
            "build another one over the moved vertices"
        )
    points = as_double_vertices(vertices)
    corners = as_faces(faces, len(points))
    recipe = as_recipe(choose_recipe(corners.shape))
    return DoubleBvh(_core.build_double(points, corners, recipe, as_flag(validate, "validate")))
