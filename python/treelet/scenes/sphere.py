"""A smooth ball of latitude rings: closed, convex, every answer known in advance."""

from __future__ import annotations

import numpy as np

from ..view import View
from .shapes import Part, grid_faces

SUMMARY = "a closed unit ball of latitude rings: the mesh whose every answer is known"
VIEWS = (
    View((2.1, -2.4, 1.5), (0.0, 0.0, 0.0), fov_degrees=38.0, name="outside"),
    View((0.0, -1.35, 0.75), (0.0, 0.0, 0.35), fov_degrees=60.0, name="close"),
)


def build(triangles: int, seed: int) -> Part:
    """2 x segments x (rings - 1) triangles, within 2 % of those asked for. The seed changes nothing."""
    rings = max(3, round(np.sqrt(triangles) / 2.0))
    segments = max(3, round(triangles / (2 * (rings - 1))))
    polar = np.pi * np.arange(1, rings) / rings
    azimuth = 2.0 * np.pi * np.arange(segments) / segments
    vertices = np.empty((2 + (rings - 1) * segments, 3), dtype=np.float32)
    vertices[0], vertices[-1] = (0.0, 0.0, -1.0), (0.0, 0.0, 1.0)
    lattice = vertices[1:-1].reshape(rings - 1, segments, 3)
    lattice[..., 0] = np.outer(np.sin(polar), np.cos(azimuth))
    lattice[..., 1] = np.outer(np.sin(polar), np.sin(azimuth))
    lattice[..., 2] = -np.cos(polar)[:, None]
    here = np.arange(segments, dtype=np.int32)
    following = (here + 1) % np.int32(segments)
    south = np.stack([np.zeros_like(here), 1 + following, 1 + here], axis=-1)
    last_ring, pole = 1 + (rings - 2) * segments, len(vertices) - 1
    north = np.stack([last_ring + here, last_ring + following, np.full_like(here, pole)], axis=-1)
    faces = np.concatenate([south, grid_faces(rings - 1, segments, wrap=True) + np.int32(1), north])
    return vertices, faces.astype(np.int32, copy=False)
