"""Refit or rebuild? Measures both, frame by frame, on meshes that move.

    python -m treelet.bench.animation --output animation.jsonl

Without names it takes the waving terrain, which needs no files, and every NAME_anim.npz in the folder that
TREELET_SCENES names (docs/benchmarks.md has the format). Each line is a `Measurement`: for every frame
and every way an update (kind "refit" or "rebuild") and the tracing of diffuse rays (kind "diffuse").
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

import treelet
from treelet.bench.arguments import open_output, whole_number
from treelet.bench.records import Measurement
from treelet.mesh import Mesh
from treelet.render.rays import Rays, diffuse_rays, primary_rays
from treelet.scenes import external
from treelet.scenes.catalog import FEWEST_TRIANGLES, MOST_TRIANGLES, make
from treelet.view import View, automatic_view

WAVING_TERRAIN = "waving_terrain"
_SUFFIX = "_anim.npz"


@dataclass(frozen=True)
class Animation:
    """A mesh that moves: the same faces in every frame."""

    name: str
    faces: np.ndarray  # (F, 3) int32
    frames: np.ndarray  # (K, V, 3) float32
    view: View

    def mesh(self, frame: int) -> Mesh:
        """The mesh as it is in a frame."""
        return Mesh(self.frames[frame], self.faces, self.name, (self.view,))


@dataclass(frozen=True)
class Way:
    """How a tree follows the mesh."""

    action: str  # "refit" or "rebuild"
    recipe: str

    @property
    def label(self) -> str:
        """As "rebuild balanced"."""
        return f"{self.action} {self.recipe}"


WAYS = (
    Way("refit", "fast"),
    Way("refit", "balanced"),
    Way("rebuild", "fast"),
    Way("rebuild", "balanced"),
)


@dataclass(frozen=True)
class Plan:
    """What to measure, and how often."""

    ways: tuple[Way, ...] = WAYS
    width: int = 640  # pixels of the picture whose diffuse rays are traced
    height: int = 400
    repeats: int = 3
    seed: int = 0


@dataclass
class _Subject:
    """A way's tree and its timings in one frame."""

    way: Way
    bvh: treelet.Bvh
    updates: list[float] = field(default_factory=list)
    traces: list[float] = field(default_factory=list)


def measure(animation: Animation, plan: Plan) -> Iterator[Measurement]:
    """Build every way's tree over the first frame, then let it follow the others.

    All ways trace the same rays, and take turns, so that a machine that gets slower or faster meanwhile
    treats all alike.
    """
    first = animation.mesh(0)
    subjects = [
        _Subject(way, treelet.build(first.vertices, first.faces, way.recipe, updatable=True))
        for way in plan.ways
    ]
    for frame in range(1, len(animation.frames)):
        mesh = animation.mesh(frame)
        for subject in subjects:
            subject.updates, subject.traces = [], []
        _time_updates(subjects, mesh, plan.repeats)
        primary = primary_rays(animation.view, plan.width, plan.height, plan.seed)
        rays = diffuse_rays(subjects[0].bvh, mesh, primary, seed=plan.seed)
        _time_rays(subjects, rays, plan.repeats)
        for subject in subjects:
            yield from _records(subject, mesh, rays, frame)


def waving_terrain(triangles: int, frames: int) -> Animation:
    """Waves that run across a mountain range and grow."""
    mesh = make("terrain", triangles)
    x, y = mesh.vertices[:, 0], mesh.vertices[:, 1]
    moved = np.repeat(mesh.vertices[None], frames, axis=0)
    for frame in range(frames):
        time_now = frame / max(frames - 1, 1)
        swell = np.sin(1.7 * x + 4 * time_now) * np.cos(1.3 * y - 3 * time_now)
        moved[frame, :, 2] += (0.6 * time_now * swell).astype(np.float32)
        moved[frame, :, 0] += (0.3 * time_now * np.sin(2.1 * y + 5 * time_now)).astype(np.float32)
    return Animation(WAVING_TERRAIN, mesh.faces, moved, mesh.views[0])


def load_animation(path: Path) -> Animation:
    """Read NAME_anim.npz; the view is the first camera of the scene NAME beside it, or an automatic one."""
    name = path.name.removesuffix(_SUFFIX)
    faces, frames = _read_arrays(path)
    if frames.ndim != 3 or frames.shape[2] != 3 or len(frames) < 2:
        raise ValueError(f"{path}: vertices must have shape (K, V, 3) with two frames at least")
    if faces.ndim != 2 or faces.shape[1] != 3 or faces.dtype.kind not in "iu":
        raise ValueError(f"{path}: faces must be integers of shape (F, 3)")
    if faces.size and not 0 <= faces.min() <= faces.max() < frames.shape[1]:
        raise ValueError(f"{path}: faces must be indices of the {frames.shape[1]} vertices")
    views = external.load_external(name).views if name in external.external_names() else ()
    return Animation(name, faces, frames, views[0] if views else automatic_view(frames[0], faces))


def _read_arrays(path: Path) -> tuple[np.ndarray, np.ndarray]:
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            return arrays["faces"], arrays["vertices"].astype(np.float32, copy=False)
    except (KeyError, TypeError, ValueError, EOFError, BadZipFile) as error:
        raise ValueError(f"{path} is no .npz file with numeric arrays `faces` and `vertices`") from error


def find_animations(names: Sequence[str], triangles: int, frames: int) -> Iterator[Animation]:
    """The animations of these names, or all there are. Raises FileNotFoundError for one that is not there."""
    folder = Path(os.environ.get(external.VARIABLE) or ".")
    if not names:
        found = sorted(folder.glob("*" + _SUFFIX)) if os.environ.get(external.VARIABLE) else []
        names = [WAVING_TERRAIN, *(path.name.removesuffix(_SUFFIX) for path in found)]
    for name in names:
        path = folder / (name + _SUFFIX)
        if name == WAVING_TERRAIN:
            yield waving_terrain(triangles, frames)
        elif path.exists():
            yield load_animation(path)
        else:
            raise FileNotFoundError(
                f"no animation {name!r}: it is not {WAVING_TERRAIN}, and {path} is not there"
            )


def _time_updates(subjects: Sequence[_Subject], mesh: Mesh, repeats: int) -> None:
    for _ in range(repeats):
        for subject in subjects:
            update = getattr(subject.bvh, subject.way.action)
            start = time.perf_counter()
            update(mesh.vertices)
            subject.updates.append(time.perf_counter() - start)


def _time_rays(subjects: Sequence[_Subject], rays: Rays, repeats: int) -> None:
    for repeat in range(repeats + 1):
        for subject in subjects:
            start = time.perf_counter()
            rays.trace(subject.bvh)
            if repeat > 0:  # the first touches the tree's memory
                subject.traces.append(time.perf_counter() - start)


def _records(subject: _Subject, mesh: Mesh, rays: Rays, frame: int) -> Iterator[Measurement]:
    report = subject.bvh.report
    work = subject.bvh.traversal_cost(rays.origins, rays.directions)
    common: dict[str, Any] = {
        "scene": mesh.name,
        "faces": len(mesh.faces),
        "label": subject.way.label,
        "recipe": report.recipe,
        "threads": treelet.thread_count(),
    }
    quality = {
        "frame": frame,
        "action": subject.way.action,
        "layout_sah": report.layout_sah,
        "layout_sah_at_build": report.layout_sah_at_build,
        "hidden": report.hidden,
        "held_bytes": report.held_bytes,
    }
    per_ray = {
        "frame": frame,
        "action": subject.way.action,
        "nodes_per_ray": float(work.nodes.mean()) if len(rays) else 0.0,
        "triangles_per_ray": float(work.triangles.mean()) if len(rays) else 0.0,
    }
    yield Measurement(kind=subject.way.action, samples=subject.updates, details=quality, **common)
    yield Measurement(kind="diffuse", samples=subject.traces, rays=len(rays), details=per_ray, **common)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m treelet.bench.animation", description="Refit against rebuild, frame by frame."
    )
    parser.add_argument(
        "names", nargs="*", help=f"{WAVING_TERRAIN}, or NAME of NAME{_SUFFIX}; all by default"
    )
    triangles = whole_number(FEWEST_TRIANGLES, MOST_TRIANGLES)
    parser.add_argument("--triangles", type=triangles, default=200_000, help=f"of {WAVING_TERRAIN}")
    parser.add_argument("--frames", type=whole_number(2), default=16, help=f"of {WAVING_TERRAIN}")
    parser.add_argument("--width", type=whole_number(1), default=Plan.width)
    parser.add_argument("--height", type=whole_number(1), default=Plan.height)
    parser.add_argument("--repeats", type=whole_number(1), default=Plan.repeats)
    parser.add_argument("--output", type=Path, help="a file instead of the standard output")
    return parser


def main(arguments: Sequence[str] | None = None) -> None:
    """The command."""
    parser = _parser()
    options = parser.parse_args(arguments)
    plan = Plan(width=options.width, height=options.height, repeats=options.repeats)
    try:
        animations = list(find_animations(options.names, options.triangles, options.frames))
    except (OSError, ValueError) as error:
        parser.error(str(error))
    output = open_output(parser, options.output, "w") if options.output else nullcontext(sys.stdout)
    with output as lines:
        for animation in animations:
            for measurement in measure(animation, plan):
                lines.write(json.dumps(measurement.as_dict(), allow_nan=False) + "\n")
                lines.flush()


if __name__ == "__main__":
    main()
