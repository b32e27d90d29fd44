"""Measures builds and queries on a CUDA device, stage by stage, against the bytes they have to move.

    python -m treelet.bench.gpu [--scenes city,forest] [--triangles 1000000,10000000] [--output gpu.jsonl]

Prints one `Measurement` a line. Builds: kind "build" with the device's seconds by stage (medians), and
"build_call", the whole call as Python sees it. Updates: "refit" and "rebuild" of an updatable tree after all
vertices moved. Rays: "primary", "diffuse" and "ambient_occlusion" (any hit). What a call takes lies on the
device already. Needs no array library.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import treelet
from treelet import cuda
from treelet.bench.arguments import list_of, open_output, whole_number
from treelet.bench.records import Measurement
from treelet.render.rays import Rays, ambient_occlusion_rays, diffuse_rays, primary_rays
from treelet.scenes import catalog
from treelet.view import automatic_view

RECIPES = (
    "lbvh > bvh2",
    "lbvh > bvh8",
    "lbvh > treelet > bvh2",
    "lbvh > treelet > bvh8",
    "hploc > bvh2",
    "hploc > treelet > bvh8",
    "presplit(budget=30) > lbvh > treelet > bvh2",
)
SCENES = ("city", "forest", "terrain", "sphere")
TRIANGLES = (10_000, 1_000_000, 10_000_000, 30_000_000)
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
    details = _stage_details(stages, bvh.report)
    device = [sum(sample.values()) for sample in stages]
    return [
        Measurement(kind="build", samples=device, details=details, **common),
        Measurement(kind="build_call", samples=calls, **common),
    ], bvh


def measure_updates(mesh, recipe: str, repeats: int) -> list[Measurement]:
    """Time the updates of a tree over a mesh whose vertices have all moved, by a twentieth of its size."""
    vertices = cuda.copy_to_device(mesh.vertices, "float32")
    faces = cuda.copy_to_device(mesh.faces, "uint32")
    moved = cuda.copy_to_device(_move(mesh.vertices), "float32")
    bvh = treelet.build(vertices, faces, recipe, updatable=True)
    common = {"scene": mesh.name, "faces": len(mesh.faces), "label": recipe, "recipe": bvh.report.recipe}
    samples = _time(lambda: bvh.refit(moved), repeats)
    refit = Measurement(kind="refit", samples=samples, details=_update_details(bvh.report), **common)
    _make_room(bvh, moved)
    samples = _time(lambda: bvh.rebuild(moved), repeats)
    bvh.check()
    rebuild = Measurement(kind="rebuild", samples=samples, details=_update_details(bvh.report), **common)
    return [refit, rebuild]


def measure_rays(mesh, bvh, rays: Rays, repeats: int) -> Measurement:
    """Time one batch of rays that lies on the device."""
    origins = cuda.copy_to_device(rays.origins, "float32")
    directions = cuda.copy_to_device(rays.directions, "float32")
    query = bvh.occluded if rays.any_hit else bvh.intersect
    return Measurement(
        kind=rays.kind,
        scene=mesh.name,
        faces=len(mesh.faces),
        label=bvh.report.recipe,
        recipe=bvh.report.recipe,
        samples=_time(lambda: query(origins, directions, t_max=rays.t_max), repeats),
        rays=len(rays),
    )


def _time(call: Callable[[], object], repeats: int) -> list[float]:
    """Seconds until the device has done what a call enqueues."""
    samples = []
    for repeat in range(repeats + 1):
        cuda.synchronize()
        start = time.perf_counter()
        call()
        cuda.synchronize()
        if repeat > 0:  # the first loads kernels and maps memory
            samples.append(time.perf_counter() - start)
    return samples


def _move(vertices: np.ndarray) -> np.ndarray:
    """Waves through the mesh."""
    size = float(np.ptp(vertices, axis=0).max())
    waves = np.sin(vertices[:, [1, 2, 0]] * np.float32(8 / size))
    return vertices + np.float32(size / 20) * waves


def _update_details(report) -> dict[str, Any]:
    return {
        "layout_sah": report.layout_sah,
        "layout_sah_at_build": report.layout_sah_at_build,
        "held_bytes": report.held_bytes,
    }


def _make_room(bvh, moved) -> None:
    """Rebuild until the tree fits its memory, which grows where it did not."""
    bvh.rebuild(moved)
    try:
        bvh.check()
    except RuntimeError:
        bvh.rebuild(moved)
        bvh.check()


def run(scenes: Sequence[str], triangles: Sequence[int], repeats: int, width: int) -> Iterator[Measurement]:
    """All measurements, scene by scene."""
    for count in triangles:
        for name in scenes:
            mesh = catalog.make(name, count).rounded()
            ray_sets = None
            for recipe in RECIPES:
                builds, bvh = measure_builds(mesh, recipe, repeats)
                yield from builds
                yield from measure_updates(mesh, recipe, repeats)
                ray_sets = ray_sets or _make_rays(mesh, bvh.to("cpu"), width)
                for rays in ray_sets:
                    yield measure_rays(mesh, bvh, rays, repeats)


def _make_rays(mesh, bvh, width: int) -> list[Rays]:
    view = mesh.views[0] if mesh.views else automatic_view(mesh.vertices, mesh.faces)
    primary = primary_rays(view, width, width * 5 // 8)
    return [primary, diffuse_rays(bvh, mesh, primary), ambient_occlusion_rays(bvh, mesh, primary)]


def _stage_details(stages: list[dict[str, float]], report) -> dict[str, Any]:
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
        "million_triangles_per_second": report.faces / seconds / 1e6 if seconds > 0 else 0.0,
    }


def _read_scene(text: str) -> str:
    if text not in catalog.names():
        raise argparse.ArgumentTypeError(f"unknown scene {text!r}{catalog.suggestion(text, catalog.names())}")
    return text


def _parser() -> argparse.ArgumentParser:
    count = whole_number(catalog.FEWEST_TRIANGLES, catalog.MOST_TRIANGLES)
    parser = argparse.ArgumentParser(
        prog="python -m treelet.bench.gpu", description=(__doc__ or "").splitlines()[0]
    )
    parser.add_argument(
        "--scenes", type=list_of(_read_scene), default=SCENES, help="embedded ones, with commas between them"
    )
    parser.add_argument("--triangles", type=list_of(count), default=TRIANGLES, help="counts, likewise")
    parser.add_argument("--repeats", type=whole_number(1), default=9)
    parser.add_argument(
        "--width", type=whole_number(16), default=3200, help="pixels of the pictures whose rays are traced"
    )
    parser.add_argument("--output", type=Path, help="also append the lines to this file")
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the measurements as JSON lines; 1 where there is no GPU."""
    parser = _parser()
    options = parser.parse_args(arguments)
    output = open_output(parser, options.output, "a") if options.output else nullcontext()
    with output as file:
        if not cuda.is_available():
            print(cuda.why_unavailable(), file=sys.stderr)  # noqa: T201
            return 1
        machine = {"gpu": cuda.devices()[0].name}
        for measurement in run(options.scenes, options.triangles, options.repeats, options.width):
            measurement = replace(measurement, machine=measurement.machine | machine)
            line = json.dumps(measurement.as_dict(), allow_nan=False)
            print(line, flush=True)  # noqa: T201
            if file is not None:
                file.write(line + "\n")
                file.flush()
    return 0


if __name__ == "__main__":
    sys.exit(main())
