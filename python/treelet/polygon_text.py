"""The two text formats of polygons, OBJ and OFF, read with the order of the file kept.

General loaders sort OBJ faces by material and quads after triangles; a BVH's face ids are only useful if face
i of the file is face i of the mesh. So these two are read here, and need no package but numpy.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

Row = tuple[int, list[str]]  # the number of a line, from 1, and its words
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
    """Vertices (V, 3) and triangles (F, 3) of a Wavefront OBJ; materials, normals, textures are skipped.

    Raises ValueError with the number of the line for one that cannot be understood.
    """
    vertices: list[list[float]] = []
    corners: list[int] = []
    counts: list[int] = []
    for number, words in _rows(_joined_lines(text)):
        if words[0] == "v":
            vertices.append(_point(words[1:], number))
        elif words[0] == "f":
            corners.extend(_obj_index(word, len(vertices), number) for word in words[1:])
            counts.append(len(words) - 1)
    return _arrays(vertices, corners, counts)


def _joined_lines(text: str) -> Iterator[tuple[int, str]]:
    """Numbered lines, those that end in a backslash joined with the next."""
    begun = ""
    for number, line in enumerate(text.splitlines(), start=1):
        if line.endswith("\\"):
            begun += line[:-1] + " "
            continue
        yield number, begun + line
        begun = ""
    if begun:
        yield number, begun


def _obj_index(word: str, vertices_so_far: int, number: int) -> int:
    """OBJ counts from 1, or backwards from the last vertex with -1."""
    index = _whole_number(word.split("/", 1)[0], number)
    if index == 0:
        raise ValueError(f"line {number}: a face names vertex 0, but OBJ counts from 1")
    return index - 1 if index > 0 else index + vertices_so_far


def read_off(text: str) -> Arrays:
    """Vertices (V, 3) and triangles (F, 3) of an Object File Format text; colours and normals are skipped.

    Raises ValueError for points of other than three dimensions, and with the number of the line for one
    that cannot be understood.
    """
    rows = list(_rows(enumerate(text.splitlines(), start=1)))
    _check_off_kind(rows[0][1] if rows else [])
    number, words = rows.pop(0)
    if len(words) > 1:
        rows.insert(0, (number, words[1:]))  # the counts may follow in the same line
    vertex_count, face_count = _off_counts(*rows.pop(0)) if rows else (0, 0)
    if len(rows) < vertex_count + face_count:
        raise ValueError(
            f"{vertex_count} vertices and {face_count} faces are announced, but only {len(rows)} lines follow"
        )
    vertices = [_point(words, number) for number, words in rows[:vertex_count]]
    polygons = [_off_face(*row) for row in rows[vertex_count : vertex_count + face_count]]
    corners = [corner for polygon in polygons for corner in polygon]
    return _arrays(vertices, corners, [len(polygon) for polygon in polygons])


def _check_off_kind(words: list[str]) -> None:
    """ST, C and N announce what follows the coordinates; 4 and n points of other dimensions."""
    kind = re.fullmatch(r"(?:ST)?C?N?(4?n?)OFF", words[0]) if words else None
    if kind is None:
        raise ValueError("its first word is not OFF")
    if kind[1]:
        raise ValueError(f"it is of kind {words[0]}, but only points of three dimensions can be read")
    if words[1:2] == ["BINARY"]:
        raise ValueError("it is a binary OFF, but only the text format can be read")


def _off_counts(number: int, words: list[str]) -> tuple[int, int]:
    counts = [_whole_number(word, number) for word in words[:2]]
    if len(counts) < 2 or min(counts) < 0:
        raise ValueError(f"line {number}: the numbers of vertices and faces must stand here")
    return counts[0], counts[1]


def _off_face(number: int, words: list[str]) -> list[int]:
    count = _whole_number(words[0], number)
    if not 0 <= count < len(words):
        raise ValueError(f"line {number}: a face of {count} corners names {len(words) - 1} vertices")
    return [_whole_number(word, number) for word in words[1 : 1 + count]]


def _rows(lines: Iterator[tuple[int, str]] | enumerate[str]) -> Iterator[Row]:
    """The words of each line that has any, comments left out."""
    for number, line in lines:
        words = line.split("#", 1)[0].split()
        if words:
            yield number, words


def _point(words: list[str], number: int) -> list[float]:
    if len(words) < 3:
        raise ValueError(f"line {number}: a vertex has {len(words)} coordinates, but needs 3")
    try:
        return [float(word) for word in words[:3]]
    except ValueError:
        raise ValueError(f"line {number}: {' '.join(words[:3])!r} are not three numbers") from None


def _whole_number(word: str, number: int) -> int:
    try:
        return int(word)
    except ValueError:
        raise ValueError(f"line {number}: {word!r} is not a whole number") from None


def _arrays(vertices: list[list[float]], corners: list[int], counts: list[int]) -> Arrays:
    faces = triangulate_fans(np.array(corners, dtype=np.int64), np.array(counts, dtype=np.int64))
    return np.array(vertices, dtype=np.float64).reshape(-1, 3), faces
