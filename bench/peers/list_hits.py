"""Race the list of all hits against other packages' lists, arrays in and arrays out.

python bench/peers/list_hits.py --triangles 200000 --rays 200000 sphere hairball

Rays start in and around a scene's box and aim into it. Packages that are not installed are skipped with the
reason: open3d, and trimesh with its Embree. The shortest of a few rounds counts, wall clock and CPU.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Sequence

import numpy as np

import treelet
from treelet import scenes
from treelet.bench.arguments import whole_number

ListHits = Callable[[np.ndarray, np.ndarray], int]


def treelet_list(mesh: treelet.Mesh) -> ListHits:
    """Return the number of listed hits, as the other contenders do."""
    bvh = treelet.build(mesh.vertices, mesh.faces)
    return lambda origins, directions: len(bvh.intersect_all(origins, directions).t)


def treelet_count(mesh: treelet.Mesh) -> ListHits:
    """Count alone."""
    bvh = treelet.build(mesh.vertices, mesh.faces)
    return lambda origins, directions: int(bvh.count_hits(origins, directions).sum())


def open3d_list(mesh: treelet.Mesh) -> ListHits:
    """List the hits with RaycastingScene.list_intersections."""
    import open3d

    scene = open3d.t.geometry.RaycastingScene(nthreads=treelet.thread_count())
    faces = mesh.faces.astype(np.uint32)
    scene.add_triangles(open3d.core.Tensor(mesh.vertices), open3d.core.Tensor(faces))

    def run(origins: np.ndarray, directions: np.ndarray) -> int:
        rays = open3d.core.Tensor(np.concatenate([origins, directions], axis=1))
        return len(scene.list_intersections(rays)["t_hit"].numpy())

    return run


def trimesh_list(mesh: treelet.Mesh) -> ListHits:
    """List the hits with intersects_location(multiple_hits=True), over Embree where that is installed."""
    import trimesh

    rays = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).ray
    return lambda origins, directions: len(rays.intersects_location(origins, directions)[0])


CONTENDERS = {
    "treelet list": treelet_list,
    "treelet count": treelet_count,
    "Open3D list": open3d_list,
    "trimesh list": trimesh_list,
}


def make_rays(mesh: treelet.Mesh, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Rays from in and around the box into it, (count, 3) float32 each."""
    rng = np.random.default_rng(1)
    lower, upper = mesh.bounds.astype(np.float64)

    def points(scale: float) -> np.ndarray:
        return (lower + upper) / 2 + rng.uniform(-scale / 2, scale / 2, (count, 3)) * (upper - lower)

    origins = points(1.5)
    return origins.astype(np.float32), (points(1.0) - origins).astype(np.float32)


def race(name: str, triangles: int, count: int, rounds: int) -> None:
    """Print one line a contender."""
    mesh = scenes.make(name, triangles)
    rays = make_rays(mesh, count)
    print(f"{name}: {len(mesh.faces):,} triangles, {count:,} rays, {treelet.thread_count()} threads")
    for label, make in CONTENDERS.items():
        try:
            run = make(mesh)
        except ImportError as error:
            print(f"  skipped {label}: {error}", file=sys.stderr)
            continue
        seconds, cpu_seconds = [], []
        for _ in range(rounds + 1):
            start, cpu_start = time.perf_counter(), time.process_time()
            hits = run(*rays)
            seconds.append(time.perf_counter() - start)
            cpu_seconds.append(time.process_time() - cpu_start)
        wall, cpu = min(seconds[1:]) * 1e9 / count, min(cpu_seconds[1:]) * 1e9 / count
        print(f"  {label:14} {hits:10,} hits  {wall:8.0f} ns a ray  {cpu:8.0f} ns of CPU")


def main(words: Sequence[str] | None = None) -> None:
    """Run the command."""
    number = whole_number(1)
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="+", choices=scenes.names())
    parser.add_argument("--triangles", type=number, default=200_000)
    parser.add_argument("--rays", type=number, default=200_000)
    parser.add_argument("--rounds", type=number, default=3)
    options = parser.parse_args(words)
    for name in options.scenes:
        race(name, options.triangles, options.rays, options.rounds)


if __name__ == "__main__":
    main()
