"""Reads trees that were saved; `_files.py` saves them."""

from __future__ import annotations

import os

from numpy.typing import ArrayLike

from . import _core
from ._inputs import as_faces, as_flag, as_path, as_vertices
from .bvh import Bvh


def load(path: str | os.PathLike[str], mmap: bool = True, *, verify: bool = False) -> Bvh:
    """Load a tree that `Bvh.save` wrote: the same tree, with the same answers and report.

    Whatever the file holds, no query of the tree can crash: its header and the tree's structure are checked
    always. Damage to nodes and triangles that leaves the structure whole would go unnoticed and change
    answers; `verify` finds it.

    Args:
        path: the file.
        mmap: use the file's pages in place, which all processes that load it share, instead of reading them
            to memory. The file must not be changed in place while the tree lives; `Bvh.save` never does.
        verify: compare the checksums of everything.

    Returns:
        A `treelet.Bvh` that cannot be updated; `.to("cuda")` copies it to a device.

    Raises:
        FileError: for a file that is no tree, damaged, cut off, or of another version. It is a ValueError.
        OSError: where the file cannot be read.
    """
    return Bvh(_core.load(as_path(path), as_flag(mmap, "mmap"), as_flag(verify, "verify")))


def from_bytes(data: bytes) -> Bvh:
    """The tree in a pickle."""
    return Bvh(_core.from_bytes(data))


def mesh_hash(vertices: ArrayLike, faces: ArrayLike) -> str:
    """16 hexadecimal digits that tell meshes apart, to name a file of its tree or to recognise one.

    The same for every recipe: `treelet.build(vertices, faces).mesh_hash`. It is made of the corners of each
    triangle that a tree would hold, as float32 and with its face's number, and the number of faces.

    Args:
        vertices: (V, 3), as for `treelet.build`.
        faces: (F, 3), as for `treelet.build`.

    Raises:
        ValueError, TypeError: as `treelet.build`.
    """
    points = as_vertices(vertices)
    corners = as_faces(faces, len(points.array))
    return f"{_core.hash_mesh(points.array, corners, points.offset):016x}"
