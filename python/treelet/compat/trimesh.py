"""Ray and proximity queries as trimesh has them: `trimesh.ray` and `trimesh.proximity` (docs/compat.md).

mesh.ray = treelet.compat.trimesh.RayMeshIntersector(mesh)  # a trimesh.Trimesh

trimesh itself is not needed: any object with `vertices` and `faces` will do.
"""

from __future__ import annotations

from typing import Any, Literal, overload

import numpy as np
from numpy.typing import ArrayLike

from ._mesh_tree import Float64Array, IndexArray, KeptTree, MeshLike, MeshTree, tree_of
from ._surface_points import nearest_faces, points_on_rays

__all__ = ["ProximityQuery", "RayMeshIntersector", "closest_point", "signed_distance"]

BoolArray = np.ndarray[tuple[int, ...], np.dtype[np.bool_]]

_ON_SURFACE = 1e-8  # trimesh.constants.tol.merge: so near, distances are positive on both sides


class RayMeshIntersector:
    """Ray queries of one mesh, with the methods of `trimesh.ray.ray_pyembree.RayMeshIntersector`.

    The tree is built at the first query, and again after vertices or faces changed. Rays have origins and
    directions (n, 3); a direction may have any length that float32 can hold but zero.
    """

    def __init__(self, geometry: MeshLike, scale_to_box: bool = True) -> None:
        """Take the mesh, a `trimesh.Trimesh` or any object with `vertices` and `faces`.

        Args:
            geometry: the mesh.
            scale_to_box: has no effect: answers do not depend on the mesh's size.
        """
        self.mesh = geometry
        self._kept = KeptTree()

    @overload
    def intersects_id(
        self,
        ray_origins: ArrayLike,
        ray_directions: ArrayLike,
        multiple_hits: bool = ...,
        max_hits: int = ...,
        return_locations: Literal[False] = ...,
    ) -> tuple[IndexArray, IndexArray]: ...

    @overload
    def intersects_id(
        self,
        ray_origins: ArrayLike,
        ray_directions: ArrayLike,
        multiple_hits: bool = ...,
        max_hits: int = ...,
        *,
        return_locations: Literal[True],
    ) -> tuple[IndexArray, IndexArray, Float64Array]: ...

    def intersects_id(
        self,
        ray_origins: ArrayLike,
        ray_directions: ArrayLike,
        multiple_hits: bool = True,
        max_hits: int = 100,
        return_locations: bool = False,
    ) -> tuple[Any, ...]:
        """Find the triangles that rays hit: the first hits of all rays, then the second ones, and so on.

        Args:
            ray_origins: (n, 3) float.
            ray_directions: (n, 3) float.
            multiple_hits: every hit of a ray instead of the first alone.
            max_hits: of a ray; the nearest ones.
            return_locations: add where the hits lie.

        Returns:
            index_tri and index_ray, (h,) int64, and if asked for locations, (h, 3) float64.

        Raises:
            ValueError: for other shapes, or max_hits less than 1.
        """
        if multiple_hits and max_hits < 1:
            raise ValueError(f"max_hits must be at least 1, not {max_hits}")
        origins, directions = _as_rays(ray_origins, ray_directions)
        tree = self._kept.of(self.mesh)
        if multiple_hits:
            found = _all_hits(tree, origins, directions, max_hits)
        else:
            found = _first_hits(tree, origins, directions)
        index_tri, index_ray, u, v = found
        if not return_locations:
            return index_tri, index_ray
        rays = origins[index_ray], directions[index_ray]
        return index_tri, index_ray, points_on_rays(*rays, tree.corners(index_tri), u, v)

    def intersects_location(
        self, ray_origins: ArrayLike, ray_directions: ArrayLike, multiple_hits: bool = True
    ) -> tuple[Float64Array, IndexArray, IndexArray]:
        """Find where rays hit. Arguments, order and errors as `intersects_id`.

        Returns:
            locations, (h, 3) float64, index_ray and index_tri, (h,) int64.
        """
        index_tri, index_ray, locations = self.intersects_id(
            ray_origins, ray_directions, multiple_hits, return_locations=True
        )
        return locations, index_ray, index_tri

    def intersects_first(self, ray_origins: ArrayLike, ray_directions: ArrayLike) -> IndexArray:
        """The triangle that each ray hits first, (n,) int64; -1 for a miss. Arguments as `intersects_id`."""
        hits = self._kept.of(self.mesh).bvh.intersect(*_as_rays(ray_origins, ray_directions))
        return hits.face.astype(np.int64)

    def intersects_any(self, ray_origins: ArrayLike, ray_directions: ArrayLike) -> BoolArray:
        """Whether each ray hits the mesh, (n,) bool. Arguments as `intersects_id`."""
        return self._kept.of(self.mesh).bvh.occluded(*_as_rays(ray_origins, ray_directions))

    def contains_points(self, points: ArrayLike) -> BoolArray:
        """Whether each point (n, 3) is inside of the mesh, (n,) bool; false outside of its bounds.

        Exact for closed meshes, as `treelet.Bvh.contains`.
        """
        return _contain(self._kept.of(self.mesh), _as_points(points, "points"))


class ProximityQuery:
    """Proximity queries of one mesh, with the methods of `trimesh.proximity.ProximityQuery`."""

    def __init__(self, mesh: MeshLike) -> None:
        self._mesh = mesh
        self._kept = KeptTree()

    def on_surface(self, points: ArrayLike) -> tuple[Float64Array, Float64Array, IndexArray]:
        """As `closest_point`."""
        return _nearest(self._kept.of(self._mesh), _as_points(points, "points"))

    def signed_distance(self, points: ArrayLike) -> Float64Array:
        """As the function `signed_distance`."""
        return _signed_distance(self._kept.of(self._mesh), _as_points(points, "points"))

    def vertex(self, points: ArrayLike) -> tuple[Float64Array, IndexArray]:
        """Find the vertex nearest to each point (n, 3). Needs scipy.

        Returns:
            distance, (n,) float64, and vertex_id, (n,) int64.

        Raises:
            ImportError: where there is no scipy.
        """
        given = _as_points(points, "points")
        tree = getattr(self._mesh, "kdtree", None)
        if tree is None:
            from scipy.spatial import cKDTree

            tree = cKDTree(np.asarray(self._mesh.vertices, dtype=np.float64))
        distance, vertex_id = tree.query(given)
        return np.asarray(distance, np.float64), np.asarray(vertex_id, np.int64)


def closest_point(mesh: MeshLike, points: ArrayLike) -> tuple[Float64Array, Float64Array, IndexArray]:
    """Find the point of the mesh that is nearest to each point.

    On an edge or a corner, of the triangles there the one that faces the point most.

    Args:
        mesh: a `trimesh.Trimesh` or any object with `vertices` and `faces`.
        points: (n, 3) float.

    Returns:
        closest, (n, 3) float64, distance, (n,) float64, and triangle_id, (n,) int64; NaN, inf and -1 where
        there is none, in an empty mesh or for a point with NaN or infinity.

    Raises:
        ValueError: for another shape.
    """
    return _nearest(tree_of(mesh), _as_points(points, "points"))


def signed_distance(mesh: MeshLike, points: ArrayLike) -> Float64Array:
    """The distance of each point (n, 3) from the mesh, (n,) float64: positive inside, negative outside.

    That is the opposite of `treelet.Bvh.signed_distance`, so -inf where there is no nearest point, in an
    empty mesh or for a point with NaN or infinity. Arguments and errors as `closest_point`.
    """
    return _signed_distance(tree_of(mesh), _as_points(points, "points"))


def _nearest(tree: MeshTree, points: Float64Array) -> tuple[Float64Array, Float64Array, IndexArray]:
    face = tree.bvh.closest_point(points).face.astype(np.int64)
    closest = np.full(points.shape, np.nan)
    distance = np.full(len(points), np.inf)
    there = np.flatnonzero(face >= 0)
    face[there], closest[there] = nearest_faces(tree, points[there], face[there])
    distance[there] = np.linalg.norm(points[there] - closest[there], axis=1)
    return closest, distance, face


def _signed_distance(tree: MeshTree, points: Float64Array) -> Float64Array:
    _, distance, _ = _nearest(tree, points)
    return np.where(_contain(tree, points) | (distance <= _ON_SURFACE), distance, -distance)


def _contain(tree: MeshTree, points: Float64Array) -> BoolArray:
    lower, upper = tree.bvh.bounds
    # An open mesh would contain points behind it.
    is_near: BoolArray = np.all((points >= lower) & (points <= upper), axis=1)
    return np.logical_and(tree.bvh.contains(points), is_near)


def _all_hits(
    tree: MeshTree, origins: Float64Array, directions: Float64Array, max_hits: int
) -> tuple[IndexArray, IndexArray, Any, Any]:
    hits = tree.bvh.intersect_all(origins, directions, limit=max_hits)
    ray = hits.ray
    depth = np.arange(len(ray)) - hits.offsets[ray]
    order = np.argsort(depth, kind="stable")
    return hits.face[order].astype(np.int64), ray[order], hits.u[order], hits.v[order]


def _first_hits(
    tree: MeshTree, origins: Float64Array, directions: Float64Array
) -> tuple[IndexArray, IndexArray, Any, Any]:
    hits = tree.bvh.intersect(origins, directions)
    ray = np.flatnonzero(hits.face >= 0)
    return hits.face[ray].astype(np.int64), ray, hits.u[ray], hits.v[ray]


def _as_rays(origins: ArrayLike, directions: ArrayLike) -> tuple[Float64Array, Float64Array]:
    points, vectors = _as_points(origins, "ray_origins"), _as_points(directions, "ray_directions")
    if points.shape != vectors.shape:
        raise ValueError(
            f"ray_origins {points.shape} and ray_directions {vectors.shape} must have the same shape (n, 3)"
        )
    return points, vectors


def _as_points(points: ArrayLike, name: str) -> Float64Array:
    array = np.asarray(points, dtype=np.float64)
    if array.size == 0 and array.ndim == 1:
        return array.reshape(0, 3)
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"{name} must have shape (n, 3), not {array.shape}")
    return array
