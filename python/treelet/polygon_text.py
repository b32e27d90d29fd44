"""The two text formats of polygons, OBJ and OFF, read with the order of the file kept.

General loaders sort OBJ faces by material and quads after triangles; a BVH's face ids are only useful if face
i of the file is face i of the mesh. So these two are read here, and need no package but numpy.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Arrays = tuple[NDArray[np.float64], NDArray[np.int64]]


def triangulate_fans(corners: NDArray[np.int64], counts: NDArray[np.int64]) -> NDArray[np.int64]:
    """The triangles (F, 3) of polygons, each a fan around its first corner, in order.

    corners: the vertex indices of all polygons one after another; counts: how many each polygon has. A
    polygon of fewer than three corners gives no triangle.
    """
    starts = np.cumsum(counts) - counts
    per_polygon = np.maximum(counts - 2, 0)
    first = np.repeat(starts, per_polygon)
    step = np.arange(len(first)) - np.repeat(np.cumsum(per_polygon) - per_polygon, per_polygon)
    return np.stack([corners[first], corners[first + step + 1], corners[first + step + 2]], axis=-1)


def read_obj(text: str) -> Arrays:
    """Vertices (V, 3) and triangles (F, 3) of a Wavefront OBJ; materials, normals, textures are skipped."""
    vertices: list[list[float]] = []
    corners: list[int] = []
    counts: list[int] = []
    for line in text.replace("\\\n", " ").splitlines():
        if line.startswith(("v ", "v\t")):
            vertices.append([float(word) for word in line.split()[1:4]])
        elif line.startswith(("f ", "f\t")):
            words = line.split("#", 1)[0].split()[1:]
            corners.extend(_obj_index(word, len(vertices)) for word in words)
            counts.append(len(words))
    return _arrays(vertices, corners, counts)


def _obj_index(word: str, vertices_so_far: int) -> int:
    """OBJ counts from 1, or backwards from the last vertex with -1."""
    index = int(word.split("/", 1)[0])
    if index == 0:
        raise ValueError("a face names vertex 0, but OBJ counts from 1")
    return index - 1 if index > 0 else index + vertices_so_far


def read_off(text: str) -> Arrays:
    """Vertices (V, 3) and triangles (F, 3) of an Object File Format text; colours and normals are skipped."""
    stripped = (line.split("#", 1)[0].split() for line in text.splitlines())
    rows = [words for words in stripped if words]
    if not rows or not rows[0][0].endswith("OFF"):
        raise ValueError("its first word is not OFF")
    rows[0] = rows[0][1:]  # the counts may follow in the same line
    if not rows[0]:
        rows.pop(0)
    vertex_count, face_count = (int(word) for word in rows[0][:2]) if rows else (0, 0)
    rows = rows[1:]
    if len(rows) < vertex_count + face_count:
        raise ValueError(
            f"{vertex_count} vertices and {face_count} faces are announced, but only {len(rows)} lines follow"
        )
    vertices = [[float(word) for word in row[:3]] for row in rows[:vertex_count]]
    polygons = [row[1 : 1 + int(row[0])] for row in rows[vertex_count : vertex_count + face_count]]
    corners = [int(word) for polygon in polygons for word in polygon]
    return _arrays(vertices, corners, [len(polygon) for polygon in polygons])


def _arrays(vertices: list[list[float]], corners: list[int], counts: list[int]) -> Arrays:
    faces = triangulate_fans(np.array(corners, dtype=np.int64), np.array(counts, dtype=np.int64))
    return np.array(vertices, dtype=np.float64).reshape(-1, 3), faces
