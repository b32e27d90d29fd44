"""Nearest points, inside and outside, and overlaps, against simple computations in float64."""

from __future__ import annotations

import numpy as np
import pytest
from sample_meshes import TRIANGLE_FACES, TRIANGLE_VERTICES, random_triangles, torus

import treelet

RECIPES = ["lbvh > bvh2", "balanced", "lbvh > cwbvh", "presplit > lbvh > bvh8"]


@pytest.fixture(scope="module", params=RECIPES)
def ring(request):
    """A closed torus of radii 1 and 0.4."""
    vertices, faces = torus(48, 24)
    return treelet.build(vertices, faces, request.param)


def points_near_ring(shape, seed=1):
    return np.random.default_rng(seed).uniform(-1.6, 1.6, (*shape, 3)).astype(np.float32)


def distance_to_ring(points):
    """Of the smooth torus, negative inside."""
    x, y, z = np.moveaxis(points.astype(np.float64), -1, 0)
    return np.hypot(np.hypot(x, y) - 1, z) - 0.4


def nearest_by_sampling(corners, point, steps=60):
    """Least distance to a grid of points on each triangle, float64: never too small."""
    u, v = np.meshgrid(np.linspace(0, 1, steps), np.linspace(0, 1, steps), indexing="ij")
    u, v = u[u + v <= 1 + 1e-12], v[u + v <= 1 + 1e-12]
    weights = np.stack([1 - u - v, u, v], axis=-1)
    return np.linalg.norm(weights @ corners.astype(np.float64) - point, axis=-1).min()


def test_closest_points_lie_on_their_faces_at_their_distances(ring):
    vertices, faces = torus(48, 24)
    points = points_near_ring((7, 30))
    nearest = ring.closest_point(points)
    assert nearest.point.shape == (7, 30, 3)
    assert all(part.shape == (7, 30) for part in nearest[1:])
    corners = vertices[faces[nearest.face]].astype(np.float64)
    weights = np.stack([1 - nearest.u - nearest.v, nearest.u, nearest.v], axis=-1)
    assert np.allclose(np.einsum("...i,...ij->...j", weights, corners), nearest.point, atol=1e-6)
    assert np.allclose(np.linalg.norm(nearest.point - points, axis=-1), nearest.distance, atol=1e-6)
    assert np.allclose(np.abs(distance_to_ring(points)), nearest.distance, atol=0.02)
    assert (ring.distance(points) == nearest.distance).all()


def test_closest_point_is_no_farther_than_any_sample():
    vertices, faces = random_triangles(40, seed=2)
    bvh = treelet.build(vertices, faces)
    for point in np.random.default_rng(3).uniform(-0.5, 1.5, (30, 3)).astype(np.float32):
        sampled = nearest_by_sampling(vertices[faces], point)
        distance = float(bvh.distance(point))
        assert distance <= sampled * (1 + 1e-6)
        assert sampled <= distance + 0.02


def test_signs_are_exact_for_a_closed_mesh(ring):
    points = points_near_ring((1000,))
    smooth = distance_to_ring(points)
    clear = np.abs(smooth) > 0.02  # the mesh is made of chords
    signed, inside = ring.signed_distance(points), ring.contains(points)
    assert (inside[clear] == (smooth < 0)[clear]).all()
    assert (np.signbit(signed) == inside).all()
    assert (np.abs(signed) == ring.distance(points)).all()


def test_winding_numbers_agree_with_contains(ring):
    points = points_near_ring((500,))
    inside = ring.contains(points)
    sign = 1 if ring.winding_number([1, 0, 0], np.inf) > 0 else -1
    assert np.allclose(ring.winding_number(points, np.inf), sign * inside, atol=1e-5)
    assert np.allclose(ring.winding_number(points), sign * inside, atol=0.1)


def test_of_two_boxes_that_touch_one_contains_a_point_between():
    corners = np.array(np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij")).reshape(3, 8).T.astype(np.float32)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    faces = np.array([q[:3] for q in quads] + [[q[0], q[2], q[3]] for q in quads])
    left, right = treelet.build(corners, faces), treelet.build(corners + np.float32([1, 0, 0]), faces)
    grid = np.linspace(0, 1, 9, dtype=np.float32)[1:-1]
    between = np.array([[1, y, z] for y in grid for z in grid])
    assert (left.contains(between) ^ right.contains(between)).all()
    assert not left.contains(between).any()  # the side of larger x decides


def test_max_distance_is_one_for_all_or_one_each():
    bvh = treelet.build(TRIANGLE_VERTICES, TRIANGLE_FACES)
    points = np.array([[0.2, 0.2, 1], [0.2, 0.2, 2]], np.float32)
    assert bvh.closest_point(points, 1.5).face.tolist() == [0, -1]
    assert bvh.closest_point(points, [0.5, 2.0]).face.tolist() == [-1, 0]
    assert bvh.closest_point([0.2, 0.2, 1], [0.5, 1.0]).face.tolist() == [-1, 0]
    with pytest.raises(ValueError, match="max_distance"):
        bvh.closest_point(points, [1, 2, 3])


def test_bad_points_and_empty_meshes_have_no_nearest_point():
    bvh = treelet.build(TRIANGLE_VERTICES, TRIANGLE_FACES)
    bad = [[np.nan, 0, 0], [0, np.inf, 0]]
    nearest = bvh.closest_point(bad)
    assert np.isnan(nearest.point).all()
    assert np.isinf(nearest.distance).all()
    assert (nearest.face == -1).all()
    assert not bvh.contains(bad).any()
    assert (bvh.signed_distance(bad) == np.inf).all()
    assert np.isnan(bvh.winding_number(bad)).all()
    empty = treelet.build(np.empty((0, 3)), np.empty((0, 3), int))
    assert empty.closest_point([0, 0, 0]).face == -1
    assert empty.winding_number([0, 0, 0]) == 0
    assert not empty.contains([0, 0, 0])
    assert empty.signed_distance([0, 0, 0]) == np.inf
    assert empty.overlap_spheres([0, 0, 0], 9).face.size == 0
    assert bvh.distance(np.empty((0, 3))).shape == (0,)


def test_overlaps_are_rows_of_ascending_faces(ring):
    vertices, faces = torus(48, 24)
    lower = points_near_ring((20, 5))
    upper = lower + np.float32(0.4)
    rows = ring.overlap_boxes(lower, upper)
    assert rows.offsets.shape == (101,)
    low, high = vertices[faces].min(axis=1), vertices[faces].max(axis=1)
    has_vertex_inside = (
        ((vertices[faces] >= lower.reshape(-1, 1, 1, 3)) & (vertices[faces] <= upper.reshape(-1, 1, 1, 3)))
        .all(axis=-1)
        .any(axis=-1)
    )
    for i, (a, b) in enumerate(zip(lower.reshape(-1, 3), upper.reshape(-1, 3), strict=True)):
        found = rows.face[rows.offsets[i] : rows.offsets[i + 1]]
        assert (np.diff(found) > 0).all()
        assert set(np.flatnonzero(has_vertex_inside[i])) <= set(found)
        assert set(found) <= set(np.flatnonzero((low <= b).all(axis=1) & (high >= a).all(axis=1)))


def test_spheres_meet_the_faces_within_their_radius(ring):
    centers = points_near_ring((50,))
    rows = ring.overlap_spheres(centers, ring.distance(centers))
    assert (np.diff(rows.offsets) >= 1).all()
    assert ring.closest_point(centers).face.tolist() == [rows.face[begin] for begin in rows.offsets[:-1]]
    assert ring.overlap_spheres(centers, -1.0).face.size == 0


@pytest.mark.parametrize(
    "query", ["distance", "contains", "signed_distance", "winding_number", "closest_point"]
)
def test_points_must_have_three_coordinates(query):
    bvh = treelet.build(TRIANGLE_VERTICES, TRIANGLE_FACES)
    with pytest.raises(ValueError, match="points must have shape"):
        getattr(bvh, query)([[1, 2]])
    with pytest.raises(TypeError, match="points must hold real numbers"):
        getattr(bvh, query)(["abc"])


def test_accuracy_must_not_be_negative():
    bvh = treelet.build(TRIANGLE_VERTICES, TRIANGLE_FACES)
    for accuracy in (-1.0, 0.5, np.nan):
        with pytest.raises(ValueError, match="accuracy"):
            bvh.winding_number([0, 0, 0], accuracy)
