"""The embedded scenes by name."""

from __future__ import annotations

import difflib
from types import ModuleType

from ..mesh import Mesh
from . import city, forest, hairball, interior, menger, soup, sphere, terrain

# Each module has SUMMARY, build(triangles, seed) and either VIEWS or views(vertices).
_SCENES: dict[str, ModuleType] = {
    "hairball": hairball,
    "city": city,
    "terrain": terrain,
    "forest": forest,
    "interior": interior,
    "menger": menger,
    "sphere": sphere,
    "soup": soup,
}
FEWEST_TRIANGLES, MOST_TRIANGLES = 1_000, 50_000_000


def names() -> list[str]:
    """The embedded scenes, the most telling first."""
    return list(_SCENES)


def describe(name: str) -> str:
    """One line about an embedded scene. Raises ValueError for a name that is not one."""
    return str(_scene(name).SUMMARY)


def make(name: str, triangles: int = 100_000, seed: int = 0) -> Mesh:
    """Builds an embedded scene with its views; the same name, count and seed give the same bytes.

    triangles: from 1 000 to 50 000 000; the scene has that many within 10 %, most far closer (see each
    `build`).
    seed: any integer from 0. Raises ValueError for an unknown name, a count or a seed outside its range.
    """
    scene = _scene(name)
    if not FEWEST_TRIANGLES <= triangles <= MOST_TRIANGLES:
        raise ValueError(f"triangles must be from {FEWEST_TRIANGLES} to {MOST_TRIANGLES}, not {triangles}")
    check_seed(seed)
    vertices, faces = scene.build(int(triangles), int(seed))
    views = scene.VIEWS if hasattr(scene, "VIEWS") else scene.views(vertices)
    return Mesh(vertices, faces, name, views)


def check_seed(seed: int) -> None:
    """Raises ValueError for a seed that no generator takes."""
    if seed < 0:
        raise ValueError(f"seed must not be negative, but is {seed}")


def suggestion(name: str, known: list[str]) -> str:
    """The words of an error after an unknown name: the nearest known one, if any is near, and all of them."""
    near = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
    question = f"; did you mean {near[0]!r}?" if near else ";"
    return f"{question} known are {', '.join(known)}"


def _scene(name: str) -> ModuleType:
    if name not in _SCENES:
        raise ValueError(f"unknown scene {name!r}{suggestion(name, names())}")
    return _SCENES[name]
