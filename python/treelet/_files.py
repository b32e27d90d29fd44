"""Trees in files and pickles; `_load.py` reads them."""

from __future__ import annotations

import os
from typing import Any

import numpy as np

from . import _core
from ._compiled_tree import CompiledTree
from ._inputs import as_path


class TreeFiles(CompiledTree):
    """Saving, pickling and copying, and what tells one tree's mesh from another's."""

    _updatable: _core.UpdatableBvh | None

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the tree to a file, usually *.treelet, which `treelet.load` reads (docs/file-format.md).

        The file is there as a whole or not at all, and replaces one of this name; who has that one loaded
        keeps it. A tree that can be updated is saved as it is now, and loads as one that cannot.

        Raises:
            OSError: where the file cannot be written; then there is none, or the old one.
            RuntimeError: while another thread updates the tree.
        """
        self._ask(_core.save, as_path(path))

    @property
    def mesh_hash(self) -> str:
        """16 hexadecimal digits that tell meshes apart: those of `treelet.mesh_hash` for the tree's mesh.

        Computed at every use, in about a hundredth of a build.
        """
        return f"{self._ask(_core.hash_tree):016x}"

    @property
    def offset(self) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        """(3,) float64: what was subtracted from the vertices before they were rounded to float32.

        Zeros for float32 vertices and for meshes near the origin (docs/precision.md). Rays, points and
        `bounds` are in the mesh's own coordinates all the same.
        """
        return np.array(self._offset)

    def __reduce__(self) -> tuple[Any, tuple[bytes]]:
        from ._load import from_bytes

        return from_bytes, (self._ask(_core.to_bytes),)

    def __copy__(self) -> Any:
        """The tree itself if it never changes, else one that holds what this one is now."""
        if self._updatable is None:
            return self
        restore, arguments = self.__reduce__()
        return restore(*arguments)

    def __deepcopy__(self, memo: dict[int, Any]) -> Any:
        return self.__copy__()
