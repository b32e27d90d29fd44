"""Race all hits, counts, closest points and signed distances against other Python packages.

python bench/peers/python_queries.py --out out/python-queries crytek_sponza dragon sphere

Everybody gets the same arrays in one process, in turn; the first round is not counted. Packages that are not
installed are skipped with the reason: open3d, libigl, trimesh (with embreex; rtree and scipy for points).
Rays start in and around the scene's box and aim into it, points lie in the box and a tenth around.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from query_contenders import CONTENDERS, SLOWER, Ask

import treelet
from treelet import scenes
from treelet.bench import Measurement, write_measurements
from treelet.bench.arguments import whole_number

QUERIES = {"all_hits": "rays", "counts": "rays", "closest_point": "points", "signed_distance": "points"}
TOLERANCE = 1e-4  # of distances, in units of the scene's extent


@dataclass
class Timing:
    """What one contender took for one query, and how its answers differ from the first's."""

    items: int
    seconds: list[float] = field(default_factory=list)
    cpu_seconds: list[float] = field(default_factory=list)
    differing: float = 0.0
    other_sign: float = 0.0

    @property
    def cpu_ns(self) -> float:
        """Median nanoseconds of all processors for one ray or point."""
        return statistics.median(self.cpu_seconds) / self.items * 1e9


def make_inputs(mesh: treelet.Mesh, rays: int, points: int) -> dict[str, tuple[np.ndarray, ...]]:
    """Arguments by kind: origins and directions, or points, float32."""
    rng = np.random.default_rng(1)
    lower, upper = mesh.bounds.astype(np.float64)

    def around(scale: float, count: int) -> np.ndarray:
        return (lower + upper) / 2 + rng.uniform(-scale / 2, scale / 2, (count, 3)) * (upper - lower)

    origins = around(1.5, rays)
    directions = around(1.0, rays) - origins
    return {
        "rays": (origins.astype(np.float32), directions.astype(np.float32)),
        "points": (around(1.2, points).astype(np.float32),),
    }


def load_contenders(mesh: treelet.Mesh) -> dict[str, dict[str, Ask]]:
    """Build each contender's tree."""
    ready = {}
    for name, make in CONTENDERS.items():
        try:
            ready[name] = make(mesh.vertices, mesh.faces)
        except Exception as error:  # whatever a package does where a part of it is missing
            print(f"skipped {name}: {type(error).__name__}: {error}", file=sys.stderr)
    return ready


def race(
    mesh: treelet.Mesh, inputs: dict[str, tuple[np.ndarray, ...]], rounds: int
) -> dict[str, dict[str, Timing]]:
    """Timings by query and contender."""
    contenders = load_contenders(mesh)
    extent = float(np.ptp(mesh.bounds, axis=0).max())
    timings: dict[str, dict[str, Timing]] = {}
    for query, kind in QUERIES.items():
        asks = {name: asked[query] for name, asked in contenders.items() if query in asked}
        expected = np.asarray(asks["treelet"](*inputs[kind]))
        timings[query] = {}
        for turn in range(rounds + 1):
            for name, ask in asks.items():
                step = SLOWER.get((name, query), 1)
                given = [array[::step] for array in inputs[kind]]
                timing = timings[query].setdefault(name, Timing(len(given[0])))
                start, cpu_start = time.perf_counter(), time.process_time()
                found = np.asarray(ask(*given))
                if turn > 0:
                    timing.seconds.append(time.perf_counter() - start)
                    timing.cpu_seconds.append(time.process_time() - cpu_start)
                else:
                    _compare(timing, expected[::step], found, TOLERANCE * extent if kind == "points" else 0.0)
    return timings


def _compare(timing: Timing, expected: np.ndarray, found: np.ndarray, tolerance: float) -> None:
    timing.differing = float(np.mean(~(np.abs(np.abs(found) - np.abs(expected)) <= tolerance)))
    clear = np.abs(expected) > tolerance
    timing.other_sign = float(np.mean((np.sign(found) != np.sign(expected)) & clear))


def measurements(name: str, faces: int, timings: dict[str, dict[str, Timing]]) -> list[Measurement]:
    """What `race` timed, as `treelet bench` writes it."""
    return [
        Measurement(
            kind=query,
            scene=name,
            faces=faces,
            label=label,
            recipe=label,
            samples=timing.seconds,
            rays=timing.items,
            threads=treelet.thread_count(),
            details={
                "cpu_seconds": timing.cpu_seconds,
                "differing": timing.differing,
                "other_sign": timing.other_sign,
            },
        )
        for query, contenders in timings.items()
        for label, timing in contenders.items()
    ]


def print_table(timings: dict[str, dict[str, Timing]]) -> None:
    """A line a query and contender: wall clock and CPU for one ray or point, and how many times ours."""
    for query, contenders in timings.items():
        ours = contenders["treelet"]
        for name, timing in contenders.items():
            wall = statistics.median(timing.seconds) / timing.items * 1e9
            ratio = wall / (statistics.median(ours.seconds) / ours.items * 1e9)
            print(
                f"  {query:16} {name:8} {wall:10.0f} ns {timing.cpu_ns:10.0f} ns of CPU  {ratio:7.2f} x, "
                f"CPU {timing.cpu_ns / ours.cpu_ns:7.2f} x  differing {timing.differing:.1e}, "
                f"other sign {timing.other_sign:.1e}"
            )


def main(words: Sequence[str] | None = None) -> None:
    """Run the command."""
    count = whole_number(1)
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="+", metavar="SCENE")
    parser.add_argument("--out", type=Path, default=Path("out/python-queries"), help="folder for the results")
    parser.add_argument("--triangles", type=count, default=200_000, help="of embedded scenes")
    parser.add_argument("--rays", type=count, default=200_000)
    parser.add_argument("--points", type=count, default=100_000)
    parser.add_argument("--rounds", type=count, default=5)
    options = parser.parse_args(words)
    for name in options.scenes:
        mesh = scenes.load(name, options.triangles if name in scenes.names() else None)
        timings = race(mesh, make_inputs(mesh, options.rays, options.points), options.rounds)
        records = measurements(mesh.name, len(mesh.faces), timings)
        path = write_measurements(options.out / f"{mesh.name}.jsonl", records)
        print(f"{path}: {len(mesh.faces):,} triangles, {treelet.thread_count()} threads")
        print_table(timings)


if __name__ == "__main__":
    main()
