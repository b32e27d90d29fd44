"""The hairball: curled strands from one centre, long thin tubes everywhere through each other."""

from __future__ import annotations

import numpy as np

from ..view import View
from .shapes import Floats, Part, dot, random_generator, sphere_directions, tubes, unit

SUMMARY = "curled strands of hair around one centre: long thin triangles, nowhere a gap to split at"
VIEWS = (
    View((2.2, -2.5, 1.1), (0.0, 0.0, 0.0), fov_degrees=35.0, name="outside"),
    View((0.95, -1.15, 0.7), (0.1, 0.0, 0.1), fov_degrees=50.0, name="close"),
    View((0.62, -0.55, 0.32), (-0.3, 0.4, -0.1), fov_degrees=70.0, name="inside"),
)
_FULL_STRANDS, _FULL_SEGMENTS, _SIDES = 2000, 120, 6
_LENGTH = 3.2  # of a strand, in radii of the ball


def build(triangles: int, seed: int) -> Part:
    """strands x segments x 12 triangles, within 5 %; 2 880 000 are 2000 strands of 120 segments.

    Other counts change strands and segments; strands grow thicker as they grow fewer, and taper to 30 %.
    """
    scale = triangles / (_FULL_STRANDS * _FULL_SEGMENTS * 2 * _SIDES)
    segments = int(np.clip(round(_FULL_SEGMENTS * scale ** (1 / 3)), 8, 240))
    strands = max(1, round(triangles / (segments * 2 * _SIDES)))
    paths = _strands(random_generator(seed), strands, segments)
    root_radius = 0.005 * (_FULL_STRANDS / strands) ** 0.4
    radii = root_radius * np.linspace(1.0, 0.3, segments + 1)
    return tubes(paths, radii.astype(np.float32)[None], _SIDES)


def _strands(generator: np.random.Generator, strands: int, segments: int) -> Floats:
    """Walks (strands, segments + 1, 3) from the centre, each curling around its own axis, within radius 1."""
    paths = np.empty((strands, segments + 1, 3), dtype=np.float32)
    direction = sphere_directions(generator, strands)
    paths[:, 0] = 0.08 * direction
    axis = sphere_directions(generator, strands)
    curl = 2.0 + 5.0 * generator.random((strands, 1), dtype=np.float32)
    step = np.float32(_LENGTH / segments)
    for segment in range(segments):
        position = paths[:, segment]
        radius = np.sqrt(dot(position, position))
        # Past eight tenths of the radius the strand turns back, the harder the further out it is.
        inwards = np.maximum(radius - np.float32(0.8), 0.0) * np.float32(60.0)
        outwards = np.float32(0.8) * np.maximum(np.float32(1.0) - radius, 0.0)
        turn = curl * np.cross(axis, direction) + (outwards - inwards) * unit(position)
        axis = unit(axis + np.float32(1.2) * np.sqrt(step) * sphere_directions(generator, strands))
        direction = unit(direction + step * turn)
        paths[:, segment + 1] = position + step * direction
    return paths
