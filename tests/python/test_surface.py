"""Corners and normals of faces, and rays that leave them."""

from __future__ import annotations

import numpy as np
import pytest
from sample_meshes import TRIANGLE_FACES, TRIANGLE_VERTICES, grid, torus

import treelet

SEED = 11


@pytest.fixture(scope="module", params=["balanced", "lbvh > bvh2", "lbvh > cwbvh", "best"])
def recipe(request):
    return request.param


def test_corners_are_those_of_the_mesh(recipe):
    vertices, faces = torus(30, 20)
    bvh = treelet.build(vertices, faces, recipe)
    face = np.arange(len(faces)).reshape(20, -1)
    np.testing.assert_array_equal(bvh.triangles(face), vertices[faces[face]])
    assert np.isnan(bvh.triangles(-1)).all()
    assert bvh.triangles(3).shape == (3, 3)


def test_normals_are_those_of_the_corners(recipe):
    vertices, faces = torus(30, 20)
    bvh = treelet.build(vertices, faces, recipe)
    a, b, c = (vertices[faces[:, corner]].astype(np.float64) for corner in range(3))
    expected = np.cross(b - a, c - a)
    expected /= np.linalg.norm(expected, axis=-1, keepdims=True)
    normals = bvh.normals(np.arange(len(faces)))
    assert normals.dtype == np.float32
    np.testing.assert_allclose(normals, expected, atol=1e-7)
    assert np.isnan(bvh.normals([-1])).all()


def test_normals_turn_against_rays():
    bvh = treelet.build(*torus(30, 20))
    rng = np.random.default_rng(SEED)
    origins, directions = rng.uniform(-2, 2, (2, 40, 50, 3))
    hits = bvh.intersect(origins, directions)
    normals = bvh.normals(hits.face, facing=directions)
    is_hit = hits.face >= 0
    assert (np.sum(normals * directions, axis=-1)[is_hit] <= 1e-6).all()
    assert np.isnan(normals[~is_hit]).all()
    plain = bvh.normals(hits.face)
    turned = (normals != plain).any(axis=-1) & is_hit
    np.testing.assert_array_equal(normals[turned], -plain[turned])
    np.testing.assert_array_equal(turned & is_hit, bvh.occluded(origins, directions) & turned)
    assert bvh.normals(0, facing=directions).shape == (40, 50, 3)


def test_faces_follow_updates():
    bvh = treelet.build(TRIANGLE_VERTICES, TRIANGLE_FACES, updatable=True)
    np.testing.assert_array_equal(bvh.normals(0), [0, 0, 1])
    moved = TRIANGLE_VERTICES[:, [2, 0, 1]]
    bvh.refit(moved)
    np.testing.assert_array_equal(bvh.triangles(0), moved)
    bvh.rebuild(moved[::-1])
    np.testing.assert_array_equal(bvh.normals(0), [-1, 0, 0])


def test_faces_that_are_not_there_are_refused():
    bvh = treelet.build(TRIANGLE_VERTICES, TRIANGLE_FACES)
    with pytest.raises(ValueError, match="there is no face 1: the mesh has 1"):
        bvh.normals([0, 1])
    with pytest.raises(ValueError, match="there is no face -2"):
        bvh.triangles(-2)
    with pytest.raises(TypeError, match="face must hold integers, not float64"):
        bvh.normals(0.0)
    with pytest.raises(ValueError, match="cannot be broadcast"):
        bvh.normals([0, 0], facing=np.ones((3, 3)))
    with pytest.raises(TypeError, match="hits must be an answer with face, u and v"):
        bvh.spawn(np.zeros(3), np.ones((1, 3)))


def test_faces_that_were_left_out_have_no_normal():
    vertices = np.vstack([TRIANGLE_VERTICES, [[np.nan, 0, 0]]]).astype(np.float32)
    bvh = treelet.build(vertices, [[0, 1, 2], [0, 1, 3]])
    assert np.isnan(bvh.normals([0, 1])).all(axis=-1).tolist() == [False, True]


SCENES = {
    "near": (1.0, 0.0),
    "tiny": (1e-30, 0.0),
    "huge": (1e25, 0.0),
    "far": (1.0, 3e4),
}


@pytest.mark.parametrize("scene", SCENES)
def test_no_ray_meets_the_face_that_it_leaves(scene):
    scale, shift = SCENES[scene]
    vertices, faces = torus(60, 40)
    vertices = ((vertices + shift) * scale).astype(np.float32)
    bvh = treelet.build(vertices, faces)
    rng = np.random.default_rng(SEED)
    eye = vertices.mean(axis=0)
    hits = bvh.intersect(eye, rng.normal(size=(200_000, 3)))
    corners = bvh.triangles(hits.face)
    grazing = (corners[:, 1] - corners[:, 0]) / scale + rng.normal(size=(200_000, 3)) * 1e-6
    for directions in (rng.normal(size=(200_000, 3)), grazing):
        again = bvh.intersect(bvh.spawn(hits, directions), directions)
        is_hit = hits.face >= 0
        assert is_hit.sum() > 10_000, f"seed {SEED}"
        assert not (again.face == hits.face)[is_hit].any(), f"seed {SEED}"


def test_rays_far_from_the_origin_leave_their_faces():
    vertices, faces = torus(60, 40)
    bvh = treelet.build(vertices + np.array([4_321_000.1, 512_000.7, 300]), faces)
    assert np.any(bvh.offset)
    directions = np.random.default_rng(SEED).normal(size=(100_000, 3))
    hits = bvh.intersect([4_321_000.1, 512_000.7, 300], directions)
    origins = bvh.spawn(hits, directions)
    assert origins.dtype == np.float64
    is_hit = hits.face >= 0
    assert not (bvh.intersect(origins, directions).face == hits.face)[is_hit].any()


def test_rays_of_nearest_points_leave_them():
    bvh = treelet.build(*torus(60, 40))
    rng = np.random.default_rng(SEED)
    near = bvh.closest_point(rng.uniform(-2, 2, (50_000, 3)))
    directions = rng.normal(size=(4, 50_000, 3))
    origins = bvh.spawn(near, directions)
    assert origins.shape == (4, 50_000, 3)
    assert not (bvh.intersect(origins, directions).face == near.face).any()


def test_thin_gaps_stay_open():
    """A second sheet a fortieth of a millimetre above the first, in a room of 10 m."""
    vertices, faces = grid(8)
    vertices = vertices * np.float32(10)
    gap = np.float32(2.5e-5)
    raised = vertices + np.float32([0, 0, gap])
    bvh = treelet.build(np.vstack([vertices, raised]), np.vstack([faces, faces + len(vertices)]))
    rng = np.random.default_rng(SEED)
    hits = bvh.intersect(np.append(rng.uniform(1, 9, (1000, 2)), -np.ones((1000, 1)), axis=1), [0, 0, 1])
    assert (hits.face < 128).all()
    up = rng.normal(size=(1000, 3)) * [1e-6, 1e-6, 0] + [0, 0, 1]
    origins = bvh.spawn(hits, up)
    assert (origins[:, 2] > 0).all()
    above = bvh.intersect(origins, up)
    assert (above.face >= 128).all()
    light = np.append(origins[:, :2], np.full((1000, 1), gap * 0.9), axis=1)
    assert not bvh.occluded(origins, light - origins, t_max=1).any()
    assert bvh.occluded(origins, light + np.array([0, 0, 1]) - origins, t_max=1).all()


def test_misses_spawn_rays_that_miss():
    bvh = treelet.build(TRIANGLE_VERTICES, TRIANGLE_FACES)
    hits = bvh.intersect([[5, 5, 5], [0.2, 0.2, 1]], [0, 0, -1])
    origins = bvh.spawn(hits, [0, 0, 1])
    assert np.isnan(origins[0]).all()
    assert np.isfinite(origins[1]).all()
    assert origins[1, 2] > 0
    assert bvh.spawn(hits, [0, 0, -1])[1, 2] < 0
