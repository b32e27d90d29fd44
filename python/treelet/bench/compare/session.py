"""Measuring a suite: scene by scene, all recipes in turns, lines written as soon as they are there."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import treelet
from treelet.bench.compare.journal import Journal, row_key
from treelet.bench.compare.suite import Suite
from treelet.bench.compare.survey import Survey, load_scene, named_views
from treelet.bench.compare.work import SceneWork, find_work
from treelet.bench.machine import describe_machine, source_commit
from treelet.bench.measure import Progress, Subject, make_ray_sets, time_builds, time_rays, tree_details
from treelet.bench.records import Measurement
from treelet.render.rays import Rays

_COUNTED_RAYS = 1 << 18  # nodes and triangles of so many rays at most are counted: means to three digits
_ERRORS = (ValueError, RuntimeError, OSError, ImportError, MemoryError)


@dataclass(frozen=True)
class Failure:
    """What could not be measured; everything else was."""

    scene: str
    reason: str
    label: str = ""  # of the recipe, where it is one recipe's
    view: str = ""

    @property
    def sentence(self) -> str:
        """'city, street, SBVH: reason'"""
        return f"{', '.join(filter(None, (self.scene, self.view, self.label)))}: {self.reason}"


def run_session(
    suite: Suite,
    scenes: Sequence[Survey],
    journal: Journal,
    progress: Progress,
    finished: Callable[[Survey], None] = lambda scene: None,
) -> list[Failure]:
    """Measure whatever rows are missing, and return what failed.

    An error of a scene, a view or a recipe is written down, and the others go on.
    """
    journal.log("begin", **session_facts(suite))
    failures: list[Failure] = []
    for scene in scenes:
        if scene.absent:
            journal.log("skipped", scene=scene.choice.mesh, reason=scene.absent)
            continue
        for failure in _run_scene(suite, scene, journal, progress):
            failures.append(failure)
            journal.log("failed", **vars(failure))
        finished(scene)
    journal.log("end", failures=len(failures))
    return failures


def session_facts(suite: Suite) -> dict[str, Any]:
    """What a report has to know beside the measurements."""
    return {
        "title": suite.title,
        "reference": suite.reference,
        "recipes": {each.label: each.recipe for each in suite.candidates},
        "kinds": list(suite.kinds),
        "commit": source_commit(),
        "machine": describe_machine(),
        "threads": treelet.thread_count(),
    }


def _run_scene(suite: Suite, scene: Survey, journal: Journal, progress: Progress) -> Iterable[Failure]:
    if scene.failed:
        return [Failure(scene.choice.mesh, scene.failed)]
    work = find_work(suite, scene, journal.rows)
    if not work.trees:
        return []
    try:
        return _SceneRun(suite, scene, work, journal, progress).run()
    except _ERRORS as error:
        return [Failure(scene.choice.mesh, _reason(error))]


class _SceneRun:
    """One scene's trees and timings."""

    def __init__(
        self, suite: Suite, scene: Survey, work: SceneWork, journal: Journal, progress: Progress
    ) -> None:
        self._suite, self._scene, self._work = suite, scene, work
        self._journal, self._progress = journal, progress
        self._mesh = load_scene(scene.choice, suite.seed)
        self._failures: list[Failure] = []

    def run(self) -> list[Failure]:
        subjects = self._build_all()
        views = named_views(self._mesh, self._scene.choice)
        for (view, kind), labels in self._work.traces.items():
            chosen = [subject for subject in subjects if subject.candidate.label in labels]
            try:
                self._trace(view, views[view], kind, chosen)
            except _ERRORS as error:
                self._fail(_reason(error), view=view)
        return self._failures

    def _build_all(self) -> list[Subject]:
        """A tree for everything in the work, timed for those whose build is missing."""
        everybody = (each for each in self._suite.candidates if each.label in self._work.trees)
        subjects = [subject for subject in map(Subject, everybody) if self._can_build(subject)]
        timed = [subject for subject in subjects if subject.candidate.label in self._work.builds]
        time_builds(
            timed, self._mesh, replace(self._suite.plan, builds=self._suite.builds - 1), self._progress
        )
        self._journal.add(self._build_line(subject) for subject in timed)
        return subjects

    def _can_build(self, subject: Subject) -> bool:
        """Build once, apart from the others, so that a recipe which fails here does so alone."""
        try:
            time_builds([subject], self._mesh, replace(self._suite.plan, builds=1), self._progress)
        except _ERRORS as error:
            self._fail(_reason(error), subject.candidate.label)
            return False
        return True

    def _trace(self, name: str, view: Any, kind: str, subjects: list[Subject]) -> None:
        if not subjects:
            return
        plan = replace(self._suite.plan, kinds=(kind,))
        [rays] = make_ray_sets(subjects[0].bvh, self._mesh, view, plan)
        for subject in subjects:
            subject.traces.clear()
        time_rays(subjects, [rays], plan, self._progress)
        self._journal.add([self._ray_line(subject, name, rays) for subject in subjects])

    def _build_line(self, subject: Subject) -> Measurement:
        self._progress(f"judge {subject.candidate.label}")
        details = tree_details(subject.bvh.report, self._suite.epo)
        return self._line(subject, "build", None, subject.builds, 0, details)

    def _ray_line(self, subject: Subject, view: str, rays: Rays) -> Measurement:
        self._progress(f"count the work of {subject.candidate.label}")
        details = {"view": view, **_work_a_ray(subject.bvh, rays)}
        return self._line(subject, rays.kind, view, subject.traces[rays.kind], len(rays), details)

    def _line(
        self,
        subject: Subject,
        kind: str,
        view: str | None,
        samples: list[float],
        rays: int,
        details: dict[str, Any],
    ) -> Measurement:
        key = row_key(self._suite, self._scene.choice, subject.candidate, kind, view)
        return Measurement(
            kind=kind,
            scene=self._mesh.name,
            faces=len(self._mesh.faces),
            label=subject.candidate.label,
            recipe=subject.bvh.report.recipe,
            samples=samples,
            rays=rays,
            threads=treelet.thread_count(),
            details={"row": key, "session": self._journal.session, **details},
        )

    def _fail(self, reason: str, label: str = "", view: str = "") -> None:
        self._failures.append(Failure(self._scene.choice.mesh, reason, label, view))


def _work_a_ray(bvh: Any, rays: Rays) -> dict[str, float]:
    """Mean nodes and triangles of a ray. Any-hit rays are counted as if for their closest hit."""
    stride = -(-len(rays) // _COUNTED_RAYS)
    work = bvh.traversal_cost(rays.origins[::stride], rays.directions[::stride], t_max=rays.t_max)
    return {
        "nodes_per_ray": float(np.mean(work.nodes)),
        "triangles_per_ray": float(np.mean(work.triangles)),
    }


def _reason(error: BaseException) -> str:
    if isinstance(error, MemoryError):
        return "out of memory"
    return " ".join(str(error).split()) or type(error).__name__
