"""Time trimesh's own ray queries (embreex) against treelet's in their place: median seconds of each.

python bench/peers/trimesh_drop_in.py [--scene sphere] [--rays 100000] [--repeats 7]
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable

import numpy as np
import trimesh

import treelet.compat.trimesh
from treelet import scenes


def measure(calls: dict[str, Callable[[], object]], repeats: int) -> dict[str, tuple[float, float]]:
    """Median wall and CPU seconds of each call, which take turns, after one round that does not count."""
    samples: dict[str, list[tuple[float, float]]] = {name: [] for name in calls}
    for _ in range(repeats + 1):
        for name, call in calls.items():
            wall, cpu = time.perf_counter(), time.process_time()
            call()
            samples[name].append((time.perf_counter() - wall, time.process_time() - cpu))
    return {
        name: (statistics.median(s[0] for s in taken[1:]), statistics.median(s[1] for s in taken[1:]))
        for name, taken in samples.items()
    }


def main() -> None:
    """Print a line for each query."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--scene", default="sphere")
    parser.add_argument("--rays", type=int, default=100_000)
    parser.add_argument("--repeats", type=int, default=7)
    options = parser.parse_args()

    source = scenes.make(options.scene)
    mesh = trimesh.Trimesh(source.vertices, source.faces, process=False)
    rng = np.random.default_rng(1)
    low, high = mesh.bounds
    origins = rng.uniform(low, high, (options.rays, 3))
    directions = rng.normal(size=(options.rays, 3))
    engines = {
        "trimesh": trimesh.ray.ray_pyembree.RayMeshIntersector(mesh),
        "treelet": treelet.compat.trimesh.RayMeshIntersector(mesh),
    }
    queries = {
        "intersects_location": lambda engine: engine.intersects_location(origins, directions),
        "intersects_location, first hits": lambda engine: engine.intersects_location(
            origins, directions, False
        ),
        "intersects_first": lambda engine: engine.intersects_first(origins, directions),
        "contains_points": lambda engine: engine.contains_points(origins),
    }
    print(
        f"{options.scene}: {len(mesh.faces):,} faces, {options.rays:,} rays or points, treelet's threads "
        f"{treelet.thread_count()}"
    )
    for name, query in queries.items():
        calls = {kind: lambda query=query, engine=engine: query(engine) for kind, engine in engines.items()}
        for kind, (wall, cpu) in measure(calls, options.repeats).items():
            print(f"{name}: {kind} {wall:.3f} s, {cpu:.3f} s of CPU")


if __name__ == "__main__":
    main()
