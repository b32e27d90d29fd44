"""Measures builds and queries on a CUDA device, stage by stage, against the bytes they have to move.

    python -m treelet.bench.gpu [--scenes city,forest] [--triangles 1000000,10000000] [--output gpu.jsonl]

Prints one `Measurement` a line. Builds: kind "build" with the device's seconds by stage (medians), and
"build_call", the whole call as Python sees it. Rays: "primary" and "diffuse", on rays that lie on the
device already. Needs no array library.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import treelet
from treelet import cuda
from treelet.bench.records import Measurement
from treelet.render.rays import Rays, diffuse_rays, primary_rays
from treelet.scenes.lookup import load
from treelet.view import automatic_view

RECIPES = (
    "lbvh > bvh2",
    "lbvh > bvh8",
    "lbvh > treelet > bvh2",
    "lbvh > treelet > bvh8",
)
SCENES = ("city", "forest", "terrain", "sphere")
TRIANGLES = (10_000, 1_000_000, 10_000_000)
# Bytes a triangle that a stage cannot avoid to move: each input read once, each output written once. A mesh
# has 12 bytes of indices and about half a vertex of 12 bytes a triangle; the sort makes 8 passes of 12 bytes
# in and out, and reads its keys once more.
_MESH = 18.0
STAGE_BYTES = {
    "survey the mesh": _MESH,
    "sort Morton codes": _MESH + 12 + 8 * 24 + 8,
    "emit LBVH and fit boxes": _MESH + 12 + 64 + 32 + 12,
    "restructure treelets": 3 * 64 + 4,
    "cost of the tree": 64 + 8,
    "collapse": 64 + 32,
    "pack bvh2": 64 + 16 + _MESH,  # and the layout's own bytes
    "pack bvh8": 64 + 32 + _MESH,
}


def measure_builds(mesh, recipe: str, repeats: int) -> tuple[list[Measurement], Any]:
    """Time a recipe over a mesh on the device; returns the measurements and the last tree."""
    vertices = cuda.copy_to_device(mesh.vertices, "float32")
    faces = cuda.copy_to_device(mesh.faces, "uint32")
    calls, stages = [], []
    for repeat in range(repeats + 1):
        start = time.perf_counter()
        bvh = treelet.build(vertices, faces, recipe)
        seconds = time.perf_counter() - start
        if repeat > 0:  # the first loads kernels and maps memory
            calls.append(seconds)
            stages.append({stage.name: stage.seconds for stage in bvh.report.stages})
    common = {"scene": mesh.name, "faces": len(mesh.faces), "label": recipe, "recipe": bvh.report.recipe}
    details = _stage_details(stages, bvh.report, len(mesh.faces))
    device = [sum(sample.values()) for sample in stages]
    return [
        Measurement(kind="build", samples=device, details=details, **common),
        Measurement(kind="build_call", samples=calls, **common),
    ], bvh


def measure_rays(mesh, bvh, rays: Rays, repeats: int) -> Measurement:
    """Time one batch of rays that lies on the device."""
    origins = cuda.copy_to_device(rays.origins, "float32")
    directions = cuda.copy_to_device(rays.directions, "float32")
    samples = []
    for repeat in range(repeats + 1):
        cuda.synchronize()
        start = time.perf_counter()
        bvh.intersect(origins, directions)
        cuda.synchronize()
        if repeat > 0:
            samples.append(time.perf_counter() - start)
    return Measurement(
        kind=rays.kind,
        scene=mesh.name,
        faces=len(mesh.faces),
        label=bvh.report.recipe,
        recipe=bvh.report.recipe,
        samples=samples,
        rays=len(rays),
    )


def run(scenes: Sequence[str], triangles: Sequence[int], repeats: int, width: int) -> Iterator[Measurement]:
    """All measurements, scene by scene."""
    for count in triangles:
        for name in scenes:
            mesh = load(name, count).rounded()
            ray_sets = None
            for recipe in RECIPES:
                builds, bvh = measure_builds(mesh, recipe, repeats)
                yield from builds
                ray_sets = ray_sets or _make_rays(mesh, bvh.to("cpu"), width)
                for rays in ray_sets:
                    yield measure_rays(mesh, bvh, rays, repeats)


def _make_rays(mesh, bvh, width: int) -> list[Rays]:
    view = mesh.views[0] if mesh.views else automatic_view(mesh.vertices, mesh.faces)
    primary = primary_rays(view, width, width * 5 // 8)
    return [primary, diffuse_rays(bvh, mesh, primary)]


def _stage_details(stages: list[dict[str, float]], report, faces: int) -> dict[str, Any]:
    """Medians of each stage, and the bandwidth that its unavoidable bytes make of them."""
    rows = []
    for name in stages[0]:
        seconds = statistics.median(sample[name] for sample in stages)
        moved = STAGE_BYTES[name] * faces + (report.bytes if name.startswith("pack") else 0)
        rows.append({"name": name, "seconds": seconds, "bytes": moved, "bytes_per_second": moved / seconds})
    return {
        "stages": rows,
        "sah": report.sah,
        "nodes": report.nodes,
        "depth": report.depth,
        "bytes": report.bytes,
        "million_triangles_per_second": faces / sum(row["seconds"] for row in rows) / 1e6,
    }


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the measurements as JSON lines; 1 where there is no GPU."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--scenes", default=",".join(SCENES), help="names, with commas between them")
    parser.add_argument("--triangles", default=",".join(map(str, TRIANGLES)), help="counts, likewise")
    parser.add_argument("--repeats", type=int, default=9)
    parser.add_argument(
        "--width", type=int, default=3200, help="pixels of the pictures whose rays are traced"
    )
    parser.add_argument("--output", help="also append the lines to this file")
    options = parser.parse_args(arguments)
    if not cuda.is_available():
        print(cuda.why_unavailable(), file=sys.stderr)  # noqa: T201
        return 1
    machine = {"gpu": cuda.devices()[0].name}
    scenes, triangles = options.scenes.split(","), [int(count) for count in options.triangles.split(",")]
    for measurement in run(scenes, triangles, options.repeats, options.width):
        measurement = replace(measurement, machine=measurement.machine | machine)
        line = json.dumps(measurement.as_dict(), allow_nan=False)
        print(line, flush=True)  # noqa: T201
        if options.output:
            with open(options.output, "a", encoding="utf-8") as file:
                file.write(line + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
