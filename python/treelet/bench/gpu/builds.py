"""Times builds and updates on a CUDA device, stage by stage, against the bytes that they have to move."""

from __future__ import annotations

import statistics
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import treelet
from treelet import cuda
from treelet.bench.gpu.cases import Case, Recipe, Settings, warn
from treelet.bench.gpu.clock import Clock
from treelet.bench.records import Measurement

# Bytes a triangle, or a piece of one, that a stage cannot avoid to move: each input read once, each output
# written once. A mesh has 12 bytes of indices and about half a vertex of 12 bytes a triangle; the sort makes
# 8 passes of 12 bytes in and out, and reads its keys once more. Merging was counted (build/hploc.cu).
_MESH = 18.0
STAGE_BYTES = {
    "survey the mesh": _MESH,
    "split triangles": _MESH + 32,
    "sort Morton codes": _MESH + 12 + 8 * 24 + 8,
    "emit LBVH and fit boxes": _MESH + 12 + 64 + 32 + 12,
    "merge clusters": 330,
    "restructure treelets": 3 * 64 + 4,
    "cost of the tree": 64 + 8,
    "collapse": 64 + 32,
    "wait and allocate": 0,
    "pack bvh2": 64 + 16 + _MESH,  # and the layout's own bytes
    "pack bvh8": 64 + 32 + _MESH,
    "pack cwbvh": 64 + 32 + _MESH,
}


@dataclass
class Subject:
    """A recipe, its last tree and the times of its builds so far."""

    recipe: Recipe
    bvh: Any = None  # on the device; not kept where only builds are measured
    report: Any = None
    calls: list[float] = field(default_factory=list)  # seconds as Python sees them
    stages: list[dict[str, float]] = field(default_factory=list)  # seconds of the device, or of the CPU

    @property
    def builds(self) -> list[float]:
        """Seconds of the device, or for the CPU's trees of the CPU."""
        return self.calls if self.recipe.host else [sum(stages.values()) for stages in self.stages]


def build_all(case: Case, recipes: Sequence[Recipe], repeats: int, *, keep: bool = True) -> list[Subject]:
    """Build every recipe's tree `repeats` times, in turn; those that cannot be built here are left out.

    Without `keep` one tree at a time is in memory.
    """
    vertices = cuda.copy_to_device(case.mesh.vertices, "float32")
    faces = cuda.copy_to_device(case.mesh.faces, "uint32")
    subjects = [Subject(recipe) for recipe in recipes]
    for repeat in range(repeats + 1):
        for subject in list(subjects):
            try:
                _build_once(subject, case, (vertices, faces), repeat)
                subject.bvh = subject.bvh if keep else None
            except (RuntimeError, ValueError) as error:  # no device version, no such word, no memory
                warn(f"{case.name}: {subject.recipe.label} is left out: {error}")
                subjects.remove(subject)
    return subjects


def _build_once(subject: Subject, case: Case, mesh: tuple[Any, Any], repeat: int) -> None:
    if subject.recipe.host and repeat > 0:  # slow, and no figure of the device
        return
    arrays = (case.mesh.vertices, case.mesh.faces) if subject.recipe.host else mesh
    start = time.perf_counter()
    tree = treelet.build(*arrays, subject.recipe.text)
    seconds = time.perf_counter() - start
    subject.bvh, subject.report = tree.to("cuda"), tree.report
    if subject.recipe.host or repeat > 0:  # the device's first loads kernels and maps memory
        subject.calls.append(seconds)
        subject.stages.append({stage.name: stage.seconds for stage in subject.report.stages})


def common_fields(case: Case, recipe: Recipe) -> dict[str, Any]:
    """What all measurements of a recipe's tree say."""
    return {
        "scene": case.mesh.name,
        "faces": len(case.mesh.faces),
        "label": recipe.label,
        "recipe": treelet.parse_recipe(recipe.text),
    }


def describe_builds(case: Case, subject: Subject) -> list[Measurement]:
    """The build as the device sees it, with its stages, and as Python sees it."""
    common = common_fields(case, subject.recipe)
    details = stage_details(subject.stages, subject.report)
    details["built_on"] = "cpu" if subject.recipe.host else "device"
    build = Measurement(kind="build", samples=subject.builds, details=details, **common)
    if subject.recipe.host:
        return [build]
    return [build, Measurement(kind="build_call", samples=subject.calls, **common)]


def stage_details(stages: Sequence[dict[str, float]], report: Any) -> dict[str, Any]:
    """Medians of each stage; the bandwidth that its unavoidable bytes make of them, where both are known."""
    rows = []
    for name in stages[0]:
        row: dict[str, Any] = {"name": name}
        row["seconds"] = statistics.median(sample.get(name, 0.0) for sample in stages)
        if name in STAGE_BYTES and row["seconds"] > 0:
            count = report.faces if name == "survey the mesh" else report.references
            row["bytes"] = STAGE_BYTES[name] * count + (report.bytes if name.startswith("pack") else 0)
            row["bytes_per_second"] = row["bytes"] / row["seconds"]
        rows.append(row)
    seconds = sum(row["seconds"] for row in rows)
    return {
        "stages": rows,
        "sah": report.sah,
        "nodes": report.nodes,
        "depth": report.depth,
        "bytes": report.bytes,
        "references": report.references,
        "million_triangles_per_second": report.faces / seconds / 1e6 if seconds > 0 else 0.0,
    }


def measure_builds(
    case: Case, recipes: Sequence[Recipe], settings: Settings, clock: Clock
) -> Iterator[Measurement]:
    """Builds of every recipe that the device has, then the updates of their trees."""
    recipes = [recipe for recipe in recipes if not recipe.host]
    for subject in build_all(case, recipes, settings.repeats, keep=False):
        yield from describe_builds(case, subject)
        yield from _measure_updates(case, subject.recipe, settings.repeats, clock)


def _measure_updates(case: Case, recipe: Recipe, repeats: int, clock: Clock) -> Iterator[Measurement]:
    """Updates of a tree over a mesh whose vertices have all moved, by a twentieth of its size."""
    vertices = cuda.copy_to_device(case.mesh.vertices, "float32")
    faces = cuda.copy_to_device(case.mesh.faces, "uint32")
    moved = cuda.copy_to_device(_move(case.mesh.vertices), "float32")
    bvh = treelet.build(vertices, faces, recipe.text, updatable=True)
    common = common_fields(case, recipe)
    bvh.refit(moved)
    samples = [clock.time(lambda: bvh.refit(moved)) for _ in range(repeats)]
    yield Measurement(kind="refit", samples=samples, details=_update_details(bvh.report), **common)
    _make_room(bvh, moved)
    samples = [clock.time(lambda: bvh.rebuild(moved)) for _ in range(repeats)]
    bvh.check()
    yield Measurement(kind="rebuild", samples=samples, details=_update_details(bvh.report), **common)


def _move(vertices: np.ndarray) -> np.ndarray:
    """Waves through the mesh."""
    size = float(np.ptp(vertices, axis=0).max())
    waves = np.sin(vertices[:, [1, 2, 0]] * np.float32(8 / size))
    return vertices + np.float32(size / 20) * waves


def _update_details(report: Any) -> dict[str, Any]:
    return {
        "layout_sah": report.layout_sah,
        "layout_sah_at_build": report.layout_sah_at_build,
        "held_bytes": report.held_bytes,
    }


def _make_room(bvh: Any, moved: Any) -> None:
    """Rebuild until the tree fits its memory, which grows where it did not."""
    bvh.rebuild(moved)
    try:
        bvh.check()
    except RuntimeError:
        bvh.rebuild(moved)
        bvh.check()
