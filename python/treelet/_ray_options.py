"""What a query is told about single rays and faces: which are there, and which sides of faces."""

from __future__ import annotations

from typing import Any, Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import ArrayLike

from ._core import RayFilter
from ._inputs import Rays

Cull = Literal["none", "back", "front"]
"""Sides of faces that rays pass through: a front is seen where the corners turn counter-clockwise."""

FlagArray = np.ndarray[tuple[int, ...], np.dtype[np.bool_]]

_CULLS: tuple[str, ...] = get_args(Cull)  # as numbered in C++


class Masks(NamedTuple):
    """Options of a query, as the compiled part takes them."""

    active: FlagArray | None
    """one for all rays, or one a ray"""
    faces: FlagArray | None
    cull: int

    def part(self, begin: int, end: int) -> RayFilter | None:
        """Of some of the rays; None where all options have their default."""
        if self.active is None and self.faces is None and self.cull == 0:
            return None
        active = self.active
        if active is not None and len(active) > 1:
            active = active[begin:end]
        return RayFilter(active, self.faces, self.cull)


def as_masks(
    rays: Rays, active: ArrayLike | None, face_mask: ArrayLike | None, cull: Cull, face_count: int
) -> Masks:
    """Check the options of a query and broadcast them."""
    if not isinstance(cull, str) or cull not in _CULLS:
        raise ValueError(f'cull must be "none", "back" or "front", not {cull!r}')
    flags = None if active is None else _as_ray_mask(active, rays.shape)
    faces = None if face_mask is None else _as_face_mask(face_mask, face_count)
    return Masks(flags, faces, _CULLS.index(cull))


def as_filter(
    rays: Rays, active: ArrayLike | None, face_mask: ArrayLike | None, cull: Cull, face_count: int
) -> RayFilter | None:
    """The options of all rays; None where each has its default."""
    if active is None and face_mask is None and isinstance(cull, str) and cull == "none":
        return None
    return as_masks(rays, active, face_mask, cull, face_count).part(0, rays.arguments[0])


def _as_ray_mask(active: ArrayLike, shape: tuple[int, ...]) -> FlagArray:
    flags = _as_flags(active, "active")
    try:
        full = np.broadcast_to(flags, shape)
    except ValueError:
        raise ValueError(f"active {flags.shape} does not fit rays of the shape {shape}") from None
    return flags.reshape(1) if flags.size == 1 else np.ascontiguousarray(full).reshape(-1)


def _as_face_mask(face_mask: ArrayLike, face_count: int) -> FlagArray:
    flags = _as_flags(face_mask, "face_mask")
    if flags.shape != (face_count,):
        raise ValueError(f"face_mask must have shape ({face_count},), one a face, not {flags.shape}")
    return np.ascontiguousarray(flags)


def _as_flags(values: Any, name: str) -> FlagArray:
    array = np.asarray(values)
    if array.dtype != np.bool_:
        raise TypeError(f"{name} must hold booleans, not {array.dtype}: compare first, as in `kind != 3`")
    return array
