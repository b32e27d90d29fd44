"""PLY, the polygon format of scanners, text and binary, read with the order of the file kept."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .polygon_text import triangulate_fans

Arrays = tuple[NDArray[Any], NDArray[Any]]

_TYPES = {"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4"}
_TYPES |= {"float": "f4", "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2"}
_TYPES |= {"int32": "i4", "uint32": "u4", "float32": "f4", "float64": "f8"}
_FORMATS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_CORNERS = ("vertex_indices", "vertex_index")


@dataclass(frozen=True)
class _Property:
    name: str
    type: str  # of numpy, without byte order
    count_type: str = ""  # of a list; empty for a number


@dataclass
class _Element:
    name: str
    count: int
    properties: list[_Property] = field(default_factory=list)

    @property
    def has_lists(self) -> bool:
        return any(each.count_type for each in self.properties)


def read_ply(content: bytes) -> Arrays:
    """Vertices (V, 3) in the file's precision, and triangles (F, 3): each polygon a fan, in order.

    Raises ValueError for a header that cannot be understood and a body shorter than it announces.
    """
    order, elements, start = _read_header(content)
    body = _Binary(content, start, order) if order else _Text(content[start:])
    vertices, corners = np.zeros((0, 3), np.float32), np.zeros(0, np.int64)
    counts = np.zeros(0, np.int64)
    for element in elements:
        columns = body.lists(element) if element.has_lists else body.table(element)
        if element.name == "vertex":
            vertices = _positions(columns)
        elif element.name == "face":
            corners, counts = next((columns[name] for name in _CORNERS if name in columns), (corners, counts))
    return vertices, triangulate_fans(corners.astype(np.int64), counts)


def _positions(columns: dict[str, Any]) -> NDArray[Any]:
    missing = [axis for axis in "xyz" if not isinstance(columns.get(axis), np.ndarray)]
    if missing:
        raise ValueError(f"its vertices have no {missing[0]}")
    return np.stack([columns[axis] for axis in "xyz"], axis=-1)


def _read_header(content: bytes) -> tuple[str, list[_Element], int]:
    """Byte order (empty for text), elements, and where the body starts."""
    end = content.find(b"end_header")
    line_end = content.find(b"\n", end)
    if not content.startswith(b"ply") or end < 0 or line_end < 0:
        raise ValueError("damaged: it has no whole header, from the word ply to end_header")
    order, elements = None, list[_Element]()
    for line in content[:end].decode("ascii", "replace").splitlines()[1:]:
        words = line.split()
        try:
            if words[:1] == ["format"]:
                order = _FORMATS[words[1]]
            elif words[:1] == ["element"]:
                elements.append(_Element(words[1], int(words[2])))
            elif words[:1] == ["property"]:
                elements[-1].properties.append(_property(words[1:]))
        except (KeyError, IndexError, ValueError):
            raise ValueError(f"damaged: its header says {line.strip()!r}") from None
    if order is None or any(element.count < 0 for element in elements):
        raise ValueError("damaged: its header names no format, or a negative count")
    return order, elements, line_end + 1


def _property(words: list[str]) -> _Property:
    if words[0] == "list":
        return _Property(words[3], _TYPES[words[2]], _TYPES[words[1]])
    return _Property(words[1], _TYPES[words[0]])


class _Binary:
    """The elements of a binary body, one after another."""

    def __init__(self, content: bytes, start: int, order: str) -> None:
        self._content, self._at, self._order = content, start, order

    def table(self, element: _Element) -> dict[str, Any]:
        """The columns of an element without lists."""
        if not element.properties:
            return {}
        row = np.dtype([(each.name, self._order + each.type) for each in element.properties])
        if self._at + element.count * row.itemsize > len(self._content):
            raise _cut_off(element)
        rows = np.frombuffer(self._content, row, element.count, self._at)
        self._at += rows.nbytes
        return {each.name: rows[each.name] for each in element.properties}

    def lists(self, element: _Element) -> dict[str, Any]:
        """Each list as (all items one after another, how many a row has); numbers are passed over."""
        if element.count == 0:
            return {}
        return self._lists_of_one_length(element) or self._lists_of_any_length(element)

    def _lists_of_one_length(self, element: _Element) -> dict[str, Any] | None:
        """All rows at once, if each list is as long as in the first; else None, and nothing is consumed."""
        start, fields, lengths = self._at, [], {}
        at = start
        for index, each in enumerate(element.properties):
            if each.count_type:
                count, at = self._number(at, each.count_type, element)
                lengths[each.name] = count
                fields.append((f"count {index}", self._order + each.count_type))
            length = lengths.get(each.name, 1)
            fields.append((each.name, self._order + each.type, (length,)))
            at += length * np.dtype(each.type).itemsize
        if start + element.count * (at - start) > len(self._content):
            return None
        row = np.dtype(fields)
        rows = np.frombuffer(self._content, row, element.count, start)
        for index, each in enumerate(element.properties):
            if each.count_type and (rows[f"count {index}"] != lengths[each.name]).any():
                return None
        self._at = start + rows.nbytes
        return {name: (rows[name].ravel(), np.full(len(rows), size)) for name, size in lengths.items()}

    def _lists_of_any_length(self, element: _Element) -> dict[str, Any]:
        """Row by row: where a list begins is known only after the one before it."""
        found: dict[str, list[NDArray[Any]]] = {
            each.name: [] for each in element.properties if each.count_type
        }
        at = self._at
        for _ in range(element.count):
            for each in element.properties:
                count = 1
                if each.count_type:
                    count, at = self._number(at, each.count_type, element)
                end = at + count * int(each.type[1:])
                if end > len(self._content):
                    raise _cut_off(element)
                if each.count_type:
                    found[each.name].append(np.frombuffer(self._content, self._order + each.type, count, at))
                at = end
        self._at = at
        return {name: _joined(lists) for name, lists in found.items()}

    def _number(self, at: int, type_: str, element: _Element) -> tuple[int, int]:
        """A count and where it ends."""
        end = at + int(type_[1:])
        if end > len(self._content):
            raise _cut_off(element)
        count = int.from_bytes(self._content[at:end], "little" if self._order == "<" else "big")
        return count, end


class _Text:
    """The elements of a text body, one after another."""

    def __init__(self, body: bytes) -> None:
        self._words, self._at = body.split(), 0

    def table(self, element: _Element) -> dict[str, Any]:
        """The columns of an element without lists."""
        width = len(element.properties)
        words = self._take(element.count * width, element)
        rows = np.array(words, dtype=np.bytes_).reshape(element.count, width)
        with np.errstate(over="ignore"):  # beyond float32 is infinite
            return {
                each.name: rows[:, index].astype("f8").astype("f4" if each.type == "f4" else "f8")
                for index, each in enumerate(element.properties)
            }

    def lists(self, element: _Element) -> dict[str, Any]:
        """Each list as (all items one after another, how many a row has); numbers are passed over."""
        found: dict[str, list[NDArray[Any]]] = {
            each.name: [] for each in element.properties if each.count_type
        }
        for _ in range(element.count):
            for each in element.properties:
                if not each.count_type:
                    self._take(1, element)
                    continue
                count = int(self._take(1, element)[0])
                found[each.name].append(
                    np.array(self._take(count, element), dtype=np.bytes_).astype(np.int64)
                )
        return {name: _joined(lists) for name, lists in found.items()}

    def _take(self, count: int, element: _Element) -> list[bytes]:
        words = self._words[self._at : self._at + count]
        if len(words) < count or count < 0:
            raise _cut_off(element)
        self._at += count
        return words


def _joined(lists: list[NDArray[Any]]) -> Arrays:
    counts = np.array([len(each) for each in lists], dtype=np.int64)
    return np.concatenate([np.zeros(0, np.int64), *lists]), counts


def _cut_off(element: _Element) -> ValueError:
    return ValueError(
        f"damaged: it ends within the {element.count} rows of {element.name!r} that it announces"
    )
