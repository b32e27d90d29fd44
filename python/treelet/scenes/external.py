"""Scenes from a folder of mesh files, named by the environment variable TREELET_SCENES.

The folder has a `scenes.json`: a name for each scene, with `file` beside it and `cameras`, each with `name`,
`eye`, `look_at`, `up` and `vfov_deg`. Names that begin with an underscore are not scenes.
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from ..mesh import Mesh, load_mesh, with_views
from ..view import View
from .catalog import suggestion

VARIABLE = "TREELET_SCENES"
_INDEX = "scenes.json"


def external_names() -> list[str]:
    """The scenes of the folder in TREELET_SCENES, in its order; none where the variable is not set.

    Raises ValueError where it is set but no readable scenes.json is there.
    """
    folder = _folder()
    return [] if folder is None else list(_read_index(folder))


def load_external(name: str) -> Mesh:
    """Loads a scene of the folder in TREELET_SCENES with its cameras as views.

    Raises ValueError for an unknown name, a variable that is not set or a damaged index; errors of the mesh
    file are those of `load_mesh`.
    """
    folder = _folder()
    if folder is None:
        raise ValueError(f"scene {name!r} is not embedded, and {VARIABLE} names no folder of scenes")
    index = _read_index(folder)
    if name not in index:
        raise ValueError(f"unknown scene {name!r} in {folder}{suggestion(name, list(index))}")
    mesh = load_mesh(folder / index[name]["file"])
    place = f"{folder / _INDEX}: scene {name!r}: camera"
    cameras = enumerate(index[name].get("cameras", []))
    return with_views(mesh, tuple(_view(camera, f"{place} {number}") for number, camera in cameras), name)


def _folder() -> Path | None:
    value = os.environ.get(VARIABLE, "")
    return Path(value) if value else None


def _read_index(folder: Path) -> dict[str, dict[str, Any]]:
    path = folder / _INDEX
    try:
        index = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise ValueError(f"{VARIABLE} is {str(folder)!r}, but {path} cannot be read: {error}") from error
    if not isinstance(index, dict):
        raise ValueError(f"{path} must hold an object with a name for each scene")
    scenes = {name: scene for name, scene in index.items() if not name.startswith("_")}
    for name, scene in scenes.items():
        _check_scene(scene, f"{path}: scene {name!r}")
    return {name: scene for name, scene in scenes.items() if "file" in scene}


def _check_scene(scene: Any, place: str) -> None:
    """Raises ValueError, with the place, for an entry whose parts have the wrong types."""
    if not isinstance(scene, dict):
        raise ValueError(f"{place} must be an object with a file, not {scene!r}")
    if not isinstance(scene.get("file", ""), str):
        raise ValueError(f"{place} must have a text as its file, not {scene['file']!r}")
    cameras = scene.get("cameras", [])
    if not isinstance(cameras, list) or not all(isinstance(camera, dict) for camera in cameras):
        raise ValueError(f"{place} must have a list of objects as its cameras, not {cameras!r}")


def _view(camera: dict[str, Any], place: str) -> View:
    try:
        return View(
            camera["eye"],
            camera["look_at"],
            camera.get("up", (0.0, 0.0, 1.0)),
            camera.get("vfov_deg", 45.0),
            str(camera.get("name", "")),
        )
    except KeyError as missing:
        raise ValueError(f"{place} has no {missing.args[0]}") from None
    except (TypeError, ValueError) as error:
        raise ValueError(f"{place}: {error}") from error
