"""What a ray hits, computed without rounding: slow, and right by construction.

A float32 is an integer times 2^-149, so everything about float32 rays and triangles can be decided in
Python's integers. Nothing here is shared with the code under test.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fractions import Fraction

import numpy as np

_SCALE = 2**149

Vector = tuple[int, int, int]


def exact_hit(origin: np.ndarray, direction: np.ndarray, triangle: np.ndarray) -> Fraction | None:
    """The t at which the ray's line meets the triangle (3, 3), or None where it passes beside or edge-on.

    Edges and vertices belong to the triangle. t counts in units of the direction's length.
    """
    start, along = _integers(origin), _integers(direction)
    a, b, c = (_difference(_integers(corner), start) for corner in triangle)
    weights = (_triple(along, b, c), _triple(along, c, a), _triple(along, a, b))
    if min(weights) < 0 < max(weights) or sum(weights) == 0:
        return None
    numerator = sum(weight * _dot(corner, along) for weight, corner in zip(weights, (a, b, c), strict=True))
    return Fraction(numerator, sum(weights) * _dot(along, along))


def exact_hits(
    origin: np.ndarray, direction: np.ndarray, corners: np.ndarray, faces: Iterable[int]
) -> dict[int, Fraction]:
    """t of each of these faces that the ray meets at t >= 0; corners (F, 3, 3) are all faces' ones."""
    hits = {}
    for face in faces:
        triangle = corners[face]
        if not np.isfinite(triangle).all() or _has_equal_vertices(triangle):
            continue
        t = exact_hit(origin, direction, triangle)
        if t is not None and t >= 0:
            hits[int(face)] = t
    return hits


def fault(t: float, face: int, exact: Mapping[int, Fraction]) -> str | None:
    """Why (t, face) is not the closest of the exact hits of the same ray; None where it is.

    t may be one float32 off. A hit that is nearer by less than that may be passed over, but not one of
    exactly equal t and a smaller face.
    """
    if face < 0:
        return f"missed face {min(exact, key=exact.__getitem__)}" if exact else None
    if face not in exact:
        return f"does not meet face {face}"
    rounding = _rounding(exact[face])
    if abs(Fraction(float(t)) - exact[face]) > rounding:
        return f"t is {t}, not {float(exact[face])}"
    for other, other_t in exact.items():
        if other_t < exact[face] - rounding:
            return f"face {other} is nearer than face {face}"
        if other_t == exact[face] and other < face:
            return f"face {other} is as near as face {face} and smaller"
    return None


def kind_of_difference(face: int, other_face: int, exact: Mapping[int, Fraction]) -> str:
    """How another tracer went wrong, if it did, that reports other_face where face is right.

    tie: both are hit at the same t, to rounding. edge miss: it lost the hit and reports none or a farther
    one. wrong face: the ray does not meet what it reports.
    """
    if other_face < 0:
        return "edge miss"
    if other_face not in exact:
        return "wrong face"
    is_tie = exact[other_face] <= exact[face] + _rounding(exact[face])
    return "tie" if is_tie else "edge miss"


def _rounding(t: Fraction) -> Fraction:
    """One unit in the last place of t as float32."""
    return Fraction(float(np.spacing(np.float32(float(t)))))


def _integers(point: np.ndarray) -> Vector:
    x, y, z = (_integer(float(coordinate)) for coordinate in point)
    return x, y, z


def _integer(value: float) -> int:
    numerator, denominator = value.as_integer_ratio()
    return numerator * (_SCALE // denominator)


def _difference(p: Vector, q: Vector) -> Vector:
    return p[0] - q[0], p[1] - q[1], p[2] - q[2]


def _dot(p: Vector, q: Vector) -> int:
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]


def _triple(d: Vector, p: Vector, q: Vector) -> int:
    """d . (p x q): on which side of the edge from p to q the line passes."""
    return (
        d[0] * (p[1] * q[2] - p[2] * q[1])
        + d[1] * (p[2] * q[0] - p[0] * q[2])
        + d[2] * (p[0] * q[1] - p[1] * q[0])
    )


def _has_equal_vertices(triangle: np.ndarray) -> bool:
    a, b, c = triangle
    return bool((a == b).all() or (b == c).all() or (c == a).all())
