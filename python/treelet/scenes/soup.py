"""Triangles that share nothing: every size and direction, thrown into a ball."""

from __future__ import annotations

import numpy as np

from ..view import View
from .shapes import Part, random_generator, sphere_directions

SUMMARY = "unconnected triangles of very different sizes, thrown into a ball: the worst case for a hierarchy"
VIEWS = (
    View((2.3, -2.6, 1.4), (0.0, 0.0, 0.0), fov_degrees=36.0, name="outside"),
    View((0.9, -1.05, 0.6), (0.0, 0.0, 0.0), fov_degrees=60.0, name="close"),
)


def build(triangles: int, seed: int) -> Part:
    """Exactly the triangles asked for, three vertices each.

    Edges shrink with the cube root of the count, so that the ball is about equally full at any size; around
    that they are log-normal, a few being twenty times the median.
    """
    generator = random_generator(seed)
    centres = sphere_directions(generator, triangles)
    centres *= np.cbrt(generator.random((triangles, 1), dtype=np.float32))
    sizes = np.exp(0.8 * generator.standard_normal((triangles, 1, 1), dtype=np.float32))
    sizes *= np.float32(0.4 / np.cbrt(triangles))
    vertices = generator.standard_normal((triangles, 3, 3), dtype=np.float32)
    vertices *= sizes
    vertices += centres[:, None]
    return vertices.reshape(-1, 3), np.arange(3 * triangles, dtype=np.int32).reshape(-1, 3)
