"""Differences of coordinates near the largest float overflow: rays may cost more there, but they end."""

import subprocess
import sys

import pytest

CODE = """
import numpy as np, treelet
rng = np.random.default_rng(1)
vertices = (rng.uniform(-3e38, 3e38, ({count}, 3, 3))).astype(np.float32).reshape(-1, 3)
faces = np.arange(len(vertices)).reshape(-1, 3)
origins = rng.uniform(-3e38, 3e38, (200, 3))
centres = vertices[faces].mean(axis=1, dtype=np.float64)
rays = origins, centres[rng.integers({count}, size=200)] / 2 - origins / 2
hits = treelet.build(vertices, faces).intersect(*rays)
expected = treelet.intersect_brute_force(vertices, faces, *rays)
assert all(ours.tobytes() == others.tobytes() for ours, others in zip(hits, expected, strict=True))
assert (hits.face >= 0).all()
"""


@pytest.mark.parametrize("count", [1, 2, 20])
def test_rays_end(count):
    """In a process of its own, for a ray that does not end could not be stopped."""
    subprocess.run([sys.executable, "-c", CODE.format(count=count)], check=True, timeout=30)
