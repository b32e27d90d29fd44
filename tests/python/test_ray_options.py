"""Masks of rays and faces, and culling: what is hidden is as if it were not there."""

from __future__ import annotations

import numpy as np
import pytest
from sample_meshes import TRIANGLE_FACES, TRIANGLE_VERTICES, grid, torus

import treelet

DOWN = np.array([0, 0, -1], np.float32)


@pytest.fixture(scope="module")
def panes():
    """Four unit squares at z = 0 to 3, of two triangles each; the odd ones turned over."""
    vertices, faces = grid(1)
    sheets = [vertices + np.float32([0, 0, z]) for z in range(4)]
    turned = [(faces if z % 2 == 0 else faces[:, ::-1]) + 4 * z for z in range(4)]
    return treelet.build(np.concatenate(sheets), np.concatenate(turned))


@pytest.fixture(scope="module")
def ring():
    """A closed mesh whose normals point outwards."""
    return treelet.build(*torus(60, 40))


@pytest.fixture(scope="module")
def rays():
    rng = np.random.default_rng(5)
    origins = rng.uniform(-2, 2, (64, 48, 3))
    return origins, rng.uniform(-1, 1, (64, 48, 3)) - origins


def test_culling_passes_through_one_side(panes):
    origin = [0.3, 0.6, 9]
    assert panes.intersect(origin, DOWN).t == 6  # the pane at z = 3
    front = set(panes.intersect_all(origin, DOWN, cull="back").t.tolist())
    back = set(panes.intersect_all(origin, DOWN, cull="front").t.tolist())
    assert {frozenset(front), frozenset(back)} == {frozenset({6.0, 8.0}), frozenset({7.0, 9.0})}
    assert panes.intersect(origin, DOWN, cull="back").t == min(front)
    assert panes.intersect(origin, DOWN, cull="front").t == min(back)


def test_front_is_counter_clockwise():
    bvh = treelet.build(TRIANGLE_VERTICES, TRIANGLE_FACES)
    above, below = [0.2, 0.2, 1], [0.2, 0.2, -1]
    assert bvh.occluded(above, DOWN, cull="back")
    assert not bvh.occluded(above, DOWN, cull="front")
    assert not bvh.occluded(below, -DOWN, cull="back")
    assert bvh.occluded(below, -DOWN, cull="front")


def test_both_sides_of_a_closed_mesh_are_hit_equally_often(ring, rays):
    outside = ~ring.contains(rays[0])
    enters, leaves = ring.count_hits(*rays, cull="back"), ring.count_hits(*rays, cull="front")
    np.testing.assert_array_equal((leaves - enters)[outside], 0)
    np.testing.assert_array_equal((leaves - enters)[~outside], 1)
    np.testing.assert_array_equal(enters + leaves, ring.count_hits(*rays))


@pytest.mark.parametrize("recipe", ["balanced", "lbvh > bvh2", "lbvh > cwbvh", "best"])
def test_hidden_faces_are_as_if_not_there(rays, recipe):
    vertices, faces = torus(40, 30)
    shown = np.random.default_rng(6).random(len(faces)) < 0.5
    bvh = treelet.build(vertices, faces, recipe)
    rest = treelet.build(vertices, faces[shown], recipe)
    numbers = np.flatnonzero(shown)
    hits, expected = bvh.intersect(*rays, face_mask=shown), rest.intersect(*rays)
    np.testing.assert_array_equal(hits.t, expected.t)
    np.testing.assert_array_equal(hits.face, np.where(expected.face < 0, -1, numbers[expected.face]))
    np.testing.assert_array_equal(bvh.occluded(*rays, face_mask=shown), rest.occluded(*rays))
    np.testing.assert_array_equal(bvh.count_hits(*rays, face_mask=shown), rest.count_hits(*rays))
    every, left = bvh.intersect_all(*rays, face_mask=shown), rest.intersect_all(*rays)
    np.testing.assert_array_equal(every.offsets, left.offsets)
    np.testing.assert_array_equal(every.face, numbers[left.face])


@pytest.mark.parametrize("reorder", [False, True])
def test_rays_that_are_not_active_miss(ring, rays, reorder):
    active = np.random.default_rng(7).random(rays[0].shape[:-1]) < 0.3
    hits, every = ring.intersect(*rays, active=active, reorder=reorder), ring.intersect(*rays)
    for part, whole, miss in zip(hits, every, (np.inf, -1, 0, 0), strict=True):
        np.testing.assert_array_equal(part, np.where(active, whole, miss))
    np.testing.assert_array_equal(ring.occluded(*rays, active=active), ring.occluded(*rays) & active)
    counts = np.where(active, ring.count_hits(*rays), 0)
    np.testing.assert_array_equal(ring.count_hits(*rays, active=active), counts)
    listed = ring.intersect_all(*rays, active=active, reorder=reorder)
    np.testing.assert_array_equal(np.diff(listed.offsets), counts.ravel())
    work = ring.traversal_cost(*rays, active=active)
    assert not work.nodes[~active].any()


def test_a_mask_is_broadcast_to_the_rays(ring, rays):
    row = np.arange(48) % 2 == 0
    np.testing.assert_array_equal(
        ring.intersect(*rays, active=row).t, ring.intersect(*rays, active=np.tile(row, (64, 1))).t
    )
    assert not ring.occluded(*rays, active=False).any()
    np.testing.assert_array_equal(ring.occluded(*rays, active=True), ring.occluded(*rays))


@pytest.mark.parametrize("max_hits", [1, 100, 10**6])
def test_chunks_have_the_options_of_their_call(ring, rays, max_hits):
    rng = np.random.default_rng(8)
    options = {
        "active": rng.random(rays[0].shape[:-1]) < 0.5,
        "face_mask": rng.random(ring.face_count) < 0.7,
        "cull": "back",
    }
    whole = ring.intersect_all(*rays, **options)
    chunks = list(ring.stream_hits(*rays, max_hits=max_hits, **options))
    np.testing.assert_array_equal(np.concatenate([chunk.hits.t for chunk in chunks]), whole.t)
    assert sum(len(chunk.hits.offsets) - 1 for chunk in chunks) == len(whole.offsets) - 1


def test_bad_options_say_what_is_wrong(ring, rays):
    with pytest.raises(ValueError, match='cull must be "none", "back" or "front"'):
        ring.intersect(*rays, cull="backface")
    with pytest.raises(ValueError, match="cull must be"):
        ring.stream_hits(*rays, cull=True)
    with pytest.raises(TypeError, match="active must hold booleans, not int64"):
        ring.occluded(*rays, active=np.ones((64, 48), np.int64))
    with pytest.raises(ValueError, match=r"active \(48, 64\) does not fit rays of the shape \(64, 48\)"):
        ring.count_hits(*rays, active=np.ones((48, 64), bool))
    with pytest.raises(ValueError, match=r"face_mask must have shape \(4800,\), one a face, not \(3,\)"):
        ring.intersect_all(*rays, face_mask=[True, False, True])
    with pytest.raises(TypeError, match="face_mask must hold booleans"):
        ring.intersect(*rays, face_mask=np.arange(4800))


@pytest.mark.parametrize(
    ("option", "advice"),
    [
        ({"active": [True]}, "active is not there on CUDA devices yet: give the rays that are off a t_max"),
        ({"face_mask": [True]}, r"face_mask is not .* a copy of the tree on the host, bvh.to\('cpu'\)"),
        ({"cull": "back"}, "cull is not there on CUDA devices yet"),
        ({"out": ()}, "out is not there on CUDA devices yet: copy the answer"),
    ],
)
@pytest.mark.parametrize("query", [treelet.DeviceBvh.intersect, treelet.DeviceBvh.occluded])
def test_trees_on_devices_say_what_to_do_instead(query, option, advice):
    with pytest.raises(NotImplementedError, match=advice):
        query(None, [0, 0, 1], DOWN, **option)


def test_a_limit_below_zero_does_on_devices_what_active_does(ring, rays):
    active = np.random.default_rng(9).random(rays[0].shape[:-1]) < 0.5
    off = ring.intersect(*rays, 0, np.where(active, np.inf, -np.inf))
    np.testing.assert_array_equal(off.face, ring.intersect(*rays, active=active).face)
