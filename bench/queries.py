"""Compare queries with those of other Python packages: the same points in one process, alternating, medians.

    python bench/queries.py [--scene sphere] [--triangles 300000] [--points 20000] [--rounds 3]

Prints one JSON line a contender: processor nanoseconds a point, and the largest difference of its distances
from ours in units of the mesh's extent. Packages that are not installed (open3d, libigl, trimesh with rtree)
are left out.
"""

from __future__ import annotations

import argparse
import json
import statistics
import time
from collections.abc import Callable
from importlib import import_module

import numpy as np

import treelet
from treelet import scenes

Distances = Callable[[np.ndarray], np.ndarray]


def _ask_treelet(vertices: np.ndarray, faces: np.ndarray) -> Distances:
    bvh = treelet.build(vertices, faces)
    return lambda points: bvh.closest_point(points).distance


def _ask_open3d(vertices: np.ndarray, faces: np.ndarray) -> Distances:
    o3d = import_module("open3d")
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(o3d.core.Tensor(vertices), o3d.core.Tensor(faces.astype(np.uint32)))

    def distances(points: np.ndarray) -> np.ndarray:
        found = scene.compute_closest_points(o3d.core.Tensor(points))["points"].numpy()
        return np.linalg.norm(found - points, axis=1)

    return distances


def _ask_libigl(vertices: np.ndarray, faces: np.ndarray) -> Distances:
    igl = import_module("igl")
    tree = igl.AABB()
    corners, indices = vertices.astype(np.float64), faces.astype(np.int64)
    tree.init(corners, indices)
    return lambda points: np.sqrt(tree.squared_distance(corners, indices, points.astype(np.float64))[0])


def _ask_trimesh(vertices: np.ndarray, faces: np.ndarray) -> Distances:
    trimesh = import_module("trimesh")
    import_module("rtree")
    query = trimesh.proximity.ProximityQuery(trimesh.Trimesh(vertices, faces, process=False))
    return lambda points: query.on_surface(points)[1]


CONTENDERS = {
    "treelet": _ask_treelet,
    "open3d": _ask_open3d,
    "libigl": _ask_libigl,
    "trimesh": _ask_trimesh,
}
SLOW = {"trimesh": 50}  # gets a part of the points, that of this divisor


def race(
    vertices: np.ndarray, faces: np.ndarray, points: np.ndarray, rounds: int
) -> dict[str, dict[str, float]]:
    """Nanoseconds a point and the largest difference, by contender."""
    contenders = {}
    for name, make in CONTENDERS.items():
        try:
            contenders[name] = make(vertices, faces)
        except ImportError as error:
            print(f"# {name} is left out: {error}")
    expected = contenders["treelet"](points)
    extent = float(np.ptp(vertices, axis=0).max())
    times: dict[str, list[float]] = {name: [] for name in contenders}
    differences = {}
    for _ in range(rounds):
        for name, ask in contenders.items():
            given = points[:: SLOW.get(name, 1)]
            start = time.process_time()
            found = ask(given)
            times[name].append((time.process_time() - start) / len(given) * 1e9)
            differences[name] = float(np.abs(found - expected[:: SLOW.get(name, 1)]).max()) / extent
    return {
        name: {"cpu_ns": statistics.median(times[name]), "difference": differences[name]}
        for name in contenders
    }


def main() -> None:
    """Race on random points in the scene's box, a tenth larger on each side."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--scene", default="sphere")
    parser.add_argument("--triangles", type=int, default=300_000)
    parser.add_argument("--points", type=int, default=20_000)
    parser.add_argument("--rounds", type=int, default=3)
    given = parser.parse_args()
    scene = scenes.make(given.scene, given.triangles)
    low, high = scene.vertices.min(axis=0), scene.vertices.max(axis=0)
    margin = 0.1 * (high - low)
    points = np.random.default_rng(1).uniform(low - margin, high + margin, (given.points, 3))
    results = race(scene.vertices, scene.faces, points.astype(np.float32), given.rounds)
    for name, result in results.items():
        line = {"query": "closest_point", "scene": given.scene, "triangles": len(scene.faces)}
        print(json.dumps({**line, "points": given.points, "contender": name, **result}))


if __name__ == "__main__":
    main()
