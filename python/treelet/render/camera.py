"""A pinhole camera from a `treelet.view.View`."""

from __future__ import annotations

import numpy as np

from treelet.render.arrays import Array
from treelet.render.directions import normalized


class Camera:
    """Rays of a pinhole camera; `view.fov_degrees` is the vertical angle of the picture."""

    def __init__(self, view, width: int, height: int, xp=np) -> None:
        self.width, self.height, self._xp = width, height, xp
        self.eye = np.asarray(view.eye, dtype=np.float64)
        self.up = normalized(np.asarray(view.up, dtype=np.float64))
        self.forward = normalized(np.asarray(view.look_at, dtype=np.float64) - self.eye)
        right = np.cross(self.forward, self.up)
        if not np.any(self.forward) or np.linalg.norm(right) < 1e-6:
            raise ValueError(
                "the view needs a look_at apart from its eye, and an up that is not the viewing direction"
            )
        self.right = normalized(right)
        frame = self.forward, self.right, np.cross(self.right, self.forward)
        self._origin = xp.asarray(self.eye.astype(np.float32))
        self._frame = [xp.asarray(axis) for axis in frame]
        self._half_height = np.tan(np.radians(view.fov_degrees) / 2.0)

    @property
    def pixel_count(self) -> int:
        """Width times height."""
        return self.width * self.height

    def rays(self, pixel: Array, jitter_x: Array, jitter_y: Array) -> tuple[Array, Array]:
        """Rays through `pixel` (row * width + column), jitter in [0, 1) inside the pixel.

        Returns the origin (3,) float32, the same for all, and unit directions (n, 3) float32.
        """
        row, column = self._xp.divmod(self._xp.asarray(pixel), self.width)
        scale = 2.0 * self._half_height / self.height
        across = (column + jitter_x - 0.5 * self.width) * scale
        upwards = (0.5 * self.height - row - jitter_y) * scale
        forward, right, vertical = self._frame
        directions = forward + across[:, None] * right + upwards[:, None] * vertical
        return self._origin, normalized(directions).astype(np.float32)
