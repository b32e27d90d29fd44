"""Every recipe gives, on every scene, what testing all triangles gives, bit for bit."""

from functools import cache

import numpy as np
import pytest
from sample_rays import mixed_rays

import treelet
from treelet import scenes

RECIPES = [
    "fast",
    "balanced",
    "best",
    "sweep",
    *(f"lbvh > treelet(size={size}, rounds=2)" for size in (4, 5, 6, 8)),
    "sweep > treelet > bvh2(leaf=4)",
    "lbvh > treelet > bvh2(leaf=1)",
    "lbvh > bvh2(leaf=64)",
    "lbvh > bvh8(leaf=1)",
    "sweep > treelet > bvh8(leaf=16)",
    "presplit(budget=100) > lbvh > treelet > bvh8",
    "presplit > sweep > bvh2",
    "presplit > sbvh > reinsert > bvh2",
    "hploc > reinsert(percent=10, rounds=3) > cwbvh",
]
RAYS = 600
TRIANGLES = dict(zip(scenes.names(), (1000, 1500, 2000, 2500, 3000, 3500, 4000, 5000), strict=True))
INTERVALS = [(0, np.inf), (0.3, 1.0), (-np.inf, np.inf)]


@cache
def mesh_of(scene):
    return scenes.make(scene, TRIANGLES[scene], seed=3)


@cache
def rays_of(scene):
    return mixed_rays(mesh_of(scene), RAYS, seed=17, aimed_share=0.5)


@cache
def brute_force(scene, t_min, t_max):
    mesh = mesh_of(scene)
    return treelet.intersect_brute_force(mesh.vertices, mesh.faces, *rays_of(scene), t_min, t_max)


@pytest.mark.parametrize("recipe", RECIPES)
@pytest.mark.parametrize("scene", scenes.names())
def test_hits_are_those_of_brute_force(scene, recipe):
    mesh, rays = mesh_of(scene), rays_of(scene)
    bvh = treelet.build(mesh.vertices, mesh.faces, recipe, validate=True)
    assert bvh.validate(mesh.vertices, mesh.faces) == []
    for t_min, t_max in INTERVALS:
        expected = brute_force(scene, t_min, t_max)
        for ours, others in zip(bvh.intersect(*rays, t_min, t_max), expected, strict=True):
            assert ours.tobytes() == others.tobytes()
        np.testing.assert_array_equal(bvh.occluded(*rays, t_min, t_max), expected.face >= 0)


@pytest.mark.parametrize("scene", scenes.names())
def test_enough_rays_hit_to_prove_anything(scene):
    for t_min, t_max in INTERVALS:
        assert (brute_force(scene, t_min, t_max).face >= 0).mean() > 0.15


@pytest.mark.parametrize("scene", scenes.names())
def test_treelets_make_no_tree_worse(scene):
    mesh = mesh_of(scene)

    def sah(recipe):
        return treelet.build(mesh.vertices, mesh.faces, recipe).report.sah

    assert sah("balanced") < sah("fast")
    for size in (4, 5, 6, 8):
        assert sah(f"lbvh > treelet(size={size})") < sah("fast")
    assert sah("sweep > treelet") <= sah("sweep") * (1 + 1e-6)
