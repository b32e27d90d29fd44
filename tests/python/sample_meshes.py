"""Small meshes whose every hit is known."""

from __future__ import annotations

import numpy as np

TRIANGLE_VERTICES = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
TRIANGLE_FACES = np.array([[0, 1, 2]], np.int32)


def grid(cells: int) -> tuple[np.ndarray, np.ndarray]:
    """The unit square at z = 0 as cells by cells quads of two triangles each."""
    across, along = np.meshgrid(*[np.linspace(0, 1, cells + 1)] * 2, indexing="ij")
    vertices = np.stack([across, along, np.zeros_like(across)], axis=-1).reshape(-1, 3)
    corner = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    quads = np.stack([corner, corner + cells + 1, corner + cells + 2, corner + 1], axis=1)
    return vertices.astype(np.float32), split_quads(quads)


def torus(around: int, across: int) -> tuple[np.ndarray, np.ndarray]:
    """A closed torus about the z axis, radii 1 and 0.4, its normals outwards."""
    phi, theta = np.meshgrid(
        np.arange(around) * (2 * np.pi / around), np.arange(across) * (2 * np.pi / across), indexing="ij"
    )
    radius = 1 + 0.4 * np.cos(theta)
    vertices = np.stack([radius * np.cos(phi), radius * np.sin(phi), 0.4 * np.sin(theta)], axis=-1)
    ring, spoke = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    next_ring, next_spoke = (ring + 1) % around, (spoke + 1) % across
    quads = np.stack(
        [
            ring * across + spoke,
            next_ring * across + spoke,
            next_ring * across + next_spoke,
            ring * across + next_spoke,
        ],
        axis=-1,
    )
    return vertices.reshape(-1, 3).astype(np.float32), split_quads(quads.reshape(-1, 4))


def split_quads(quads: np.ndarray) -> np.ndarray:
    """(N, 4) to (2 N, 3) int32."""
    return quads[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3).astype(np.int32)


def random_triangles(count: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Separate triangles about 0.1 long in the unit cube."""
    rng = np.random.default_rng(seed)
    corners = rng.random((count, 1, 3)) + 0.1 * rng.standard_normal((count, 3, 3))
    return corners.reshape(-1, 3).astype(np.float32), np.arange(3 * count, dtype=np.int32).reshape(-1, 3)
