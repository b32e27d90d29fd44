"""What precision="float64" costs: user time of one thread for the same random rays, medians of three.

python bench/float64.py [SCENE] [TRIANGLES]
"""

import sys
import time

import numpy as np

import treelet
from treelet import scenes

RAYS = 200_000


def seconds(query, *rays):
    """User time of one call."""
    start = time.process_time()
    query(*rays)
    return time.process_time() - start


def main(scene="city", triangles="200000"):
    """Time each query on both trees, alternating."""
    treelet.set_thread_count(1)
    mesh = scenes.make(scene, int(triangles))
    trees = [treelet.build(mesh.vertices, mesh.faces, precision=p) for p in ("float32", "float64")]
    rng = np.random.default_rng(0)
    low, high = trees[0].bounds
    origins = np.float32(low + (high - low) * rng.random((RAYS, 3)))
    directions = np.float32(rng.standard_normal((RAYS, 3)))
    for name in ("intersect", "occluded", "count_hits", "intersect_all"):
        samples = [[seconds(getattr(tree, name), origins, directions) for tree in trees] for _ in range(3)]
        single, double = np.median(samples, axis=0) / RAYS * 1e6
        print(f"{name}: float32 {single:.2f} us, float64 {double:.2f} us a ray, {double / single:.1f} times")


if __name__ == "__main__":
    main(*sys.argv[1:])
