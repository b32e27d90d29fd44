"""Rays that lie in the memory of the host, streamed through the device: what a batch of any size costs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

import treelet
from treelet.bench.gpu.cases import Case, Recipe, Settings, warn
from treelet.bench.gpu.clock import Clock, HostClock
from treelet.bench.gpu.rays import as_bits
from treelet.bench.records import Measurement

_RAY_BYTES = 24 + 16  # sent, and answered


def measure_stream(
    case: Case, recipes: Sequence[Recipe], settings: Settings, _: Clock
) -> Iterator[Measurement]:
    """The diffuse rays of the scene, repeated to the batch that is wanted, in numpy arrays: kind "stream"."""
    rays = next(each for each in case.make_rays(settings.width) if each.kind == "diffuse")
    copies = -(-settings.stream_rays // len(rays))
    origins, directions = np.tile(rays.origins, (copies, 1)), np.tile(rays.directions, (copies, 1))
    expected = as_bits(rays.trace(case.reference))
    clock = HostClock()
    for recipe in recipes:
        bvh = treelet.build(case.mesh.vertices, case.mesh.faces, recipe.text).to("cuda")
        try:
            answers = bvh.intersect(origins, directions)
        except (TypeError, RuntimeError) as error:
            warn(f"streams of {recipe.label} are left out: {error}")
            continue
        found = [array.reshape(copies, -1) for array in as_bits(answers)]
        wrong = sum(int((ours != theirs).sum()) for ours, theirs in zip(found, expected, strict=True))
        samples = [clock.time(lambda bvh=bvh: bvh.intersect(origins, directions)) for _ in range(3)]
        details = {"bytes": _RAY_BYTES * len(origins), "disagreements": wrong, "checked": len(origins)}
        fields = {"scene": case.mesh.name, "faces": len(case.mesh.faces), "rays": len(origins)}
        names = {"label": recipe.label, "recipe": treelet.parse_recipe(recipe.text)}
        yield Measurement(kind="stream", samples=samples, details=details, **fields, **names)
