"""A cloth that waves in the wind: refit every frame, rebuild when rays have become too slow.

    python examples/animate.py

A tree over a mesh that moves is built with `updatable=True`. `refit` keeps its shape, which takes a small
part of a build's time but lets boxes overlap more and more; `rebuild` makes it as good as new. The report
tells what a ray costs now and what it cost when the tree was built, so that each frame can decide by itself.
"""

import time

import numpy as np

import treelet

CELLS = 300
FRAMES = 40
RAYS = 200_000
WORST = 1.1  # a tree that costs rays so many times what it did at its build is built anew


def cloth(cells: int) -> tuple[np.ndarray, np.ndarray]:
    """The unit square as (V, 2) float32 positions and (F, 3) faces."""
    across, along = np.meshgrid(*[np.linspace(0, 1, cells + 1, dtype=np.float32)] * 2, indexing="ij")
    corner = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    a, b, c, d = corner, corner + cells + 1, corner + cells + 2, corner + 1
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return np.stack([across.ravel(), along.ravel()], axis=1), faces


def positions(rest: np.ndarray, seconds: float) -> np.ndarray:
    """(V, 3) float32: where the wind has the cloth at this time. It hangs from the side at x = 0."""
    x, y = rest.T
    wave = np.sin(9 * x - 5 * seconds) + 0.4 * np.sin(14 * y + 3 * seconds)
    sag = 0.4 * x * x * np.sin(0.7 * seconds)
    return np.stack([x - 0.3 * sag, y, 0.25 * x * wave + sag], axis=1).astype(np.float32)


def follow(bvh: treelet.Bvh, vertices: np.ndarray) -> str:
    """Bring the tree to where the mesh is now; says how."""
    bvh.refit(vertices)
    if bvh.report.layout_sah <= WORST * bvh.report.layout_sah_at_build:
        return "refit"
    bvh.rebuild(vertices)
    return "rebuild"


def main() -> None:
    """Print a line a frame."""
    rest, faces = cloth(CELLS)
    bvh = treelet.build(positions(rest, 0.0), faces, updatable=True)
    origins = np.random.default_rng(0).uniform([0, 0, 2], [1, 1, 2], (RAYS, 3)).astype(np.float32)
    print(f"{len(faces):,} triangles, {len(origins):,} rays a frame")
    for frame in range(1, FRAMES + 1):
        vertices = positions(rest, frame / 10)
        start = time.perf_counter()
        action = follow(bvh, vertices)
        updated = time.perf_counter()
        hits = bvh.intersect(origins, [0, 0, -1])
        traced = time.perf_counter()
        times = f"{(updated - start) * 1e3:6.1f} ms, rays {(traced - updated) * 1e3:6.1f} ms"
        height = 2 - np.mean(hits.t[hits.face >= 0])
        print(
            f"frame {frame:2}: {action:7} {times}, cost {bvh.report.layout_sah:5.1f}, cloth at {height:+.3f}"
        )


if __name__ == "__main__":
    main()
