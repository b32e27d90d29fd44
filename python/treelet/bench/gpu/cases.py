"""What the benchmark of the GPU measures over: scenes, recipes, and the rays that the CPU's traces too."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import treelet
from treelet import scenes
from treelet.bench.measure import RAY_KINDS, Plan, make_ray_sets
from treelet.device_bvh import DeviceBvh
from treelet.mesh import Mesh
from treelet.render.rays import Rays
from treelet.view import automatic_view

DEVICE_BUILDERS = (
    "lbvh",
    "lbvh > treelet",
    "hploc",
    "hploc > treelet",
    "presplit(budget=30) > lbvh > treelet",
    "presplit(budget=30) > hploc > treelet",
)
HOST_BUILDERS = ("sweep", "sbvh")  # the references of quality: built on the CPU, moved to the device
# What the device does not have.
HOST_WORDS = (*HOST_BUILDERS, "binned", "ploc", "hlbvh", "gridsah", "reinsert", "insert", "rotate", "atr")
_ORDER_KEYWORDS = ("reorder", "sort", "order")


@dataclass(frozen=True)
class Recipe:
    """A recipe, and where its tree is built."""

    text: str
    host: bool = False

    @property
    def label(self) -> str:
        """As "lbvh > cwbvh" or "sweep > cwbvh (CPU)"."""
        return f"{self.text} (CPU)" if self.host else self.text


@dataclass(frozen=True)
class Settings:
    """How often, and with how many rays."""

    repeats: int = 9
    width: int = 3200  # pixels of the pictures whose rays are traced
    calls: int = 100  # from Python, to see what one costs
    call_rays: int = 1_000_000
    stream_rays: int = 100_000_000  # from the host, in one call


@dataclass(frozen=True)
class Case:
    """A scene; embedded ones have a number of triangles, others a file."""

    scene: str
    triangles: int = 0

    @property
    def name(self) -> str:
        """As "city-1000000" or "conference"."""
        return f"{self.scene}-{self.triangles}" if self.triangles else self.scene

    @cached_property
    def mesh(self) -> Mesh:
        """The mesh, rounded once, so that no build is timed rounding."""
        wanted = {"triangles": self.triangles} if self.triangles else {}
        return scenes.load(self.scene, **wanted).rounded()

    @cached_property
    def reference(self) -> treelet.Bvh:
        """The CPU's tree, whose answers the device's must be."""
        return treelet.build(self.mesh.vertices, self.mesh.faces)

    def make_rays(self, width: int) -> list[Rays]:
        """The sets of rays that `treelet bench` traces over the scene, for a picture of 8 to 5."""
        mesh = self.mesh
        view = mesh.views[0] if mesh.views else automatic_view(mesh.vertices, mesh.faces)
        return make_ray_sets(self.reference, mesh, view, Plan((), RAY_KINDS, width, width * 5 // 8))


def list_cases(names: Iterable[str], triangles: Sequence[int]) -> Iterator[Case]:
    """Every embedded scene with every number of triangles, size by size; other scenes with the first."""
    names = list(names)
    for index, count in enumerate(triangles):
        for name in names:
            if name in scenes.names():
                yield Case(name, count)
            elif index == 0:
                yield Case(name)


def layouts() -> list[str]:
    """The layouts that this version has."""
    return [word.name for word in treelet.recipe_words() if word.kind == "layout"]


def list_recipes(chosen: Sequence[str] = ()) -> list[Recipe]:
    """Every builder with every layout, or those that are chosen; the CPU's last."""
    names = [name for name in layouts() if not chosen or name in chosen]
    device = [Recipe(f"{builder} > {name}") for builder in DEVICE_BUILDERS for name in names]
    builders = [word.name for word in treelet.recipe_words() if word.name in HOST_BUILDERS]
    return device + [Recipe(f"{builder} > {name}", host=True) for builder in builders for name in names]


def order_arguments() -> list[tuple[str, dict[str, Any]]]:
    """How rays can be ordered: what it adds to a label, and the arguments of the queries."""
    known = inspect.signature(DeviceBvh.intersect).parameters
    keyword = next((name for name in _ORDER_KEYWORDS if name in known), None)
    return [("", {})] + ([(f", {keyword}", {keyword: True})] if keyword else [])


def warn(text: str) -> None:
    """Say what is done, or left out and why, where it does not mix with measurements."""
    print(text, file=sys.stderr, flush=True)  # noqa: T201
