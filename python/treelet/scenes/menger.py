"""A block cut from the corner of an endless Menger sponge: closed, full of equal coordinates."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..view import View
from .shapes import Ints, Part

SUMMARY = "a block of Menger sponge, closed: axis-aligned faces, deep tunnels, countless equal coordinates"
VIEWS = (
    View((2.0, -1.5, 1.35), (0.5, 0.5, 0.47), fov_degrees=36.0, name="outside"),
    View((0.5, -0.42, 0.5), (0.5, 0.5, 0.5), fov_degrees=55.0, name="tunnel"),
    View((1.25, -0.3, 1.25), (0.6, 0.4, 0.7), fov_degrees=40.0, name="corner"),
)


def build(triangles: int, seed: int) -> Part:
    """The sponge's surface over w x w x h cubes, two triangles a cube face; h is what brings the count near.

    Within 10 % from 1 000 triangles on. Every edge has an even number of faces. One side of the base is one
    unit. The seed changes nothing.
    """
    width = _width(triangles // 2)
    solid = _sponge(width, triangles // 2)
    corners = _exposed_faces(solid)
    # Only the lattice points in use become vertices.
    used = np.zeros(np.prod(np.add(solid.shape, 1)), dtype=bool)
    for quads in corners:
        used[quads] = True
    points = np.flatnonzero(used)
    vertices = np.stack(np.unravel_index(points, np.add(solid.shape, 1))[::-1], axis=-1).astype(np.float32)
    vertices /= np.float32(width)
    new_index = np.cumsum(used, dtype=np.int32) - np.int32(1)
    faces = np.empty((2 * sum(map(len, corners)), 3), dtype=np.int32)
    start = 0
    for quads in corners:
        renamed = new_index[quads]
        end = start + 2 * len(quads)
        faces[start:end:2], faces[start + 1 : end : 2] = renamed[:, :3], renamed[:, [2, 3, 0]]
        start = end
    return vertices, faces


def _width(quads: int) -> int:
    """A level-n sponge is 3^n wide with 2 x 20^n + 4 x 8^n faces; between levels it is a power law."""
    level = 1.0
    while 2.0 * 20.0**level + 4.0 * 8.0**level < quads:
        level += 0.01
    return max(3, round(3.0**level))


def _solid_digits(width: int) -> list[NDArray[np.bool_]]:
    """For each base-3 digit, whether it is 1 at each of the coordinates 0 ... width - 1."""
    coordinates, digits = np.arange(width), []
    while coordinates.any():
        digits.append(coordinates % 3 == 1)
        coordinates = coordinates // 3
    return digits


def _layer(width: int, height: int) -> NDArray[np.bool_]:
    """The cubes of one layer: a cube is empty where two of its coordinates have a 1 in the same digit."""
    solid = np.ones((width, width), dtype=bool)
    for place, middle in enumerate(_solid_digits(width)):
        if height // 3**place % 3 == 1:
            solid &= ~(middle[:, None] | middle[None])
        else:
            solid &= ~(middle[:, None] & middle[None])
    return solid


def _sponge(width: int, quads: int) -> NDArray[np.bool_]:
    """Layers of cubes (height, width, width), stacked until their exposed faces come nearest to `quads`."""
    layers: list[NDArray[np.bool_]] = []
    below = np.zeros((width, width), dtype=bool)
    walls_and_steps, best = 0, quads
    while len(layers) < 3 * width:
        layer = _layer(width, len(layers))
        padded = np.pad(layer, 1)
        walls_and_steps += int(
            np.count_nonzero(padded[1:] != padded[:-1]) + np.count_nonzero(padded[:, 1:] != padded[:, :-1])
        )
        walls_and_steps += int(np.count_nonzero(layer != below))
        error = abs(walls_and_steps + int(np.count_nonzero(layer)) - quads)
        if layers and error > best:
            break
        layers.append(layer)
        below, best = layer, error
    return np.stack(layers)


def _exposed_faces(solid: NDArray[np.bool_]) -> list[Ints]:
    """The lattice points (N, 4) of each exposed face, counter-clockwise from outside, by direction."""
    strides = np.array([(solid.shape[1] + 1) * (solid.shape[2] + 1), solid.shape[2] + 1, 1], dtype=np.int64)
    exposed = []
    for axis in range(3):
        # Axes run z, y, x: `second` after `first` turns counter-clockwise around -axis.
        first, second = strides[(axis + 1) % 3], strides[(axis + 2) % 3]
        for side in (0, 1):
            cells = np.nonzero(solid & ~_neighbour(solid, axis, side))
            origin = (
                sum(cell * stride for cell, stride in zip(cells, strides, strict=True)) + side * strides[axis]
            )
            around = [0, second, first + second, first] if side else [0, first, first + second, second]
            exposed.append((origin[:, None] + np.array(around)).astype(np.int32))
    return exposed


def _neighbour(solid: NDArray[np.bool_], axis: int, side: int) -> NDArray[np.bool_]:
    """Whether the cube below (side 0) or above (side 1) along the axis is solid; outside nothing is."""
    shifted = np.zeros_like(solid)
    here = [slice(None)] * 3
    there = [slice(None)] * 3
    here[axis], there[axis] = (
        (slice(1, None), slice(None, -1)) if side == 0 else (slice(None, -1), slice(1, None))
    )
    shifted[tuple(here)] = solid[tuple(there)]
    return shifted
