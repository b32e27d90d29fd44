"""What a comparison measures, read from TOML: scenes and views, recipes, kinds of rays, how often.

docs/evaluation.md describes the file; an example with every key:

    title = "Builders"
    reference = "SBVH"                  # the label that rates are shares of
    kinds = ["primary", "diffuse", "ao"]
    rays = 300_000                      # camera rays a view, in a picture of 16:10
    bounces = 3                         # of diffuse rays
    samples = 1                         # diffuse and ao rays a camera ray
    builds = 3                          # timed builds of each tree
    repeats = 5                         # timed traces of each set of rays
    seed = 0
    epo = true

    [recipes]
    "SBVH" = "sbvh > bvh8"

    [[scene]]
    mesh = "city"                       # an embedded or external scene, or a mesh file
    triangles = 200_000                 # of embedded scenes
    views = ["skyline"]                 # all views where none are named
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import treelet
from treelet.bench.compare.suite_keys import Keys, read_toml
from treelet.bench.measure import Candidate, Plan
from treelet.scenes.catalog import FEWEST_TRIANGLES, MOST_TRIANGLES, names

KINDS = {"primary": "primary", "diffuse": "diffuse", "ao": "ambient_occlusion"}
_ASPECT = 1.6
_MOST_RAYS = 1 << 28


@dataclass(frozen=True)
class SceneChoice:
    """A mesh, and from where it is looked at."""

    mesh: str
    triangles: int | None = None  # of embedded scenes
    views: tuple[str, ...] = ()  # all where none are named


@dataclass(frozen=True)
class Suite:
    """Everything that a comparison measures."""

    title: str
    reference: str
    candidates: tuple[Candidate, ...]
    scenes: tuple[SceneChoice, ...]
    kinds: tuple[str, ...] = ("primary", "diffuse", "ambient_occlusion")
    rays: int = 300_000
    bounces: int = 3
    samples: int = 1
    builds: int = 3
    repeats: int = 5
    seed: int = 0
    epo: bool = True

    @property
    def plan(self) -> Plan:
        """The same for one scene, its picture as near to `rays` pixels as 16:10 allows."""
        height = max(1, round(math.sqrt(self.rays / _ASPECT)))
        return Plan(
            self.candidates,
            self.kinds,
            max(1, round(self.rays / height)),
            height,
            self.builds,
            self.repeats,
            self.bounces,
            self.samples,
            self.seed,
            self.epo,
        )

    def chosen(self, wanted: list[str]) -> Suite:
        """The suite over these scenes alone. Raises ValueError for one that it does not have."""
        known = [scene.mesh for scene in self.scenes]
        for name in wanted:
            if name not in known:
                raise ValueError(f"the suite has no scene {name!r}: it has {', '.join(dict.fromkeys(known))}")
        return replace(self, scenes=tuple(scene for scene in self.scenes if scene.mesh in wanted))


def load_suite(path: str | Path) -> Suite:
    """Read a suite. Raises ValueError that names the file and the key which is wrong, OSError without a file.

    On Python 3.10 it needs the package tomli, and says so where that is missing.
    """
    keys = read_toml(Path(path))
    suite = Suite(
        title=keys.text("title", Path(path).stem),
        reference=keys.text("reference"),
        candidates=_candidates(keys),
        scenes=tuple(_scene(each) for each in keys.tables("scene")),
        kinds=_kinds(keys),
        rays=keys.whole("rays", Suite.rays, 1, _MOST_RAYS),
        bounces=keys.whole("bounces", Suite.bounces, 1, 64),
        samples=keys.whole("samples", Suite.samples, 1, 1024),
        builds=keys.whole("builds", Suite.builds, 1),
        repeats=keys.whole("repeats", Suite.repeats, 1),
        seed=keys.whole("seed", Suite.seed),
        epo=keys.flag("epo", default=Suite.epo),
    )
    keys.finish()
    _check(suite, keys)
    return suite


def _candidates(keys: Keys) -> tuple[Candidate, ...]:
    table: Mapping[str, Any] = keys.table("recipes")
    return tuple(Candidate(label, _recipe(label, text, keys)) for label, text in table.items())


def _recipe(label: str, text: Any, keys: Keys) -> str:
    try:
        return treelet.parse_recipe(text)
    except (TypeError, ValueError) as error:
        raise keys.error(f"recipes.{label!r}: {error}") from None


def _kinds(keys: Keys) -> tuple[str, ...]:
    return tuple(KINDS[kind] for kind in keys.texts("kinds", tuple(KINDS), among=tuple(KINDS)))


def _scene(keys: Keys) -> SceneChoice:
    scene = SceneChoice(
        keys.text("mesh"),
        keys.whole("triangles", None, FEWEST_TRIANGLES, MOST_TRIANGLES),
        keys.texts("views", ()),
    )
    if scene.triangles is not None and scene.mesh not in names():
        raise keys.error(f"{scene.mesh!r} has its own triangles: `triangles` is for embedded scenes")
    keys.finish()
    return scene


def _check(suite: Suite, keys: Keys) -> None:
    labels = [candidate.label for candidate in suite.candidates]
    if suite.reference not in labels:
        raise keys.error(
            f"reference is {suite.reference!r}, which [recipes] lacks{keys.near(suite.reference, labels)}"
        )
    first: dict[str, str] = {}
    for candidate in suite.candidates:
        other = first.setdefault(candidate.recipe, candidate.label)
        if other != candidate.label:
            raise keys.error(f"{other!r} and {candidate.label!r} are the same recipe: {candidate.recipe}")
    if len({(scene.mesh, scene.triangles) for scene in suite.scenes}) < len(suite.scenes):
        raise keys.error("a scene is there twice: give it all its views in one [[scene]]")
