"""Turns what users pass into the arrays that the compiled part takes, or into an error that helps."""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Callable
from operator import index
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ._device import is_on_device
from ._offset import ORIGIN, Offset, choose_offset, finite_bounds, largest_extent, subtract_offset

FloatArray = np.ndarray[tuple[int, ...], np.dtype[np.float32]]
FaceArray = np.ndarray[tuple[int, int], np.dtype[np.uint32]]

# What the compiled part reads; a slice of bytes may not be aligned.
_PLAIN: tuple[Literal["C_CONTIGUOUS"], Literal["ALIGNED"]] = ("C_CONTIGUOUS", "ALIGNED")
_ROUNDING_TO_WARN = 2.0**-20  # of the extent: 16 times what a mesh around the origin suffers


class PrecisionWarning(UserWarning):
    """Rounding to float32 moved vertices visibly."""


class Vertices(NamedTuple):
    """Converted vertices, how far rounding moved one at most, and what was subtracted before."""

    array: FloatArray
    rounding: float
    offset: Offset


class Points(NamedTuple):
    """Converted points: their shape without the last axis, and one a row."""

    shape: tuple[int, ...]
    array: FloatArray


class Rays(NamedTuple):
    """Converted rays: each array has one row for all rays or one a ray."""

    shape: tuple[int, ...]
    arguments: tuple[int, FloatArray, FloatArray, FloatArray, FloatArray]

    @property
    def row(self) -> int:
        """Rays in a row of the picture that they make, 0 where they make none."""
        return self.shape[-1] if len(self.shape) > 1 else 0


class Volumes(NamedTuple):
    """Converted balls or boxes: each array has one row for all or one each."""

    shape: tuple[int, ...]
    arguments: tuple[int, FloatArray, FloatArray]


def as_recipe(recipe: str) -> str:
    """The recipe, if it is text at all; what it says is judged where it is parsed."""
    if not isinstance(recipe, str):
        raise TypeError(f"recipe must be text, not {type(recipe).__name__}")
    return recipe


def as_path(path: str | os.PathLike[str]) -> str:
    """The path, if files can have such a name at all; whether there is one is judged where it is opened."""
    if b"\0" in os.fsencode(path):
        raise ValueError(f"path must be the name of a file, and {os.fspath(path)!r} holds a null character")
    return os.fspath(path)


def as_vertices(
    vertices: ArrayLike, offset: Offset | None = None, require_count: Callable[[int], None] | None = None
) -> Vertices:
    """(V, 3) float32, C-contiguous, relative to an offset.

    None chooses one: the origin for float32, which is used as it is; else near the mesh where that is far.
    `require_count` judges how many there are before anything is said of their rounding.
    """
    array = _as_numbers(vertices, "vertices")
    if array.size == 0 and array.ndim == 1:
        array = array.reshape(0, 3)
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"vertices must have shape (V, 3), not {array.shape}")
    if require_count is not None:
        require_count(len(array))
    if offset is None:
        offset = ORIGIN if _fits_float32(array.dtype) else choose_offset(array)
    local = subtract_offset(array, offset)
    rounded = _to_float32(local)
    if local.dtype == np.float32:
        return Vertices(rounded, 0.0, offset)
    rounding = _largest_rounding(local, rounded)
    _warn_of_rounding(rounding, rounded)
    return Vertices(rounded, rounding, offset)


def as_faces(faces: ArrayLike, vertex_count: int) -> FaceArray:
    """(F, 3) uint32, C-contiguous. Indices beyond 32 bits and negative ones are refused here."""
    _require_host(faces, "faces")
    array = np.asarray(faces)
    if array.size == 0 and array.ndim == 1:
        return np.empty((0, 3), np.uint32)
    if array.dtype.kind not in "iu":
        raise TypeError(f"faces must hold integers, not {array.dtype}")
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"faces must have shape (F, 3), not {array.shape}{_polygon_hint(array)}")
    if array.size and (array.min() < 0 or array.max() >= vertex_count):
        _raise_bad_index(array, vertex_count)
    return np.require(array, np.uint32, _PLAIN)


def as_rays(
    origins: ArrayLike,
    directions: ArrayLike,
    t_min: ArrayLike,
    t_max: ArrayLike,
    offset: Offset = ORIGIN,
) -> Rays:
    """Broadcast rays without repeating in memory what is one for all; origins become relative to `offset`."""
    points, vectors = _as_vectors(origins, "origins", offset), _as_vectors(directions, "directions")
    first, last = _to_float32(_as_numbers(t_min, "t_min")), _to_float32(_as_numbers(t_max, "t_max"))
    shape = broadcast_rays(points.shape, vectors.shape, first.shape, last.shape)
    rows = _rows(points, (*shape, 3), (3,)), _rows(vectors, (*shape, 3), (3,))
    return Rays(shape, (math.prod(shape), *rows, _rows(first, shape, ()), _rows(last, shape, ())))


def as_points(points: ArrayLike, name: str = "points", offset: Offset = ORIGIN) -> Points:
    """(..., 3) to rows of float32, relative to `offset`."""
    array = _as_vectors(points, name, offset)
    return Points(array.shape[:-1], array.reshape(-1, 3))


def as_spheres(
    centers: ArrayLike, radii: ArrayLike, names: tuple[str, str], offset: Offset = ORIGIN
) -> Volumes:
    """Broadcast centres and radii, which errors call by these names."""
    points, lengths = _as_vectors(centers, names[0], offset), _to_float32(_as_numbers(radii, names[1]))
    shape = _broadcast(names, points.shape[:-1], lengths.shape)
    return Volumes(shape, (math.prod(shape), _rows(points, (*shape, 3), (3,)), _rows(lengths, shape, ())))


def as_boxes(lower: ArrayLike, upper: ArrayLike, offset: Offset = ORIGIN) -> Volumes:
    """Broadcast corners of boxes."""
    corners = _as_vectors(lower, "lower", offset), _as_vectors(upper, "upper", offset)
    shape = _broadcast(("lower", "upper"), corners[0].shape[:-1], corners[1].shape[:-1])
    low, high = (_rows(corner, (*shape, 3), (3,)) for corner in corners)
    return Volumes(shape, (math.prod(shape), low, high))


def _broadcast(names: tuple[str, str], first: tuple[int, ...], second: tuple[int, ...]) -> tuple[int, ...]:
    try:
        return np.broadcast_shapes(first, second)
    except ValueError:
        raise ValueError(
            f"{names[0]} for {first} and {names[1]} for {second} cannot be broadcast against each other"
        ) from None


def broadcast_rays(
    origins: tuple[int, ...], directions: tuple[int, ...], t_min: tuple[int, ...], t_max: tuple[int, ...]
) -> tuple[int, ...]:
    """The shape that rays of arrays of these shapes have."""
    try:
        return np.broadcast_shapes(origins[:-1], directions[:-1], t_min, t_max)
    except ValueError:
        raise ValueError(
            f"origins {origins}, directions {directions}, t_min {t_min} and t_max {t_max} "
            "cannot be broadcast against each other"
        ) from None


def _require_host(values: object, name: str) -> None:
    if is_on_device(values):
        raise TypeError(
            f"{name} lies on a CUDA device and the rest on the host: copy it to the host, or move the tree "
            "with bvh.to('cuda')"
        )


def _as_numbers(values: ArrayLike, name: str) -> np.ndarray[Any, np.dtype[Any]]:
    _require_host(values, name)
    array = np.asarray(values)
    if array.dtype.kind not in "fiu":
        raise TypeError(f"{name} must hold real numbers, not {array.dtype}")
    return array


def _as_vectors(values: ArrayLike, name: str, offset: Offset = ORIGIN) -> FloatArray:
    array = _as_numbers(values, name)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise ValueError(f"{name} must have shape (..., 3), not {array.shape}")
    return _to_float32(subtract_offset(array, offset))


def _fits_float32(dtype: np.dtype[Any]) -> bool:
    return dtype.kind == "f" and dtype.itemsize <= 4


def _to_float32(array: np.ndarray[Any, np.dtype[Any]]) -> FloatArray:
    # Beyond float32 is infinite: a limit means that, a vertex is left out. Signalling NaN become quiet ones.
    with np.errstate(over="ignore", invalid="ignore"):
        return np.require(array, np.float32, _PLAIN)


def _rows(array: FloatArray, shape: tuple[int, ...], row: tuple[int, ...]) -> FloatArray:
    """One row for all where the array has one, else one a ray."""
    if array.size == math.prod(row):
        return array.reshape(1, *row)
    return np.ascontiguousarray(np.broadcast_to(array, shape)).reshape(-1, *row)


def _largest_rounding(given: np.ndarray[Any, np.dtype[Any]], rounded: FloatArray) -> float:
    with np.errstate(invalid="ignore"):
        difference = np.abs(rounded.astype(np.float64) - given)
    return float(np.max(difference, initial=0.0, where=np.isfinite(difference)))


def _warn_of_rounding(rounding: float, rounded: FloatArray) -> None:
    extent = largest_extent(*finite_bounds(rounded))
    if rounding > _ROUNDING_TO_WARN * extent:
        warnings.warn(
            f"rounding the vertices to float32 moves them by up to {rounding:.3g}, in a mesh of extent "
            f"{extent:.3g}: subtract an offset nearer to the mesh from vertices and ray origins first",
            PrecisionWarning,
            stacklevel=4,
        )


def _polygon_hint(array: np.ndarray[Any, np.dtype[Any]]) -> str:
    return ": triangulate the polygons first" if array.ndim == 2 and array.shape[1] > 3 else ""


def _raise_bad_index(faces: np.ndarray[Any, np.dtype[Any]], vertex_count: int) -> None:
    face, corner = np.argwhere((faces < 0) | (faces >= vertex_count))[0]
    vertices = f"has vertices 0 to {vertex_count - 1}" if vertex_count else "has no vertices"
    raise ValueError(f"face {face} refers to vertex {faces[face, corner]}, but the mesh {vertices}")


def as_count(value: object, name: str) -> int:
    """A whole number from 1 on; TypeError or ValueError for anything else."""
    if isinstance(value, bool | np.bool_):
        raise TypeError(f"{name} must be a whole number, not {type(value).__name__}")
    try:
        count = index(value)  # type: ignore[arg-type]
    except TypeError:
        raise TypeError(f"{name} must be a whole number, not {type(value).__name__}") from None
    if count < 1:
        raise ValueError(f"{name} must be at least 1, not {count}")
    return count


def as_flag(value: object, name: str) -> bool:
    """A bool, or numpy's; TypeError for anything else, for which True is seldom what is meant."""
    if isinstance(value, bool | np.bool_):
        return bool(value)
    raise TypeError(f"{name} must be True or False, not {type(value).__name__}")
