"""Cameras: where a picture of a mesh is taken from."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Vector = tuple[float, float, float]

_LARGEST = float(np.finfo(np.float32).max)
_SAMPLE_FACES = 400_000  # enough for percentiles to three digits; keeps 50M triangles under a second
_OCCLUDERS = 1024
_TARGETS = 48
_AZIMUTHS = (-60, -30, -120, -150, 30, 60, 120, 150)  # degrees around up; the first wins a tie
_AXES: dict[str, Vector] = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


@dataclass(frozen=True)
class View:
    """A pinhole camera.

    `eye` and `look_at` are points and `up` a direction, in the units of the mesh; `fov_degrees` is the
    vertical field of view. Raises ValueError where no picture could be taken: a value that is not finite or
    out of float32 range, an eye at the point it looks at, an up along the line of sight, a field of view
    outside (0, 180).
    """

    eye: Vector
    look_at: Vector
    up: Vector = (0.0, 0.0, 1.0)
    fov_degrees: float = 45.0
    name: str = ""

    def __post_init__(self) -> None:
        for field in ("eye", "look_at", "up"):
            object.__setattr__(self, field, _vector(field, getattr(self, field)))
        for field in ("eye", "look_at", "up"):  # rays are float32, and squares of these must not overflow
            if max(map(abs, getattr(self, field))) > _LARGEST:
                raise ValueError(f"{field} {getattr(self, field)} is out of float32 range")
        object.__setattr__(self, "fov_degrees", float(self.fov_degrees))
        if not 0.0 < self.fov_degrees < 180.0:
            raise ValueError(f"fov_degrees must be between 0 and 180, not {self.fov_degrees:g}")
        sight = np.subtract(self.look_at, self.eye)
        if not np.any(sight):
            raise ValueError(f"eye and look_at are the same point {self.eye}")
        sideways = np.linalg.norm(np.cross(sight, self.up))
        if sideways <= 1e-6 * np.linalg.norm(sight) * np.linalg.norm(self.up):
            raise ValueError(f"up {self.up} must not be zero or along the line of sight")

    @property
    def direction(self) -> Vector:
        """The unit vector from the eye to the point looked at."""
        sight = np.subtract(self.look_at, self.eye)
        return _vector("direction", sight / np.linalg.norm(sight))


def automatic_view(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    up: str | None = None,
    fov_degrees: float = 40.0,
    aspect: float = 1.6,
    name: str = "automatic",
) -> View:
    """A view that shows most of a mesh that nobody has chosen a camera for.

    The camera looks down at the mesh from a corner, far enough to hold it in a picture of `aspect` width over
    height. A few far or huge triangles (the stadium around the teapot, a ground, a backdrop) neither move it
    away nor stand in its way: the frame is the box that holds 98 % of the triangle corners along each axis,
    and of eight directions it takes the one from which the largest triangles hide least.

    vertices: (V, 3) floats; faces: (F, 3) integers; triangles that are not finite are left out.
    up: "x", "y" or "z"; without it z, or y where the mesh has its floor there.
    """
    if up is not None and up not in _AXES:
        raise ValueError(f"up must be x, y or z, not {up!r}")
    triangles = _sample_triangles(np.asarray(vertices), np.asarray(faces))
    if len(triangles) == 0:
        return View((2.0, -3.0, 1.5), (0.0, 0.0, 0.0), fov_degrees=fov_degrees, name=name)
    bounds = _robust_bounds(triangles)
    axis = up or _guess_up(triangles, bounds)
    points = _points_inside(triangles, bounds)
    views = [_framed(points, axis, azimuth, fov_degrees, aspect, name) for azimuth in _AZIMUTHS]
    return max(views, key=_Visibility(triangles, bounds))


def _vector(field: str, value: ArrayLike) -> Vector:
    array = np.asarray(value, dtype=np.float64)
    if array.shape != (3,) or not np.all(np.isfinite(array)):
        raise ValueError(f"{field} must be three finite numbers, not {value!r}")
    return (float(array[0]), float(array[1]), float(array[2]))


def _sample_triangles(vertices: NDArray, faces: NDArray) -> NDArray[np.float64]:
    """Every n-th triangle as (N, 3 corners, 3), the finite ones only."""
    stride = max(1, math.ceil(len(faces) / _SAMPLE_FACES))
    with np.errstate(over="ignore"):  # rounded as in the tree, which leaves out what becomes infinite
        rounded = vertices[faces[::stride]].astype(np.float32)
    triangles = rounded.astype(np.float64).reshape(-1, 3, 3)
    return triangles[np.isfinite(triangles).all(axis=(1, 2))]


def _robust_bounds(triangles: NDArray[np.float64]) -> NDArray[np.float64]:
    """The (2, 3) box of 98 % of the corners along each axis, or the whole box where that is hardly larger."""
    corners = triangles.reshape(-1, 3)
    whole = np.stack([corners.min(axis=0), corners.max(axis=0)])
    most = np.percentile(corners, [1.0, 99.0], axis=0)
    if np.linalg.norm(whole[1] - whole[0]) <= 2.0 * np.linalg.norm(most[1] - most[0]):
        return whole
    return most


def _points_inside(triangles: NDArray[np.float64], bounds: NDArray[np.float64]) -> NDArray[np.float64]:
    """Up to 10 000 corners inside the bounds."""
    corners = triangles.reshape(-1, 3)
    inside = corners[((corners >= bounds[0]) & (corners <= bounds[1])).all(axis=1)]
    return inside[:: math.ceil(len(inside) / 10_000)]


def _guess_up(triangles: NDArray[np.float64], bounds: NDArray[np.float64]) -> str:
    """z, unless the mesh stands on y: up has a floor at its bottom and most of the mesh low above it."""
    crosses = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    areas = np.linalg.norm(crosses, axis=1)
    total = areas.sum()
    if total == 0.0:
        return "z"
    extents = np.maximum(bounds[1] - bounds[0], np.finfo(np.float64).tiny)
    heights = np.clip((triangles.mean(axis=1) - bounds[0]) / extents, 0.0, 1.0)

    def weight_of_gravity(axis: int) -> float:
        flat = np.where(np.abs(crosses[:, axis]) > 0.95 * areas, areas, 0.0) / total
        height = heights[:, axis]
        floor = flat[height < 0.1].sum() - flat[height > 0.9].sum()
        low = (0.5 - np.median(height)) + (0.5 - np.dot(height, areas) / total)
        return float(floor + 0.3 * low)

    return "y" if weight_of_gravity(1) > weight_of_gravity(2) + 0.02 else "z"


def _framed(
    points: NDArray[np.float64], axis: str, azimuth: float, fov_degrees: float, aspect: float, name: str
) -> View:
    """The view from one compass direction and 25 degrees above, as near as the points (N, 3) allow."""
    up = np.array(_AXES[axis])
    east, north = np.roll(up, 1), np.roll(up, 2)
    turn, rise = math.radians(azimuth), math.radians(25.0)
    back = math.cos(rise) * (math.cos(turn) * east + math.sin(turn) * north) + math.sin(rise) * up
    right = np.cross(up, back)
    right /= np.linalg.norm(right)
    frame = np.stack([right, np.cross(back, right), back])
    seen = points @ frame.T
    middle = (seen.min(axis=0) + seen.max(axis=0)) / 2.0
    across, above, nearness = (seen - middle).T
    slope = 0.92 * math.tan(math.radians(fov_degrees) / 2.0)  # leaves a margin of eight percent
    distance = float((np.maximum(np.abs(across) / aspect, np.abs(above)) / slope + nearness).max()) or 1.0
    centre = middle @ frame
    eye = np.clip(centre + distance * back, -_LARGEST, _LARGEST)  # or no room is left to step back
    return View(_vector("eye", eye), _vector("look_at", centre), _AXES[axis], fov_degrees, name)


class _Visibility:
    """How many targets inside the bounds a view sees past the largest triangles of the mesh."""

    def __init__(self, triangles: NDArray[np.float64], bounds: NDArray[np.float64]) -> None:
        centroids = triangles.mean(axis=1)
        inside = centroids[((centroids >= bounds[0]) & (centroids <= bounds[1])).all(axis=1)]
        self.targets = inside[:: max(1, len(inside) // _TARGETS)][:_TARGETS]
        self.first = triangles[:, 0]
        edges = triangles[:, 1:] - triangles[:, :1]
        areas = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
        largest = np.argsort(-areas, kind="stable")[:_OCCLUDERS]
        self.first, self.edges = self.first[largest], edges[largest]

    def __call__(self, view: View) -> int:
        origin = np.array(view.eye)
        directions = (self.targets - origin)[:, None]  # (targets, 1, 3): t = 1 is the target
        edge_1, edge_2 = self.edges[:, 0], self.edges[:, 1]
        normal_2 = np.cross(directions, edge_2)
        determinant = (normal_2 * edge_1).sum(axis=-1)
        offset = origin - self.first
        normal_1 = np.cross(offset, edge_1)
        with np.errstate(divide="ignore", invalid="ignore"):
            u = (normal_2 * offset).sum(axis=-1) / determinant
            v = (directions * normal_1).sum(axis=-1) / determinant
            t = (edge_2 * normal_1).sum(axis=-1) / determinant
            hidden = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (t > 0.0) & (t < 0.999)
        return int((~hidden.any(axis=1)).sum())
