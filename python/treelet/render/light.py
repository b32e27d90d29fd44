"""Sky, sun and surface colours of the pictures. Radiance is linear RGB, float32."""

from __future__ import annotations

import numpy as np

from treelet.render.arrays import Array, dot, module_of
from treelet.render.directions import cone_directions, normalized

_ZENITH = np.array([0.30, 0.50, 0.86], dtype=np.float32)
_HORIZON = np.array([0.86, 0.90, 0.95], dtype=np.float32)
_GROUND = np.array([0.47, 0.45, 0.43], dtype=np.float32)
_BACKDROP_TOP = np.array([0.36, 0.52, 0.72], dtype=np.float32)
_BACKDROP_MIDDLE = np.array([0.86, 0.89, 0.92], dtype=np.float32)
_BACKDROP_BOTTOM = np.array([0.68, 0.70, 0.72], dtype=np.float32)
_SUN = np.array([3.6, 3.0, 2.25], dtype=np.float32)  # irradiance on a surface facing it, divided by pi
_SUN_HALF_ANGLE = 0.018  # radians, about four times the real sun: softer shadows

_LOW_ALBEDO = np.array([0.47, 0.51, 0.58], dtype=np.float32)
_HIGH_ALBEDO = np.array([0.83, 0.77, 0.67], dtype=np.float32)


class Light:
    """A clear sky around `up`, with the sun over the left shoulder of the camera."""

    def __init__(self, camera, xp=np) -> None:
        level = normalized(camera.forward - np.dot(camera.forward, camera.up) * camera.up)
        sun = 0.85 * camera.up - 0.62 * camera.right - 0.30 * level
        self._up = xp.asarray(camera.up.astype(np.float32))
        self._sun_direction = xp.asarray(normalized(sun).astype(np.float32))
        self._sun = xp.asarray(_SUN)
        self._sky = [xp.asarray(color) for color in (_ZENITH, _HORIZON, _GROUND)]
        backdrop = _BACKDROP_TOP, _BACKDROP_MIDDLE, _BACKDROP_BOTTOM
        self._backdrop = [xp.asarray(color) for color in backdrop]

    def sky(self, directions: Array) -> Array:
        """Radiance from `directions` (n, 3), without the sun."""
        return self._gradient(directions, *self._sky)

    def backdrop(self, directions: Array) -> Array:
        """What the camera sees behind the mesh, display colours (n, 3)."""
        return self._gradient(directions, *self._backdrop)

    def _gradient(self, directions: Array, top: Array, middle: Array, bottom: Array) -> Array:
        xp = module_of(directions)
        height = dot(directions, self._up)[:, None]
        above = middle + (top - middle) * xp.clip(height, 0.0, 1.0) ** np.float32(0.55)
        below = middle + (bottom - middle) * xp.clip(-2.0 * height, 0.0, 1.0)
        return xp.where(height >= 0.0, above, below)

    def towards_sun(self, first: Array, second: Array) -> Array:
        """Directions to points on the sun's disc, (n, 3)."""
        return cone_directions(self._sun_direction, _SUN_HALF_ANGLE, first, second)

    def sunlight(self, normals: Array, to_sun: Array) -> Array:
        """What an unshadowed white surface with `normals` reflects of the sun, (n, 3)."""
        return module_of(normals).maximum(dot(normals, to_sun), 0.0)[:, None] * self._sun


class Albedo:
    """Neutral clay: cool and darker at the scene's foot, warm and lighter at its top and on level faces."""

    def __init__(self, bounds: np.ndarray, up: np.ndarray, xp=np) -> None:
        self._up = xp.asarray(up)
        self._low_color, self._high_color = xp.asarray(_LOW_ALBEDO), xp.asarray(_HIGH_ALBEDO)
        corners = np.stack(np.meshgrid(*np.asarray(bounds, dtype=np.float64).T), axis=-1).reshape(-1, 3) @ up
        self._low, span = corners.min(), np.ptp(corners)
        self._inverse_span = 1.0 / span if span > 0.0 else 0.0

    def __call__(self, points: Array, normals: Array) -> Array:
        """Reflectance (n, 3) in [0, 1]."""
        xp = module_of(points)
        height = xp.clip((dot(points, self._up) - self._low) * self._inverse_span, 0.0, 1.0)
        level = xp.abs(dot(normals, self._up))
        blend = (0.25 + 0.45 * height + 0.30 * level)[:, None].astype(np.float32)
        return self._low_color + (self._high_color - self._low_color) * blend
