"""Directions around a normal."""

from __future__ import annotations

import numpy as np

Array = np.ndarray


def normalized(vectors: Array) -> Array:
    """Unit vectors of (..., 3); zero vectors stay zero."""
    length = np.sqrt(np.einsum("...i,...i->...", vectors, vectors))[..., None]
    return np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0.0)


def frame_around(normal: Array) -> tuple[Array, Array]:
    """Two unit vectors that make an orthonormal frame with `normal` (..., 3), without branches.

    [Duff2017 "Building an orthonormal basis, revisited"]
    """
    x, y, z = normal[..., 0], normal[..., 1], normal[..., 2]
    sign = np.copysign(np.float32(1.0), z)
    a = np.float32(-1.0) / (sign + z)
    b = x * y * a
    tangent = np.stack([1.0 + sign * x * x * a, sign * b, -sign * x], axis=-1)
    bitangent = np.stack([b, sign + y * y * a, -y], axis=-1)
    return tangent, bitangent


def cosine_directions(normal: Array, first: Array, second: Array) -> Array:
    """Unit directions around unit `normal` (..., 3), density cosine / pi, from uniform numbers in [0, 1)."""
    radius = np.sqrt(first)
    angle = np.float32(2.0 * np.pi) * second
    tangent, bitangent = frame_around(normal)
    along = np.sqrt(np.float32(1.0) - first)[..., None] * normal
    return (
        along
        + (radius * np.cos(angle))[..., None] * tangent
        + (radius * np.sin(angle))[..., None] * bitangent
    )


def cone_directions(axis: Array, half_angle: float, first: Array, second: Array) -> Array:
    """Unit directions spread evenly over a cone of `half_angle` radians around unit `axis` (3,)."""
    cosine = 1.0 - first * np.float32(1.0 - np.cos(half_angle))
    sine = np.sqrt(np.maximum(1.0 - cosine * cosine, 0.0))
    angle = np.float32(2.0 * np.pi) * second
    axis = np.asarray(axis, dtype=np.float32)
    tangent, bitangent = frame_around(axis)
    across = (sine * np.cos(angle))[..., None] * tangent + (sine * np.sin(angle))[..., None] * bitangent
    return cosine[..., None] * axis + across
