"""How long a suite will take, before it starts: each recipe is tried on a small scene, and scaled up."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace

from treelet.bench.compare.suite import SceneChoice, Suite
from treelet.bench.compare.survey import Survey, load_scene
from treelet.bench.compare.work import SceneWork
from treelet.bench.measure import Progress, Subject, make_ray_sets, time_builds, time_rays

_TRIANGLES, _RAYS = 20_000, 40_000
_SCENE = "interior"
# Trees larger than the caches build and trace slower than the trial's: per doubling of triangles.
_BUILD_GROWTH, _TRACE_GROWTH = 1.05, 1.08
_EPO_SECONDS = 1.5e-6  # a triangle, up to the 200 000 that EPO looks at
_EPO_TRIANGLES = 200_000


@dataclass(frozen=True)
class Trial:
    """What a recipe took on the small scene."""

    build_seconds: float  # a triangle
    ray_seconds: float


def try_recipes(suite: Suite, progress: Progress) -> dict[str, Trial]:
    """Build and trace the small scene with every recipe, by label; one that fails there has no entry."""
    mesh = load_scene(SceneChoice(_SCENE, _TRIANGLES), 0)
    small = replace(suite, rays=_RAYS, bounces=1, samples=1)
    plan = replace(small.plan, kinds=("diffuse",), builds=2, repeats=2)
    trials: dict[str, Trial] = {}
    for candidate in suite.candidates:
        subject = Subject(candidate)
        try:
            time_builds([subject], mesh, plan, progress)
            rays = make_ray_sets(subject.bvh, mesh, mesh.views[0], plan)
            time_rays([subject], rays, plan, progress)
        except (ValueError, RuntimeError, MemoryError):
            continue
        per_ray = min(subject.traces["diffuse"]) / len(rays[0])
        trials[candidate.label] = Trial(min(subject.builds) / len(mesh.faces), per_ray)
    return trials


def scene_seconds(
    suite: Suite, scene: Survey, work: SceneWork, trials: Mapping[str, Trial], load_seconds: float = 0.0
) -> float:
    """What is left to measure of one scene, good to a factor of two or so."""
    doublings = math.log2(max(scene.faces, 1) / _TRIANGLES)
    build = scene.faces * _BUILD_GROWTH**doublings
    trace = _TRACE_GROWTH**doublings
    seconds = load_seconds
    for label in work.trees:
        trial = trials.get(label)
        if trial is None:
            continue
        is_timed = label in work.builds
        seconds += build * trial.build_seconds * (suite.builds if is_timed else 1)
        if is_timed and suite.epo:
            seconds += _EPO_SECONDS * min(scene.faces, _EPO_TRIANGLES)
        for (_, kind), labels in work.traces.items():
            if label in labels:
                # One trace more warms up, and counting the work of a part takes about as long as another.
                seconds += trace * trial.ray_seconds * _ray_count(suite, kind) * (suite.repeats + 2)
    return seconds


def describe_seconds(seconds: float) -> str:
    """'40 s', '12 min', '3.5 h'."""
    if seconds < 90.0:
        return f"{max(1.0, seconds):.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 5400.0 else f"{seconds / 3600.0:.1f} h"


class Forecast:
    """Seconds that are left, corrected by how long finished scenes took."""

    def __init__(self, expected: Mapping[SceneChoice, float]) -> None:
        self._expected = dict(expected)
        self._done = 0.0
        self._start = time.perf_counter()

    @property
    def total(self) -> float:
        """As expected at first."""
        return sum(self._expected.values())

    def finish(self, scene: SceneChoice) -> float | None:
        """A scene is done: the seconds that are likely left, or None for one with nothing to do."""
        if scene not in self._expected:
            return None
        self._done += self._expected.pop(scene)
        left = sum(self._expected.values())
        elapsed = time.perf_counter() - self._start
        return left * (elapsed / self._done if self._done > 0.0 else 1.0)


def _ray_count(suite: Suite, kind: str) -> float:
    per_camera_ray = {"primary": 1.0, "diffuse": suite.bounces * suite.samples}
    return suite.rays * per_camera_ray.get(kind, float(suite.samples))
