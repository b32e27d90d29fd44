"""Rays that find mistakes: what cameras send, arbitrary ones, and those aimed at vertices and edges."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from treelet import Mesh
from treelet.view import View

# Barycentric coordinates of a triangle's vertex, middle of an edge and centre.
_TARGETS = np.array([[1, 0, 0], [0.5, 0.5, 0], [1 / 3, 1 / 3, 1 / 3]])


class Rays(NamedTuple):
    """(N, 3) float32 each."""

    origins: np.ndarray
    directions: np.ndarray


def mixed_rays(mesh: Mesh, count: int, seed: int, aimed_share: float = 0.1) -> Rays:
    """Primary rays of the mesh's views, rays through its box, and rays aimed at parts of its triangles."""
    rng = np.random.default_rng(seed)
    aimed = round(aimed_share * count)
    primary = (count - aimed) // 2 if mesh.views else 0
    sets = [aimed_rays(mesh, aimed, rng), crossing_rays(mesh, count - aimed - primary, rng)]
    if primary:
        sets += [
            primary_rays(view, len(part), rng)
            for view, part in zip(
                mesh.views, np.array_split(np.arange(primary), len(mesh.views)), strict=True
            )
        ]
    return Rays(*(np.concatenate(parts) for parts in zip(*sets, strict=True)))


def primary_rays(view: View, count: int, rng: np.random.Generator) -> Rays:
    """Rays through random points of a picture 1.6 times as wide as high."""
    forward = np.array(view.direction)
    right = np.cross(forward, view.up)
    right /= np.linalg.norm(right)
    slope = np.tan(np.radians(view.fov_degrees) / 2)
    across, above = rng.uniform(-slope, slope, (2, count, 1)) * np.array([1.6, 1.0])[:, None, None]
    directions = forward + across * right + above * np.cross(right, forward)
    return _rays(np.broadcast_to(view.eye, directions.shape), directions)


def crossing_rays(mesh: Mesh, count: int, rng: np.random.Generator) -> Rays:
    """From anywhere in or near the mesh's box to anywhere in it."""
    return _rays_towards(mesh, _points_in_box(mesh, count, rng, 1.0), rng)


def aimed_rays(mesh: Mesh, count: int, rng: np.random.Generator) -> Rays:
    """From anywhere in or near the mesh's box at vertices, middles of edges and centres of triangles."""
    triangles = mesh.vertices[rng.choice(mesh.faces, count)].astype(np.float64)
    weights = rng.permuted(_TARGETS[rng.integers(len(_TARGETS), size=count)], axis=1)
    return _rays_towards(mesh, np.einsum("nk,nkx->nx", weights, triangles), rng)


def _rays_towards(mesh: Mesh, targets: np.ndarray, rng: np.random.Generator) -> Rays:
    origins = _points_in_box(mesh, len(targets), rng, 1.5).astype(np.float32)
    return _rays(origins, targets - origins)


def _points_in_box(mesh: Mesh, count: int, rng: np.random.Generator, scale: float) -> np.ndarray:
    lower, upper = mesh.bounds.astype(np.float64)
    return (lower + upper) / 2 + rng.uniform(-scale / 2, scale / 2, (count, 3)) * (upper - lower)


def _rays(origins: np.ndarray, directions: np.ndarray) -> Rays:
    return Rays(np.asarray(origins, np.float32), np.asarray(directions, np.float32))


def as_bytes(answers) -> bytes:
    """All of the answers' arrays, to compare them to the bit."""
    return b"".join(array.tobytes() for array in answers)
