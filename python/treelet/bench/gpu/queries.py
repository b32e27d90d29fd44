"""All hits, nearest points and containment on a CUDA device, held to the CPU's answers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

import treelet
from treelet import cuda
from treelet.bench.gpu.cases import Case, Recipe, Settings, warn
from treelet.bench.gpu.clock import Clock
from treelet.bench.gpu.rays import as_bits
from treelet.bench.records import Measurement

KINDS = ("count_hits", "intersect_all", "closest_point", "signed_distance", "contains")
_OF_RAYS = KINDS[:2]
_CHECKED = 10_000  # rays or points whose answers are compared with the CPU's


def measure_queries(
    case: Case, recipes: Sequence[Recipe], settings: Settings, clock: Clock
) -> Iterator[Measurement]:
    """Diffuse rays for the lists of hits, and random points in the mesh's box: kinds as the methods' names.

    "intersect_all" waits for the number of hits, so it is the slower the busier the device. `rays` of a
    measurement are points where it asks for these.
    """
    rays = next(each for each in case.make_rays(settings.width) if each.kind == "diffuse")
    inputs = dict.fromkeys(_OF_RAYS, (rays.origins, rays.directions))
    points = _points_in_box(case, settings.call_rays)
    arrays = {kind: tuple(map(_send, inputs.get(kind, (points,)))) for kind in KINDS}
    some = {kind: tuple(part[:_CHECKED] for part in inputs.get(kind, (points,))) for kind in KINDS}
    expected = {kind: as_bits(getattr(case.reference, kind)(*some[kind])) for kind in KINDS}
    for recipe in recipes:
        bvh = treelet.build(case.mesh.vertices, case.mesh.faces, recipe.text).to("cuda")
        for kind in KINDS:
            query = getattr(bvh, kind)
            wrong = _count_differences(as_bits(query(*map(_send, some[kind]))), expected[kind])
            if wrong:
                warn(f"{case.name}: {wrong} values of {kind} of {recipe.label} are not the CPU's")
            samples = [clock.time(lambda q=query, a=arrays[kind]: q(*a)) for _ in range(settings.repeats)]
            details = {"clock": clock.name, "checked": len(some[kind][0]), "disagreements": wrong}
            fields = {
                "scene": case.mesh.name,
                "faces": len(case.mesh.faces),
                "rays": arrays[kind][0].shape[0],
            }
            names = {"label": recipe.label, "recipe": treelet.parse_recipe(recipe.text)}
            yield Measurement(kind=kind, samples=samples, details=details, **fields, **names)


def _send(values: np.ndarray) -> Any:
    return cuda.copy_to_device(values, "float32")


def _points_in_box(case: Case, count: int) -> np.ndarray:
    low, high = case.mesh.vertices.min(axis=0), case.mesh.vertices.max(axis=0)
    return np.random.default_rng(0).uniform(low, high, (count, 3)).astype(np.float32)


def _count_differences(ours: Sequence[np.ndarray], theirs: Sequence[np.ndarray]) -> int:
    """Values that are not the same, all of an array of another length."""
    return sum(
        int((a != b).sum()) if a.shape == b.shape else max(a.size, b.size)
        for a, b in zip(ours, theirs, strict=True)
    )
