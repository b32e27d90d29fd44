"""Rays of a pinhole camera, in Open3D's conventions."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .._inputs import as_count
from ._arrays import as_array

_LEAST_SINE = 1e-12  # of the angle between two directions that are not parallel


def rays_of_matrices(
    intrinsic_matrix: object, extrinsic_matrix: object, width_px: int, height_px: int
) -> NDArray[np.float32]:
    """Rays through the centres of pixels; directions have length 1 along the camera's third axis.

    `intrinsic_matrix` (3, 3) takes the camera to pixels; `extrinsic_matrix` (4, 4), a rotation and a shift,
    takes the world to the camera.
    """
    width, height = as_count(width_px, "width_px"), as_count(height_px, "height_px")
    intrinsic = _as_shape(intrinsic_matrix, "intrinsic_matrix", (3, 3))
    extrinsic = _as_shape(extrinsic_matrix, "extrinsic_matrix", (4, 4))
    if not np.isfinite(intrinsic).all() or np.linalg.matrix_rank(intrinsic) < 3:
        raise ValueError("intrinsic_matrix must have an inverse: see its focal lengths")
    to_world = extrinsic[:3, :3].T
    pixels = np.ones((height, width, 3))
    pixels[..., 0] = np.arange(width) + 0.5
    pixels[..., 1] = np.arange(height)[:, None] + 0.5
    rays = np.empty((height, width, 6), np.float32)
    rays[..., :3] = -to_world @ extrinsic[:3, 3]
    rays[..., 3:] = pixels @ (to_world @ np.linalg.inv(intrinsic)).T
    return rays


def rays_of_view(
    fov_deg: float, center: object, eye: object, up: object, width_px: int, height_px: int
) -> NDArray[np.float32]:
    """Rays from `eye`, the middle one towards `center`; `fov_deg` is horizontal.

    Rows go along `up` and columns to the left, as Open3D has them: a picture turned by 180 degrees.
    """
    if not 0 < fov_deg < 180:
        raise ValueError(f"fov_deg must lie between 0 and 180, not be {fov_deg}")
    place = _as_shape(eye, "eye", (3,))
    forward = _unit(_as_shape(center, "center", (3,)) - place, "center must differ from eye")
    along = _unit(_as_shape(up, "up", (3,)), "up must not be zero")
    right = _unit(np.cross(along, forward), "up must not be parallel to the view from eye to center")
    extrinsic = np.eye(4)
    extrinsic[:3, :3] = right, np.cross(forward, right), forward
    extrinsic[:3, 3] = -extrinsic[:3, :3] @ place
    middle = 0.5 * as_count(width_px, "width_px"), 0.5 * as_count(height_px, "height_px")
    focal_length = middle[0] / np.tan(np.radians(0.5 * fov_deg))
    intrinsic = [[focal_length, 0, middle[0]], [0, focal_length, middle[1]], [0, 0, 1]]
    return rays_of_matrices(intrinsic, extrinsic, width_px, height_px)


def _as_shape(values: object, name: str, shape: tuple[int, ...]) -> NDArray[np.float64]:
    array = as_array(values).astype(np.float64)
    if array.shape != shape:
        raise ValueError(f"{name} must have shape {shape}, not {array.shape}")
    return array


def _unit(vector: NDArray[np.float64], demand: str) -> NDArray[np.float64]:
    length = np.linalg.norm(vector)
    if not _LEAST_SINE < length < np.inf:
        raise ValueError(demand)
    return vector / length
