"""Which scenes of a suite are there, how large, with which views: known before anything is measured."""

from __future__ import annotations

import difflib
import os
from collections.abc import Callable
from dataclasses import dataclass

from treelet import scenes
from treelet.bench.compare.suite import SceneChoice, Suite
from treelet.mesh import Mesh
from treelet.scenes.external import VARIABLE
from treelet.view import View, automatic_view

DEFAULT_TRIANGLES = 200_000
_SLIP = 0.75  # likeness from which on a name is taken for a misspelt one


@dataclass(frozen=True)
class Survey:
    """A scene that can be measured, or the reason why not."""

    choice: SceneChoice
    faces: int = 0
    views: tuple[str, ...] = ()
    absent: str = ""  # not an error: a scene that is not on this machine
    failed: str = ""  # an error: a damaged file, an unknown view

    @property
    def is_there(self) -> bool:
        """Whether it can be measured."""
        return not self.absent and not self.failed


def survey(suite: Suite, report: Callable[[str], None]) -> list[Survey]:
    """Look at every scene, loading one after the other, so that errors come before hours of measuring."""
    return [_look_at(choice, suite.seed, report) for choice in suite.scenes]


def load_scene(choice: SceneChoice, seed: int) -> Mesh:
    """The mesh, float32. Raises what `scenes.load` raises."""
    is_embedded = choice.mesh in scenes.names()
    triangles = (choice.triangles or DEFAULT_TRIANGLES) if is_embedded else None
    return scenes.load(choice.mesh, triangles, seed).rounded()


def named_views(mesh: Mesh, choice: SceneChoice) -> dict[str, View]:
    """The chosen views by name, all where none are chosen; a computed one where the mesh has none.

    Raises ValueError for a view that the mesh does not have.
    """
    views = {view.name or str(index): view for index, view in enumerate(mesh.views)}
    if not views or "automatic" in choice.views:
        views["automatic"] = automatic_view(mesh.vertices, mesh.faces)
    unknown = [name for name in choice.views if name not in views]
    if unknown:
        known = ", ".join([*views, *([] if "automatic" in views else ["automatic"])])
        raise ValueError(f"{choice.mesh} has no view {unknown[0]!r}: choose from {known}")
    return {name: views[name] for name in choice.views or views}


def _look_at(choice: SceneChoice, seed: int, report: Callable[[str], None]) -> Survey:
    report(f"look at {choice.mesh}")
    try:
        if _is_absent(choice.mesh):
            return Survey(choice, absent=_why_absent(choice.mesh))
        mesh = load_scene(choice, seed)
        return Survey(choice, len(mesh.faces), tuple(named_views(mesh, choice)))
    except FileNotFoundError as error:
        return Survey(choice, absent=str(error))
    except (ValueError, OSError, ImportError, MemoryError) as error:
        return Survey(choice, failed=str(error) or type(error).__name__)


def _why_absent(name: str) -> str:
    """The reason, the same for all scenes, but for a name that may be a slip for an embedded one."""
    is_named = bool(os.environ.get(VARIABLE))
    why = f"not in the folder that {VARIABLE} names" if is_named else f"{VARIABLE} names no folder of scenes"
    near = difflib.get_close_matches(name, scenes.names(), n=1, cutoff=_SLIP)
    return f"{why}; or did you mean {near[0]!r}?" if near else why


def _is_absent(name: str) -> bool:
    """Whether it can only be an external scene, and is none: a name without a folder or an extension."""
    is_name = name.isidentifier()
    return is_name and name not in scenes.names() and name not in scenes.external_names()
