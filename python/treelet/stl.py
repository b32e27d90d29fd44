"""STL, the format of loose triangles, binary and text."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

Arrays = tuple[NDArray[Any], NDArray[Any]]

_HEADER = 84  # bytes: free text, then how many triangles follow
_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_VERTEX = re.compile(rb"\bvertex[ \t]+(\S+)[ \t]+(\S+)[ \t]+(\S+)", re.IGNORECASE)


def read_stl(content: bytes) -> Arrays:
    """Vertices (3 F, 3), three for each triangle, and triangles (F, 3), in the order of the file.

    Binary files give float32, text float64. Raises ValueError for a file that is cut off.
    """
    count = int.from_bytes(content[80:_HEADER], "little")
    announced = _HEADER + count * _RECORD.itemsize
    # Many binary files begin with "solid" as text does, so the size decides first.
    if len(content) >= _HEADER and len(content) == announced:
        vertices = np.frombuffer(content, _RECORD, count, _HEADER)["corners"].reshape(-1, 3)
    elif _is_text(content):
        vertices = _read_text(content)
    elif len(content) < _HEADER:
        raise ValueError(f"damaged: it has {len(content)} bytes, fewer than the header's {_HEADER}")
    else:
        raise ValueError(
            f"damaged: {count} triangles are announced, which take {announced} bytes, "
            f"but it has {len(content)}"
        )
    return vertices, np.arange(len(vertices)).reshape(-1, 3)


def _is_text(content: bytes) -> bool:
    start = content[:1024].lstrip()
    return start[:5].lower() == b"solid" and b"\0" not in start


def _read_text(content: bytes) -> NDArray[np.float64]:
    vertices = _VERTEX.findall(content)
    words = content.lower()
    begun, ended = len(re.findall(rb"\bfacet\s+normal\b", words)), len(re.findall(rb"\bendfacet\b", words))
    if begun != ended or len(vertices) != 3 * begun or b"endsolid" not in words:
        raise ValueError(f"damaged: the text ends after {ended} whole triangles, without an endsolid")
    return np.array(vertices, dtype=np.bytes_).astype(np.float64).reshape(-1, 3)
