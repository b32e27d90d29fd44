"""Directions around a normal."""

from __future__ import annotations

import numpy as np

from treelet.render.arrays import Array, dot, module_of, ratio


def normalized(vectors: Array) -> Array:
    """Unit vectors of (..., 3); zero vectors stay zero."""
    length = module_of(vectors).sqrt(dot(vectors, vectors))[..., None]
    return ratio(vectors, length)


def frame_around(normal: Array) -> tuple[Array, Array]:
    """Two unit vectors that make an orthonormal frame with `normal` (..., 3), without branches.

    [Duff2017 "Building an orthonormal basis, revisited"]
    """
    xp = module_of(normal)
    x, y, z = normal[..., 0], normal[..., 1], normal[..., 2]
    sign = xp.copysign(np.float32(1.0), z)
    a = np.float32(-1.0) / (sign + z)
    b = x * y * a
    tangent = xp.stack([1.0 + sign * x * x * a, sign * b, -sign * x], axis=-1)
    bitangent = xp.stack([b, sign + y * y * a, -y], axis=-1)
    return tangent, bitangent


def cosine_directions(normal: Array, first: Array, second: Array) -> Array:
    """Unit directions around unit `normal` (..., 3), density cosine / pi, from uniform numbers in [0, 1)."""
    xp = module_of(first)
    radius = xp.sqrt(first)
    angle = np.float32(2.0 * np.pi) * second
    tangent, bitangent = frame_around(normal)
    along = xp.sqrt(np.float32(1.0) - first)[..., None] * normal
    return (
        along
        + (radius * xp.cos(angle))[..., None] * tangent
        + (radius * xp.sin(angle))[..., None] * bitangent
    )


def cone_directions(axis: Array, half_angle: float, first: Array, second: Array) -> Array:
    """Unit directions spread evenly over a cone of `half_angle` radians around unit `axis` (3,)."""
    xp = module_of(first)
    cosine = 1.0 - first * np.float32(1.0 - np.cos(half_angle))
    sine = xp.sqrt(xp.maximum(1.0 - cosine * cosine, 0.0))
    angle = np.float32(2.0 * np.pi) * second
    axis = xp.asarray(axis, dtype=np.float32)
    tangent, bitangent = frame_around(axis)
    across = (sine * xp.cos(angle))[..., None] * tangent + (sine * xp.sin(angle))[..., None] * bitangent
    return cosine[..., None] * axis + across
