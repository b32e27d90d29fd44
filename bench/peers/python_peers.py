"""Race treelet's Python package against others that trace rays, arrays in and arrays out.

python bench/peers/python_peers.py --out out/python-peers city kitchen

Every file in adapters/ is one contender; those whose packages are not installed are skipped with the reason.
All trace the same primary and diffuse rays of each scene, in turn, and are asked for the closest t.
"""

from __future__ import annotations

import argparse
import importlib
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from make_scene import make_scene_file
from scene_file import SceneFile

import treelet
from treelet import scenes
from treelet.bench import Measurement, write_measurements
from treelet.bench.arguments import whole_number

ADAPTERS = Path(__file__).parent / "adapters"
RELATIVE_TOLERANCE = 1e-4  # as agreement.h

Trace = Callable[[np.ndarray, np.ndarray], np.ndarray]
Build = Callable[[np.ndarray, np.ndarray], Trace]


@dataclass(frozen=True)
class Adapters:
    """Contenders by name, and why others are not among them."""

    ready: dict[str, Build]
    missing: dict[str, str]


@dataclass
class Entrant:
    """A contender's tree and its timings so far."""

    build: Build
    trace: Trace | None = None
    builds: list[float] = field(default_factory=list)
    traces: dict[str, list[float]] = field(default_factory=dict)
    differing: dict[str, float] = field(default_factory=dict)


def load_adapters() -> Adapters:
    """Import every adapter; this library's comes first."""
    adapters = Adapters({}, {})
    names = sorted(
        (path.stem for path in ADAPTERS.glob("*.py")), key=lambda name: (name != "treelet_arrays", name)
    )
    for name in names:
        try:
            module = importlib.import_module(f"adapters.{name}")
        except Exception as error:  # whatever a package does where a part of it is missing
            adapters.missing[name] = f"{type(error).__name__}: {error}"
        else:
            adapters.ready[module.NAME] = module.build
    return adapters


def race(scene: SceneFile, builds: dict[str, Build], rounds: int) -> dict[str, Entrant]:
    """Build and trace with each in turn; the first round is not counted.

    Answers are compared with those of the first contender.
    """
    entrants = {name: Entrant(build) for name, build in builds.items()}
    faces = scene.faces.astype(np.int32)
    for turn in range(rounds + 1):
        for entrant in entrants.values():
            entrant.trace = None
            start = time.perf_counter()
            entrant.trace = entrant.build(scene.vertices, faces)
            if turn > 0:
                entrant.builds.append(time.perf_counter() - start)
    for rays in scene.ray_sets:
        if not rays.any_hit:
            _race_rays(entrants, rays, rounds)
    return entrants


def _race_rays(entrants: dict[str, Entrant], rays, rounds: int) -> None:
    first = next(iter(entrants.values()))
    expected = first.trace(rays.origins, rays.directions)
    for turn in range(rounds + 1):
        for entrant in entrants.values():
            start = time.perf_counter()
            t = entrant.trace(rays.origins, rays.directions)
            seconds = time.perf_counter() - start
            if turn > 0:
                entrant.traces.setdefault(rays.kind, []).append(seconds)
            else:
                entrant.differing[rays.kind] = share_of_differences(expected, np.asarray(t))


def share_of_differences(expected: np.ndarray, actual: np.ndarray) -> float:
    """The share of rays whose t differ, hit against miss included."""
    return 1.0 - float(np.isclose(actual, expected, rtol=RELATIVE_TOLERANCE, atol=0.0).mean())


def measurements(name: str, scene: SceneFile, entrants: dict[str, Entrant]) -> list[Measurement]:
    """What `race` timed, as `treelet bench` writes it."""
    common = {"scene": name, "faces": len(scene.faces), "threads": treelet.thread_count()}
    sizes = {rays.kind: len(rays) for rays in scene.ray_sets}
    records = []
    for label, entrant in entrants.items():
        which = {"label": label, "recipe": label, **common}
        records.append(Measurement(kind="build", samples=entrant.builds, **which))
        for kind, samples in entrant.traces.items():
            details = {"differing": entrant.differing[kind]}
            records.append(
                Measurement(kind=kind, samples=samples, rays=sizes[kind], details=details, **which)
            )
    return records


def main(words: Sequence[str] | None = None) -> None:
    """Run the command."""
    options = _parse(words)
    adapters = load_adapters()
    for name, reason in adapters.missing.items():
        print(f"skipped {name}: {reason}", file=sys.stderr)
    for name in options.scenes:
        mesh = scenes.load(name, options.triangles if name in scenes.names() else None)
        with tempfile.TemporaryDirectory() as folder:
            scene = make_scene_file(Path(folder) / "scene", mesh, options.width, options.height)
        records = measurements(mesh.name, scene, race(scene, adapters.ready, options.rounds))
        path = write_measurements(options.out / f"{mesh.name}.jsonl", records)
        print(f"{path}: {len(scene.faces):,} triangles")
        _print_table(records)


def _print_table(records: Sequence[Measurement]) -> None:
    for record in records:
        what = (
            f"{record.rays_per_second / 1e6:8.2f} Mrays/s"
            if record.rays
            else f"{record.seconds * 1e3:8.1f} ms"
        )
        note = f"  differing {record.details['differing']:.1e}" if record.rays else ""
        print(f"  {record.label:14} {record.kind:8} {what}{note}")


def _parse(words: Sequence[str] | None) -> argparse.Namespace:
    count = whole_number(1)
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="+", metavar="SCENE")
    parser.add_argument("--out", type=Path, default=Path("out/python-peers"), help="folder for the results")
    parser.add_argument("--triangles", type=count, default=200_000, help="of embedded scenes")
    parser.add_argument("--width", type=count, default=1024, help="of the picture whose rays are traced")
    parser.add_argument("--height", type=count, default=640)
    parser.add_argument("--rounds", type=count, default=5)
    return parser.parse_args(words)


if __name__ == "__main__":
    main()
