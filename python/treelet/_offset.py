"""The offset that lets float32 hold coordinates far from the origin (docs/precision.md)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

Offset = tuple[float, float, float]
"""What is subtracted from coordinates, in float64, before they are rounded to float32."""

Bounds = np.ndarray[tuple[int, int], np.dtype[np.floating[Any]]]
_Corner = np.ndarray[Any, np.dtype[np.float64]]

ORIGIN: Offset = (0.0, 0.0, 0.0)

_FAR = 2.0  # extents from the origin: nearer, an offset would win a bit or two


def choose_offset(vertices: np.ndarray[Any, np.dtype[Any]]) -> Offset:
    """Near the middle of the mesh along each axis on which that is far from the origin, else 0.

    A multiple of a power of two near the largest extent. So each difference to a vertex is exact in the
    vertices' own type: both are multiples of the vertex's last bit, and the difference is the smaller.
    """
    low, high = finite_bounds(vertices)
    extent = largest_extent(low, high)
    if extent == 0.0 or not math.isfinite(extent):
        return ORIGIN
    step = 2.0 ** math.floor(math.log2(extent))
    x, y, z = _round_far(low / 2 + high / 2, extent, step).tolist()
    return x, y, z


def _round_far(middle: _Corner, extent: float, step: float) -> Any:
    is_far = np.abs(middle) > _FAR * extent
    has_steps = np.abs(middle) < 2.0**52 * step  # else its own last bit is a step or more
    with np.errstate(over="ignore", invalid="ignore"):
        rounded = np.where(has_steps, np.round(middle / step) * step, middle)
    return np.where(is_far, rounded, 0.0)


def finite_bounds(vertices: np.ndarray[Any, np.dtype[Any]]) -> tuple[_Corner, _Corner]:
    """Lowest and highest corner, float64, of those vertices that are finite; zeros where none is."""
    if len(vertices) == 0:
        return np.zeros(3), np.zeros(3)
    # By column, ten times as fast as along the axis; NaN and infinity show in one of both.
    with np.errstate(over="ignore"):
        low, high = (
            np.array([reduce(vertices[:, axis]) for axis in range(3)]).astype(np.float64)
            for reduce in (np.min, np.max)
        )
        if np.isfinite(low).all() and np.isfinite(high).all():
            return low, high
        return finite_bounds(vertices[np.isfinite(vertices.astype(np.float64)).all(axis=1)])


def largest_extent(low: _Corner, high: _Corner) -> float:
    """Of a box; infinite where it is too large for a float64."""
    with np.errstate(over="ignore"):
        return float((high - low).max())


def add_offset(bounds: np.ndarray[Any, np.dtype[np.float32]], offset: Offset) -> Bounds:
    """Corners in the mesh's own coordinates: float64 unless the offset is the origin."""
    return bounds if offset == ORIGIN else np.asarray(bounds + np.array(offset))


def subtract_offset(array: np.ndarray[Any, np.dtype[Any]], offset: Offset) -> np.ndarray[Any, np.dtype[Any]]:
    """Coordinates (..., 3) relative to an offset; the array itself where that is the origin."""
    return array if offset == ORIGIN else np.asarray(array - np.array(offset))
