"""Rays for comparing a tree's answers with brute force."""

from __future__ import annotations

from typing import Any

import numpy as np

Array = np.ndarray


def sample_rays(mesh: Any, bounds: Array, count: int, seed: int) -> tuple[Array, Array]:
    """Half of the rays come from far outside, half from the surface; all go to a random point of the surface.

    Every fourth aims exactly at a vertex, where a tracer that is not watertight loses rays. Origins and
    directions are (count, 3) float32, directions as long as the way to the point, where that fits.
    """
    generator = np.random.Generator(np.random.Philox(seed))
    targets, starts = (_surface_points(mesh, generator, count) for _ in range(2))
    corners = mesh.vertices[mesh.faces[generator.integers(len(mesh.faces), size=count), 0]]
    ray = np.arange(count)
    targets[ray % 4 == 0] = np.nan_to_num(corners[ray % 4 == 0], posinf=0.0, neginf=0.0)
    center, radius = bounds.mean(axis=0), np.linalg.norm(bounds[1] - bounds[0])
    outward = generator.standard_normal((count, 3))
    outside = center + radius * outward / np.linalg.norm(outward, axis=1, keepdims=True)
    largest = float(np.finfo(np.float32).max)
    origins = np.where((ray % 8 < 4)[:, None], outside, starts).clip(-largest, largest).astype(np.float32)
    way = targets - origins.astype(np.float64)
    # Across a mesh as large as float32 the way does not fit, so a quarter of it must do.
    is_too_long = np.abs(way).max(axis=1, initial=0.0, keepdims=True) > largest
    return origins, np.where(is_too_long, 0.25 * way, way).astype(np.float32)


def _surface_points(mesh: Any, generator: np.random.Generator, count: int) -> Array:
    corners = mesh.vertices[mesh.faces[generator.integers(len(mesh.faces), size=count)]].astype(np.float64)
    weights = generator.dirichlet((1.0, 1.0, 1.0), size=count)
    points = np.einsum("ij,ijk->ik", weights, corners)
    return np.where(np.isfinite(points), points, 0.0)
