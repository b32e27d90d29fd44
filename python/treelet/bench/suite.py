"""The standard comparison over a list of scenes, one JSON-lines file a scene."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from treelet.bench.measure import Candidate, Plan, Progress, Result, measure
from treelet.bench.records import write_measurements
from treelet.view import automatic_view

STANDARD_CANDIDATES = (
    Candidate("LBVH", "fast"),
    Candidate("treelet", "balanced"),
    Candidate("sweep SAH", "sweep > bvh8"),
)
REFERENCE_LABEL = "sweep SAH"


def run_suite(
    meshes: Iterable, plan: Plan, folder: Path, progress: Progress | None = None
) -> Iterator[tuple[Path, Result]]:
    """Measure each mesh from its first view and write FOLDER/<name>.jsonl; yields path and result."""
    for mesh in meshes:
        view = mesh.views[0] if mesh.views else automatic_view(mesh.vertices, mesh.faces)
        result = measure(mesh, view, plan, progress)
        yield write_measurements(folder / f"{mesh.name}.jsonl", result.measurements), result


def summary(result: Result) -> Iterator[dict[str, Any]]:
    """One flat row a recipe, for tables."""
    for label in result.bvhs:
        of_label = {each.kind: each for each in result.measurements if each.label == label}
        build = of_label.pop("build")
        rates = {kind: each.rays_per_second / 1e6 for kind, each in of_label.items()}
        yield {
            "scene": build.scene,
            "faces": build.faces,
            "label": label,
            "build_ms": build.seconds * 1e3,
            "sah": build.details["sah"],
            "mrays_per_second": rates,
        }
