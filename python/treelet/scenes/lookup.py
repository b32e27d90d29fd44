"""One way in: a scene's name or a mesh file's path."""

from __future__ import annotations

import os
from pathlib import Path

from ..mesh import Mesh, load_mesh
from .catalog import check_seed, make, names, suggestion
from .external import VARIABLE, external_names, load_external


def load(name_or_path: str | os.PathLike[str], triangles: int | None = None, seed: int = 0) -> Mesh:
    """The embedded scene of that name, else the mesh file at that path, else the external scene.

    triangles and seed are for embedded scenes: 100 000 and 0 by default. Asking a file for a number of
    triangles is a ValueError, as is a name that is none of the three; a path that does not exist is a
    FileNotFoundError.
    """
    text = os.fspath(name_or_path)
    if text in names():
        return make(text, 100_000 if triangles is None else triangles, seed)
    check_seed(seed)
    external = [] if _is_mesh_file(text) else external_names()
    if text not in external and not _looks_like_path(text):
        hint = "" if external else f" (the variable {VARIABLE} could name a folder with more)"
        raise ValueError(
            f"{text!r} is neither a scene nor a mesh file{suggestion(text, names() + external)}{hint}"
        )
    if triangles is not None:
        raise ValueError(f"{text!r} is a mesh file with its own triangles; only embedded scenes take a count")
    return load_external(text) if text in external else load_mesh(text)


def _is_mesh_file(text: str) -> bool:
    """Decides before the folder of scenes is looked at, which may be missing."""
    return Path(text).suffix != "" and Path(text).exists()


def _looks_like_path(text: str) -> bool:
    path = Path(text)
    return path.suffix != "" or path.parent != Path(".") or path.exists()
