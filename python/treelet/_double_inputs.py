"""Input of trees in float64: nothing is rounded but what is no float64."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from ._inputs import _as_numbers, broadcast_rays

DoubleArray = np.ndarray[tuple[int, ...], np.dtype[np.float64]]

DoubleRayArguments = tuple[int, DoubleArray, DoubleArray, DoubleArray, DoubleArray]


def as_double_vertices(vertices: ArrayLike) -> DoubleArray:
    """(V, 3) float64, C-contiguous."""
    array = _as_doubles(vertices, "vertices")
    if array.size == 0 and array.ndim == 1:
        array = array.reshape(0, 3)
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"vertices must have shape (V, 3), not {array.shape}")
    return array


def as_double_rays(
    origins: ArrayLike, directions: ArrayLike, t_min: ArrayLike, t_max: ArrayLike
) -> tuple[tuple[int, ...], DoubleRayArguments]:
    """The shape of broadcast rays, and their number and arrays; one row for all where an array has one."""
    points, vectors = _as_vectors(origins, "origins"), _as_vectors(directions, "directions")
    first, last = _as_doubles(t_min, "t_min"), _as_doubles(t_max, "t_max")
    shape = broadcast_rays(points.shape, vectors.shape, first.shape, last.shape)
    rows = _rows(points, (*shape, 3), (3,)), _rows(vectors, (*shape, 3), (3,))
    return shape, (math.prod(shape), *rows, _rows(first, shape, ()), _rows(last, shape, ()))


def _as_vectors(values: ArrayLike, name: str) -> DoubleArray:
    array = _as_doubles(values, name)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise ValueError(f"{name} must have shape (..., 3), not {array.shape}")
    return array


def _as_doubles(values: ArrayLike, name: str) -> DoubleArray:
    with np.errstate(over="ignore"):  # a longdouble beyond float64 is infinite
        return np.require(_as_numbers(values, name), np.float64, ("C_CONTIGUOUS", "ALIGNED"))


def _rows(array: DoubleArray, shape: tuple[int, ...], row: tuple[int, ...]) -> DoubleArray:
    if array.size == math.prod(row):
        return array.reshape(1, *row)
    return np.ascontiguousarray(np.broadcast_to(array, shape)).reshape(-1, *row)
