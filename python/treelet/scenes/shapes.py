"""Templates, instances and joining: what every procedural scene is made of.

Nothing here calls BLAS, whose sums depend on the number of threads: the same seed gives the same bytes.
A part is a pair of vertices (V, 3) float32 and faces (F, 3) int32.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.floating[Any]]
Ints = NDArray[np.int32]
Part = tuple[Floats, Ints]

# Corner i of the unit box is at the bits of i; the outside of every face sees its corners counter-clockwise.
BOX_FACES: Ints = np.array(
    [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4],
     [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5]],
    dtype=np.int32,
)  # fmt: skip
BOX_CORNERS: Floats = np.array([[i & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)], dtype=np.float32) * 2 - 1


def random_generator(seed: int, *stream: int) -> np.random.Generator:
    """An independent stream of numbers for each (seed, stream)."""
    return np.random.Generator(np.random.PCG64([seed, *stream]))


def boxes(centres: ArrayLike, half_sizes: ArrayLike, taper: ArrayLike = 1.0) -> Part:
    """Closed boxes, 12 triangles each, from centres and half_sizes (N, 3).

    taper: the width of the top (+z) over that of the bottom, a scalar or (N,).
    """
    centre = np.asarray(centres, dtype=np.float32).reshape(-1, 1, 3)
    half = np.broadcast_to(np.asarray(half_sizes, dtype=np.float32), (len(centre), 3)).reshape(-1, 1, 3)
    vertices = centre + half * BOX_CORNERS
    narrow = np.broadcast_to(np.asarray(taper, dtype=np.float32), (len(centre),)).reshape(-1, 1, 1)
    vertices[:, 4:, :2] = centre[..., :2] + half[..., :2] * BOX_CORNERS[4:, :2] * narrow
    return vertices.reshape(-1, 3), repeat_faces(BOX_FACES, len(centre), 8)


def repeat_faces(faces: Ints, count: int, vertex_count: int) -> Ints:
    """The faces of `count` copies of a template of `vertex_count` vertices, one after another."""
    starts = np.arange(count, dtype=np.int32) * np.int32(vertex_count)
    return (starts[:, None, None] + faces[None]).reshape(-1, 3)


def grid_faces(rows: int, columns: int, wrap: bool = False) -> Ints:
    """Two triangles a cell of a lattice of rows x columns vertices; wrap joins the last to the first."""
    row = np.arange(rows - 1, dtype=np.int32)[:, None] * np.int32(columns)
    column = np.arange(columns if wrap else columns - 1, dtype=np.int32)[None]
    following = (column + 1) % np.int32(columns)
    faces = np.empty((rows - 1, column.shape[1], 2, 3), dtype=np.int32)
    faces[..., 0, 0] = faces[..., 1, 0] = row + column
    faces[..., 0, 1] = row + following
    faces[..., 0, 2] = faces[..., 1, 1] = row + following + np.int32(columns)
    faces[..., 1, 2] = row + column + np.int32(columns)
    return faces.reshape(-1, 3)


def tubes(paths: Floats, radii: ArrayLike, sides: int, first_normals: Floats | None = None) -> Part:
    """Open tubes along polylines: 2 x sides x (K - 1) triangles each.

    paths: (N, K, 3); radii: broadcast to (N, K). The ring's frame is carried along the path without twist,
    from a normal across the first segment.
    """
    count, knots, _ = paths.shape
    radius = np.broadcast_to(np.asarray(radii, dtype=np.float32), (count, knots))
    angles = (np.arange(sides) * (2.0 * np.pi / sides)).astype(np.float32)
    cosines, sines = np.cos(angles)[None, :, None], np.sin(angles)[None, :, None]
    vertices = np.empty((count, knots, sides, 3), dtype=np.float32)
    normal = _any_perpendicular(unit(paths[:, 1] - paths[:, 0])) if first_normals is None else first_normals
    for knot in range(knots):
        tangent = unit(paths[:, min(knot + 1, knots - 1)] - paths[:, max(knot - 1, 0)])
        normal = unit(normal - tangent * dot(normal, tangent))
        binormal = np.cross(tangent, normal)
        ring = normal[:, None] * cosines + binormal[:, None] * sines
        vertices[:, knot] = paths[:, knot, None] + radius[:, knot, None, None] * ring
    faces = repeat_faces(grid_faces(knots, sides, wrap=True), count, knots * sides)
    return vertices.reshape(-1, 3), faces


def unit(vectors: Floats) -> Floats:
    """Vectors scaled to length one; zero stays zero."""
    return vectors / np.maximum(np.sqrt(dot(vectors, vectors)), np.float32(1e-20))


def dot(a: Floats, b: Floats) -> Floats:
    """The inner product along the last axis, which is kept."""
    return (a * b).sum(axis=-1, keepdims=True)


def sphere_directions(generator: np.random.Generator, count: int) -> Floats:
    """Directions (count, 3), uniform over the sphere."""
    return unit(generator.standard_normal((count, 3), dtype=np.float32))


def join(parts: list[Part]) -> Part:
    """All parts as one. Empties the list as it goes, so that no more than one part is ever held twice."""
    vertex_count = sum(len(vertices) for vertices, _ in parts)
    face_count = sum(len(faces) for _, faces in parts)
    vertices = np.empty((vertex_count, 3), dtype=np.float32)
    faces = np.empty((face_count, 3), dtype=np.int32)
    vertex_end, face_end = vertex_count, face_count
    while parts:
        part_vertices, part_faces = parts.pop()
        vertex_start, face_start = vertex_end - len(part_vertices), face_end - len(part_faces)
        vertices[vertex_start:vertex_end] = part_vertices
        np.add(part_faces, np.int32(vertex_start), out=faces[face_start:face_end])
        vertex_end, face_end = vertex_start, face_start
    return vertices, faces


def _any_perpendicular(directions: Floats) -> Floats:
    """A unit vector across each direction."""
    helper = np.zeros_like(directions)
    smallest = np.abs(directions).argmin(axis=-1)
    np.put_along_axis(helper, smallest[:, None], 1.0, axis=-1)
    return unit(np.cross(directions, helper))
