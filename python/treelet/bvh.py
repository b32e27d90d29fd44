"""The tree: what `treelet.build` returns."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from . import _core
from ._inputs import FloatArray, as_faces, as_rays, as_recipe, as_vertices
from .report import Report

__all__ = ["Bvh", "Hits", "Work", "build", "intersect_brute_force"]


class Hits(NamedTuple):
    """Closest hits, one a ray, in the rays' shape. The hit point is (1-u-v) P0 + u P1 + v P2 of `face`."""

    t: FloatArray
    """float32, in units of the direction's length; inf for a miss."""
    face: np.ndarray[tuple[int, ...], np.dtype[np.int32]]
    """int32 index into the faces that were given; -1 for a miss."""
    u: FloatArray
    """float32; 0 for a miss."""
    v: FloatArray
    """float32; 0 for a miss."""


class Work(NamedTuple):
    """What finding each ray's closest hit took, in the rays' shape."""

    nodes: np.ndarray[tuple[int, ...], np.dtype[np.uint32]]
    """uint32: nodes whose children's boxes were tested."""
    triangles: np.ndarray[tuple[int, ...], np.dtype[np.uint32]]
    """uint32: triangles tested."""


class Bvh:
    """A bounding volume hierarchy over a triangle mesh; immutable, safe to query from many threads.

    It owns a copy of the triangles. Every query takes any leading shape: origins and directions (..., 3)
    and t_min and t_max (...) are broadcast against each other, and the answers have the broadcast shape.
    Rays are rounded to float32. Rays with a NaN or infinite origin or direction, a zero direction or a
    NaN limit miss.
    """

    def __init__(self, core: _core.Bvh, vertex_rounding: float = 0.0) -> None:
        """Not for users: call `treelet.build`."""
        self._core = core
        self._report = Report(core, vertex_rounding)

    def intersect(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
    ) -> Hits:
        """Find the closest hit of each ray: the smallest t in [t_min, t_max], of equal t the smaller face.

        Watertight: no ray slips between triangles that share an edge or a vertex.

        Args:
            origins: (..., 3) float.
            directions: (..., 3) float, of any length but zero; t counts in it.
            t_min: (...) or scalar.
            t_max: (...) or scalar, included.

        Returns:
            Hits(t, face, u, v), arrays of the broadcast leading shape.

        Raises:
            ValueError: where the shapes do not fit each other.
            TypeError: where an array does not hold numbers.
        """
        rays = as_rays(origins, directions, t_min, t_max)
        return Hits(*(array.reshape(rays.shape) for array in _core.intersect(self._core, *rays.arguments)))

    def occluded(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
    ) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
        """Whether each ray hits anything in [t_min, t_max]. Arguments and errors as `intersect`.

        Returns:
            bool array of the broadcast leading shape. Faster than `intersect`: the first hit found ends it.
        """
        rays = as_rays(origins, directions, t_min, t_max)
        return _core.occluded(self._core, *rays.arguments).reshape(rays.shape)

    def traversal_cost(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
    ) -> Work:
        """Count the work that `intersect` does for each ray. Arguments and errors as `intersect`.

        The counts are the same on every machine, so they compare trees where timings are noisy.
        """
        rays = as_rays(origins, directions, t_min, t_max)
        counts = _core.traversal_cost(self._core, *rays.arguments)
        return Work(*(array.reshape(rays.shape) for array in counts))

    def validate(self, vertices: ArrayLike | None = None, faces: ArrayLike | None = None) -> list[str]:
        """List what is wrong with the tree, at most 20 sentences; empty for a sound one.

        Given the mesh again, it also checks that the tree holds that mesh's triangles, none missing.
        """
        if (vertices is None) != (faces is None):
            raise TypeError("validate takes both vertices and faces, or neither")
        if vertices is None:
            return self._core.validate()
        points = as_vertices(vertices).array
        return self._core.validate_against(points, as_faces(faces, len(points)))

    @property
    def report(self) -> Report:
        """What the build did: times, costs, counts, bytes."""
        return self._report

    @property
    def face_count(self) -> int:
        """Faces that were given, left-out ones included."""
        return self._report.faces

    @property
    def bounds(self) -> np.ndarray[tuple[int, int], np.dtype[np.float32]]:
        """(2, 3) float32: lower and upper corner; inf and -inf for an empty tree."""
        return np.array(self._core.bounds, dtype=np.float32)

    def __repr__(self) -> str:
        report = self._report
        size = f"depth {report.depth}, {report.bytes / 2**20:.1f} MiB"
        return (
            f"<treelet.Bvh of {report.faces:,} faces: {report.recipe}, SAH {report.sah:.1f}, {size}, "
            f"built in {report.build_seconds * 1e3:.0f} ms>"
        )


def build(
    vertices: ArrayLike,
    faces: ArrayLike,
    recipe: str = "balanced",
    *,
    validate: bool = False,
) -> Bvh:
    """Build a tree over a triangle mesh.

    Triangles with a NaN or infinite vertex, and triangles with two equal vertices, are left out and counted
    in the report. An empty mesh gives a tree that every ray misses. The same input and recipe give the same
    tree, whatever the number of threads.

    Args:
        vertices: (V, 3) float32. Other numbers are rounded to float32; where that moves a vertex by more
            than a millionth of the mesh's extent, a `treelet.PrecisionWarning` says so.
        faces: (F, 3) integer indices into vertices.
        recipe: the name of a preset (see `treelet.presets`) or the text of a recipe, such as
            "lbvh > treelet(size=8) > bvh8" (see `treelet.recipe_words`).
        validate: check the tree after every stage; about doubles the time.

    Raises:
        ValueError: for a wrong shape, a face index out of range (the first is named) or a bad recipe.
        TypeError: for arrays that do not hold numbers, faces that are no integers, a recipe that is no text.
        RuntimeError: where validation finds a violation, which is a bug in treelet.
    """
    points = as_vertices(vertices)
    corners = as_faces(faces, len(points.array))
    return Bvh(_core.build(points.array, corners, as_recipe(recipe), validate), points.rounding)


def intersect_brute_force(
    vertices: ArrayLike,
    faces: ArrayLike,
    origins: ArrayLike,
    directions: ArrayLike,
    t_min: ArrayLike = 0.0,
    t_max: ArrayLike = np.inf,
) -> Hits:
    """Answer `Bvh.intersect` by testing every triangle: slow, for checking. Arguments and errors as there."""
    points = as_vertices(vertices).array
    corners = as_faces(faces, len(points))
    rays = as_rays(origins, directions, t_min, t_max)
    hits = _core.intersect_brute_force(points, corners, *rays.arguments)
    return Hits(*(array.reshape(rays.shape) for array in hits))
