"""What a ray in float64 hits, in whole numbers of any size: right by construction at any magnitude."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from typing import NamedTuple

import numpy as np

Vector = tuple[int, int, int]


class ExactPlace(NamedTuple):
    """Where a line meets a triangle."""

    t: Fraction
    u: Fraction
    v: Fraction


def exact_places(
    origin: Iterable[float], direction: Iterable[float], corners: np.ndarray
) -> dict[int, ExactPlace]:
    """Where the ray's line meets each of the triangles (F, 3, 3) that it meets; edges belong to them."""
    scale = _scale(np.concatenate([np.ravel(corners), np.ravel(list(origin))]))
    along_scale = _scale(np.ravel(list(direction)))
    start, along = _integers(origin, scale), _integers(direction, along_scale)
    places = {}
    for face, triangle in enumerate(corners):
        place = _place(start, along, [_integers(corner, scale) for corner in triangle])
        if place is not None:
            places[face] = ExactPlace(place.t * Fraction(along_scale, scale), place.u, place.v)
    return places


def closest(
    places: dict[int, ExactPlace], t_min: float = 0.0, t_max: float = np.inf
) -> tuple[float, int, float, float]:
    """(t, face, u, v) of the smallest t, rounded to nearest, in the limits; of equal t the smaller face."""
    hits = []
    for face, place in places.items():
        t = as_float(place.t)
        if t_min <= t <= t_max and t < np.inf:
            hits.append((t, face, as_float(place.u), as_float(place.v)))
    return min(hits, default=(np.inf, -1, 0.0, 0.0))


def as_float(value: Fraction) -> float:
    """To the nearest float64 (Python divides whole numbers so)."""
    try:
        return value.numerator / value.denominator
    except OverflowError:
        return np.inf if value > 0 else -np.inf


def _place(start: Vector, along: Vector, triangle: list[Vector]) -> ExactPlace | None:
    a, b, c = (_difference(corner, start) for corner in triangle)
    weights = (_triple(along, b, c), _triple(along, c, a), _triple(along, a, b))
    total = sum(weights)
    if min(weights) < 0 < max(weights) or total == 0:
        return None
    return ExactPlace(
        Fraction(_triple(a, b, c), total), Fraction(weights[1], total), Fraction(weights[2], total)
    )


def _scale(values: np.ndarray) -> int:
    return max(float(value).as_integer_ratio()[1] for value in values)


def _integers(point: Iterable[float], scale: int) -> Vector:
    x, y, z = (
        numerator * (scale // denominator)
        for numerator, denominator in (float(value).as_integer_ratio() for value in point)
    )
    return x, y, z


def _difference(p: Vector, q: Vector) -> Vector:
    return p[0] - q[0], p[1] - q[1], p[2] - q[2]


def _triple(d: Vector, p: Vector, q: Vector) -> int:
    return (
        d[0] * (p[1] * q[2] - p[2] * q[1])
        + d[1] * (p[2] * q[0] - p[0] * q[2])
        + d[2] * (p[0] * q[1] - p[1] * q[0])
    )
