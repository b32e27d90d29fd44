"""Timing recipes against each other on one mesh."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import treelet
from treelet.bench.records import Measurement
from treelet.render.rays import Rays, ambient_occlusion_rays, diffuse_rays, primary_rays
from treelet.scenes.catalog import check_seed

Progress = Callable[[str], None]  # called with what is done next
RAY_KINDS = ("primary", "diffuse", "ambient_occlusion")


@dataclass(frozen=True)
class Candidate:
    """A recipe under the name it has in tables and plots."""

    label: str
    recipe: str


@dataclass(frozen=True)
class Plan:
    """What to measure, and how often."""

    candidates: tuple[Candidate, ...]
    kinds: tuple[str, ...] = ("primary", "diffuse")
    width: int = 1024  # pixels of the picture whose rays are traced
    height: int = 640
    builds: int = 5
    repeats: int = 5
    bounces: int = 1  # of diffuse rays
    samples: int = 1  # diffuse rays a pixel
    seed: int = 0
    with_epo: bool = True  # a second or so for a million triangles, never timed

    def __post_init__(self) -> None:
        check_seed(self.seed)

    @property
    def steps(self) -> int:
        """How often `measure` calls progress."""
        return len(self.candidates) * (self.builds + 1 + len(self.kinds) * (self.repeats + 1))


@dataclass
class Subject:
    """A candidate's tree and its timings so far."""

    candidate: Candidate
    bvh: Any = None
    builds: list[float] = field(default_factory=list)
    traces: dict[str, list[float]] = field(default_factory=dict)


@dataclass(frozen=True)
class Result:
    """Measurements of one mesh, and the trees they were made with, by label."""

    measurements: list[Measurement]
    bvhs: dict[str, Any]


def measure(mesh, view, plan: Plan, progress: Progress | None = None) -> Result:
    """Build and trace `mesh` with every candidate of `plan`.

    All candidates trace the same rays. Repeats go round the candidates in turn, so that a machine that gets
    slower or faster meanwhile treats all alike. Raises what `treelet.build` raises for a bad mesh or
    recipe.
    """
    report = progress or (lambda step: None)
    mesh = mesh.rounded()  # once, so that no build is timed rounding
    subjects = [Subject(candidate) for candidate in plan.candidates]
    time_builds(subjects, mesh, plan, report)
    ray_sets = make_ray_sets(subjects[0].bvh, mesh, view, plan)
    time_rays(subjects, ray_sets, plan, report)
    measurements = []
    for subject in subjects:
        report(f"judge {subject.candidate.label}")
        measurements += _records(subject, mesh, ray_sets, plan)
    return Result(measurements, {subject.candidate.label: subject.bvh for subject in subjects})


def make_ray_sets(bvh, mesh, view, plan: Plan) -> list[Rays]:
    """The rays of every kind in `plan.kinds`; any tree over the mesh gives the same ones."""
    primary = primary_rays(view, plan.width, plan.height, plan.seed)
    makers = {
        "primary": lambda: primary,
        "diffuse": lambda: diffuse_rays(bvh, mesh, primary, plan.bounces, plan.samples, plan.seed),
        "ambient_occlusion": lambda: ambient_occlusion_rays(
            bvh, mesh, primary, samples=plan.samples, seed=plan.seed
        ),
    }
    unknown = set(plan.kinds) - set(makers)
    if unknown:
        raise ValueError(f"unknown ray kind '{min(unknown)}': choose from {', '.join(makers)}")
    ray_sets = [makers[kind]() for kind in plan.kinds]
    empty = [rays.kind for rays in ray_sets if len(rays) == 0]
    if empty:
        raise ValueError(f"there are no {empty[0]} rays: no camera ray hits {mesh.name}, choose another view")
    return ray_sets


def time_builds(subjects: Sequence[Subject], mesh, plan: Plan, report: Progress) -> None:
    """Build every subject's tree `plan.builds` times, in turns; samples are appended, the last tree stays."""
    for _ in range(plan.builds):
        for subject in subjects:
            report(f"build {subject.candidate.label}")
            start = time.perf_counter()
            subject.bvh = treelet.build(mesh.vertices, mesh.faces, recipe=subject.candidate.recipe)
            subject.builds.append(time.perf_counter() - start)


def time_rays(subjects: Sequence[Subject], ray_sets: Sequence[Rays], plan: Plan, report: Progress) -> None:
    """Trace every set of rays `plan.repeats` times with every tree, in turns; samples are appended."""
    for rays in ray_sets:
        for repeat in range(plan.repeats + 1):
            for subject in subjects:
                report(f"trace {rays.kind.replace('_', ' ')} rays with {subject.candidate.label}")
                start = time.perf_counter()
                rays.trace(subject.bvh)
                seconds = time.perf_counter() - start
                if repeat > 0:  # the first touches the tree's memory
                    subject.traces.setdefault(rays.kind, []).append(seconds)


def _records(subject: Subject, mesh, ray_sets: Sequence[Rays], plan: Plan) -> list[Measurement]:
    tree = subject.bvh.report
    common = {
        "scene": mesh.name,
        "faces": len(mesh.faces),
        "label": subject.candidate.label,
        "recipe": tree.recipe,
        "threads": treelet.thread_count(),
    }
    details = tree_details(tree, plan.with_epo)
    records = [Measurement(kind="build", samples=subject.builds, details=details, **common)]
    for rays in ray_sets:
        samples = subject.traces[rays.kind]
        records.append(Measurement(kind=rays.kind, samples=samples, rays=len(rays), **common))
    return records


def tree_details(tree, with_epo: bool) -> dict[str, Any]:
    """What a build's line says about the tree; `tree` is its report."""
    details = {
        "sah": float(tree.sah),
        "nodes": int(tree.nodes),
        "leaves": int(tree.leaves),
        "depth": int(tree.depth),
        "references": int(tree.references),
        "bytes": int(tree.bytes),
        "stages": [{"name": stage.name, "seconds": stage.seconds} for stage in tree.stages],
    }
    return details | ({"epo": float(tree.epo)} if with_epo else {})
