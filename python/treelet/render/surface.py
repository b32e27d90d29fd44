"""Where rays touch the mesh, and where the next rays may start."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from treelet.render.arrays import Array, dot, module_of
from treelet.render.directions import normalized

_LARGEST = float(np.finfo(np.float32).max)
# 32 units in the last place of float32: several times what the error sources below can add up to.
_OFFSET = 32.0 * float(np.finfo(np.float32).eps)


@dataclass(frozen=True)
class Surface:
    """The hits of a batch of rays, misses left out."""

    ray: Array  # (n,) int64, which rays of the batch hit
    t: Array  # (n,) float32
    points: Array  # (n, 3) float64, on the triangle
    normals: Array  # (n, 3) float32, unit, on the side the ray came from
    origins: Array  # (n, 3) float32, where a next ray may start without hitting its own triangle

    def __len__(self) -> int:
        return len(self.ray)


class Triangles:
    """Corners and face normals of a mesh, ready for looking up hits."""

    def __init__(self, vertices: Array, faces: Array, xp=np) -> None:
        with np.errstate(over="ignore"):  # what becomes infinite is not in the tree
            self._vertices = xp.asarray(vertices, dtype=np.float32)
        self._faces = xp.asarray(faces)

    def surface(self, hits, directions: Array) -> Surface:
        """The surface under `hits` of rays with `directions` (n, 3)."""
        xp = module_of(directions)
        ray = xp.flatnonzero(hits.face >= 0)
        t = hits.t[ray]
        corners = self._vertices[self._faces[hits.face[ray]]].astype(np.float64)
        edge_u, edge_v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        # From the barycentrics, not from origin + t * direction: the error then does not grow with the
        # ray's length.
        points = corners[:, 0] + hits.u[ray][:, None] * edge_u + hits.v[ray][:, None] * edge_v
        normals = normalized(xp.cross(edge_u, edge_v))
        facing = dot(normals, directions[ray])
        normals = xp.where(facing[:, None] > 0.0, -normals, normals)
        return Surface(ray, t, points, normals.astype(np.float32), offset_origins(points, normals, t))


def offset_origins(points: Array, normals: Array, t: Array) -> Array:
    """Points moved off their surface along `normals`, (n, 3) float32.

    Two errors could put a secondary ray's origin behind its own triangle, and both are relative: rounding
    `points` to float32 moves them by some ulps of the largest coordinate |P|, and the hit's u, v carry the
    rounding of a distance of length t. An absolute epsilon would be too small at 1e7 and larger than the
    whole scene at 1e-7.
    """
    xp = module_of(points)
    distance = _OFFSET * (xp.abs(points).max(axis=1) + t.astype(np.float64))
    moved = points + distance[:, None] * normals
    return xp.clip(moved, -_LARGEST, _LARGEST).astype(np.float32)
