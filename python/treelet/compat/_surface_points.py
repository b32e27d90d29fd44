"""Points on triangles in float64, for answers whose triangle a float32 tree has found."""

from __future__ import annotations

import numpy as np

from .._inputs import FloatArray
from ._mesh_tree import Float64Array, IndexArray, MeshTree

_GRAZING = 1e-3  # sine of ray and plane: below, a ray rounded to float32 meets the plane elsewhere
_ROUNDING = 2.0**-21  # of coordinates in float32, some times over
_TIE = 2.0**-48  # of coordinates in float64, some times over


def points_on_rays(
    origins: Float64Array, directions: Float64Array, corners: Float64Array, u: FloatArray, v: FloatArray
) -> Float64Array:
    """Where each ray meets the plane of its triangle; of grazing ones the point (u, v) of the triangle.

    All of shape (n, 3), but corners (n, 3, 3), u and v (n,).
    """
    first, edges = corners[:, 0], corners[:, 1:] - corners[:, :1]
    normals = np.cross(edges[:, 0], edges[:, 1])
    slope = _dot(normals, directions)
    lengths = np.linalg.norm(normals, axis=1) * np.linalg.norm(directions, axis=1)
    is_grazing = ~(np.abs(slope) > _GRAZING * lengths)
    t = _dot(normals, first - origins) / np.where(is_grazing, 1.0, slope)
    points = origins + t[:, None] * directions
    weights = np.stack([u, v], axis=1).astype(np.float64)
    points[is_grazing] = (first + np.einsum("ni,nij->nj", weights, edges))[is_grazing]
    return points


def nearest_faces(tree: MeshTree, points: Float64Array, face: IndexArray) -> tuple[IndexArray, Float64Array]:
    """Nearest faces and their nearest points, from a nearest face of each point; all points are finite.

    Of the faces that share the nearest point, the one whose normal points to the query most.
    """
    closest, is_inside = nearest_on_triangles(points, tree.corners(face))
    face = face.copy()
    shared = np.flatnonzero(~is_inside)
    extent = float(np.ptp(tree.bvh.bounds, axis=0).max(initial=0))
    local = np.abs(closest[shared] - tree.bvh.offset)  # what the tree has rounded to float32
    reach = _ROUNDING * (extent + local.max(axis=1, initial=0))
    touching = tree.bvh.overlap_spheres(closest[shared], reach)
    row = shared[np.repeat(np.arange(len(shared)), np.diff(touching.offsets))]
    rival = touching.face.astype(np.int64)
    corners = tree.corners(rival)
    place, _ = nearest_on_triangles(points[row], corners)
    distance = np.linalg.norm(points[row] - place, axis=1)
    shortest = np.linalg.norm(points - closest, axis=1)
    np.minimum.at(shortest, row, distance)
    is_tied = distance <= shortest[row] + _TIE * np.abs(points[row]).max(axis=1, initial=0) + _TIE * extent
    # Last of a row wins: the face that is turned to the point most, and of equal ones the smaller.
    order = np.lexsort((-rival, _facing(points[row] - place, corners), row))
    order = order[is_tied[order]]
    face[row[order]], closest[row[order]] = rival[order], place[order]
    return face, closest


def nearest_on_triangles(points: Float64Array, corners: Float64Array) -> tuple[Float64Array, np.ndarray]:
    """The nearest point of triangle i to point i, (n, 3), and whether it is inside of the triangle, (n,)."""
    edges = np.roll(corners, -1, axis=1) - corners
    along = np.einsum("nij,nij->ni", points[:, None] - corners, edges)
    squares = np.einsum("nij,nij->ni", edges, edges)
    fraction = np.clip(along / np.where(squares > 0, squares, 1.0), 0.0, 1.0)
    on_edges = corners + fraction[:, :, None] * edges
    gaps = points[:, None] - on_edges
    best = np.einsum("nij,nij->ni", gaps, gaps).argmin(axis=1)
    closest = on_edges[np.arange(len(points)), best]

    normals = np.cross(edges[:, 0], edges[:, 1])
    inward = np.cross(normals[:, None], edges)
    is_inside = (np.einsum("nij,nij->ni", points[:, None] - corners, inward) > 0).all(axis=1)
    n, inner = normals[is_inside], points[is_inside]
    height = _dot(inner - corners[is_inside, 0], n) / _dot(n, n)
    closest[is_inside] = inner - height[:, None] * n
    return closest, is_inside


def _facing(vectors: Float64Array, corners: Float64Array) -> Float64Array:
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    return np.asarray(_dot(vectors, normals) / np.where(lengths > 0, lengths, 1.0))


def _dot(first: Float64Array, second: Float64Array) -> Float64Array:
    return np.asarray(np.einsum("ni,ni->n", first, second))
