"""A fractal landscape: a height field that rain has worn."""

from __future__ import annotations

import numpy as np

from ..view import View
from .shapes import Floats, Part, grid_faces, random_generator

SUMMARY = "a fractal mountain range: one regular height field, eroded valleys and sharp ridges"
_SIZE = 10.0  # length of a side
_TABLE = 256  # the noise repeats after so many lattice cells
_ROWS_AT_ONCE = 1 << 20  # vertices of a block, so that 50M triangles need no large temporaries


def build(triangles: int, seed: int) -> Part:
    """Two triangles a cell of a square grid, within 3 % of those asked for. Ten units wide, z up."""
    columns = max(2, round(np.sqrt(triangles / 2.0)))
    rows = max(2, round(triangles / (2 * columns)))
    vertices = np.empty((rows + 1, columns + 1, 3), dtype=np.float32)
    vertices[..., 0] = np.linspace(-_SIZE / 2, _SIZE / 2, columns + 1, dtype=np.float32)
    vertices[..., 1] = np.linspace(-_SIZE / 2, _SIZE / 2, rows + 1, dtype=np.float32)[:, None]
    octaves = int(np.clip(np.log2(columns), 5, 12))
    block = max(1, _ROWS_AT_ONCE // columns)
    for start in range(0, rows + 1, block):
        part = vertices[start : start + block]
        part[..., 2] = heights(part[..., 0], part[..., 1], seed, octaves)
    return vertices.reshape(-1, 3), grid_faces(rows + 1, columns + 1)


def views(vertices: Floats) -> tuple[View, ...]:
    """Views that stand above the ground, wherever the seed has put the mountains."""
    middle = float(vertices[:, 2].mean())
    return (
        View((-7.0, -9.2, middle + 6.0), (0.2, 0.3, middle - 0.5), fov_degrees=40.0, name="overview"),
        _standing_view(vertices, (-3.4, -3.9), (1.2, 1.6), 0.9, "ridge"),
        _standing_view(vertices, (3.0, -2.6), (-2.2, 2.0), 0.35, "valley"),
    )


def heights(x: Floats, y: Floats, seed: int, octaves: int) -> Floats:
    """Heights at positions in [-5, 5]: octaves of noise, each the weaker the steeper the ground already is.

    Damping by the gradient leaves flat valleys and sharp crests, as erosion does (Quilez, "Value noise
    derivatives").
    """
    table = random_generator(seed, 1).random((_TABLE, _TABLE), dtype=np.float32)
    u, v = x * np.float32(0.42) + np.float32(97.3), y * np.float32(0.42) + np.float32(61.7)
    total, slope_u, slope_v = np.zeros_like(u), np.zeros_like(u), np.zeros_like(u)
    amplitude = np.float32(1.0)
    for _ in range(octaves):
        value, gradient_u, gradient_v = _noise(table, u, v)
        slope_u += gradient_u
        slope_v += gradient_v
        total += amplitude * value / (np.float32(1.0) + slope_u * slope_u + slope_v * slope_v)
        amplitude *= np.float32(0.5)
        # Turned by the angle of a 3-4-5 triangle and doubled: no two octaves share a lattice.
        u, v = np.float32(1.6) * u - np.float32(1.2) * v, np.float32(1.2) * u + np.float32(1.6) * v
    return np.float32(1.5) * total


def _noise(table: Floats, u: Floats, v: Floats) -> tuple[Floats, Floats, Floats]:
    """Value noise in [0, 1] with its two derivatives, smooth to the second."""
    column, row = np.floor(u), np.floor(v)
    s, t = u - column, v - row
    i, j = column.astype(np.int32), row.astype(np.int32)
    low, high = j % _TABLE * _TABLE, (j + 1) % _TABLE * _TABLE
    left, right = i % _TABLE, (i + 1) % _TABLE
    flat = table.reshape(-1)
    a, b, c, d = flat[low + left], flat[low + right], flat[high + left], flat[high + right]
    fade_s, fade_t = s * s * s * (s * (6 * s - 15) + 10), t * t * t * (t * (6 * t - 15) + 10)
    steep_s, steep_t = 30 * s * s * (s * (s - 2) + 1), 30 * t * t * (t * (t - 2) + 1)
    twist = a - b - c + d
    value = a + (b - a) * fade_s + (c - a) * fade_t + twist * fade_s * fade_t
    return value, steep_s * ((b - a) + twist * fade_t), steep_t * ((c - a) + twist * fade_s)


def _standing_view(
    vertices: Floats, eye: tuple[float, float], target: tuple[float, float], above: float, name: str
) -> View:
    ground = [
        vertices[np.abs(vertices[:, :2] - np.array(point)).sum(axis=1).argmin(), 2] for point in (eye, target)
    ]
    return View(
        (*eye, float(ground[0]) + above), (*target, float(ground[1]) + 0.1), fov_degrees=55.0, name=name
    )
