"""Agreement with an independent tracer on a million rays; differences are judged exactly."""

import numpy as np
import pytest
from embree_agreement import compare, trace_with_embree
from sample_rays import mixed_rays

import treelet
from treelet import scenes

RAYS = 1_000_000 // len(scenes.names())


@pytest.mark.parametrize("name", scenes.names())
def test_every_difference_is_embrees(name, record_property):
    pytest.importorskip("embreex")
    mesh = scenes.make(name, 100_000)
    rays = mixed_rays(mesh, RAYS, seed=11)
    hits = treelet.build(mesh.vertices, mesh.faces).intersect(*rays)
    agreement = compare(mesh, rays, hits, trace_with_embree(mesh, rays))
    for kind, count in agreement.summary(RAYS).items():
        record_property(kind, count)
    assert agreement.faults == []
    assert (hits.face >= 0).mean() > 0.5
    assert 0 < agreement.counts.total() < 0.02 * RAYS


def test_wrong_hits_would_be_found():
    """The comparison itself: against right faces, every way of being wrong is a fault."""
    mesh = scenes.make("terrain", 5000)
    rays = mixed_rays(mesh, 1000, seed=2)
    right = treelet.build(mesh.vertices, mesh.faces).intersect(*rays)
    assert compare(mesh, rays, right, right.face).faults == []
    hit = right.face >= 0
    neighbour = np.where(hit, (right.face + 1) % len(mesh.faces), -1)
    wrong_ways = {
        "missed face": right._replace(face=np.full_like(right.face, -1)),
        "does not meet face": right._replace(face=neighbour),
    }
    for words, wrong in wrong_ways.items():
        faults = compare(mesh, rays, wrong, right.face).faults
        assert sum(words in fault for fault in faults) > 0.9 * hit.sum()
    farther = right._replace(t=right.t * np.float32(1 + 2**-20))
    assert any("t is" in fault for fault in compare(mesh, rays, farther, right.face).faults)
