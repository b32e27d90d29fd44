"""The drop-in for Open3D's RaycastingScene: by known answers, and beside Open3D where that is installed."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from sample_meshes import TRIANGLE_FACES, TRIANGLE_VERTICES, random_triangles, split_quads, torus

import treelet
from treelet.compat.open3d import RaycastingScene

INVALID = 2**32 - 1
DOWN = [0.25, 0.5, 1, 0, 0, -2]  # half of its length above the triangle
AWAY = [9, 9, 9, 1, 0, 0]

CUBE_VERTICES = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], np.float32)
CUBE_FACES = split_quads(
    np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
)


class Tensor:
    """Has its values where tensors of other libraries have them, and is no array."""

    def __init__(self, values):
        self.values = values

    def numpy(self):
        return self.values


def two_triangles():
    """The sample triangle as geometry 0, a mesh without faces, the triangle 2 and 1 lower as geometry 2."""
    scene = RaycastingScene()
    assert scene.add_triangles(TRIANGLE_VERTICES, TRIANGLE_FACES) == 0
    assert scene.add_triangles(TRIANGLE_VERTICES, np.empty((0, 3), np.uint32)) == 1
    lower = np.concatenate([TRIANGLE_VERTICES - [0, 0, 2], TRIANGLE_VERTICES - [0, 0, 1]])
    assert scene.add_triangles(lower, np.array([[0, 1, 2], [3, 4, 5]])) == 2
    return scene


def cube():
    scene = RaycastingScene()
    scene.add_triangles(CUBE_VERTICES, CUBE_FACES)
    return scene


def test_cast_rays_names_geometry_and_primitive():
    rays = np.array([DOWN, AWAY, [0.25, 0.5, -0.5, 0, 0, -1], [0.25, 0.5, -3, 0, 0, 1]], np.float32)
    hits = two_triangles().cast_rays(rays)
    assert hits["t_hit"].tolist() == [0.5, np.inf, 0.5, 1]
    assert hits["geometry_ids"].tolist() == [0, INVALID, 2, 2]
    assert hits["primitive_ids"].tolist() == [0, INVALID, 1, 0]
    assert hits["primitive_uvs"].tolist() == [[0.25, 0.5], [0, 0], [0.25, 0.5], [0.25, 0.5]]
    assert hits["primitive_normals"].tolist() == [[0, 0, 1], [0, 0, 0], [0, 0, 1], [0, 0, 1]]
    types = {name: array.dtype for name, array in hits.items()}
    assert types["geometry_ids"] == types["primitive_ids"] == np.uint32
    assert types["t_hit"] == types["primitive_uvs"] == types["primitive_normals"] == np.float32
    assert RaycastingScene.INVALID_ID == INVALID


def test_uvs_give_the_hit_points_and_normals_are_those_of_the_faces():
    vertices, faces = torus(24, 12)
    vertices = vertices * [1, 2, 3]
    scene = RaycastingScene()
    scene.add_triangles(vertices, faces)
    rng = np.random.default_rng(4)
    origins = rng.uniform(-4, 4, (500, 3)).astype(np.float32)
    rays = np.concatenate([origins, rng.uniform(-1, 1, (500, 3)).astype(np.float32) - origins], axis=-1)
    hits = scene.cast_rays(rays)
    struck = np.isfinite(hits["t_hit"])
    assert struck.sum() > 100
    corners = vertices[faces[hits["primitive_ids"][struck]]]
    u, v = hits["primitive_uvs"][struck].T[..., None]
    points = (1 - u - v) * corners[:, 0] + u * corners[:, 1] + v * corners[:, 2]
    along = origins[struck] + hits["t_hit"][struck, None] * rays[struck, 3:]
    assert np.allclose(points, along, atol=1e-4)
    normals = hits["primitive_normals"][struck]
    assert np.allclose(np.linalg.norm(normals, axis=-1), 1)
    edges = corners[:, 1:] - corners[:, :1]
    assert np.allclose(np.einsum("nij,nj->ni", edges, normals), 0, atol=1e-6)
    assert (np.einsum("ni,ni->n", np.cross(edges[:, 0], edges[:, 1]), normals) > 0).all()


def test_occlusions_end_at_their_limits():
    scene = two_triangles()
    rays = np.array([DOWN, AWAY], np.float32)
    assert scene.test_occlusions(rays).tolist() == [True, False]
    assert scene.test_occlusions(rays, tfar=0.4).tolist() == [False, False]
    assert scene.test_occlusions(rays, tnear=1.6).tolist() == [False, False]
    assert scene.test_occlusions(rays, 0.6, 1.1).tolist() == [True, False]


def test_lists_and_counts_all_intersections():
    scene = two_triangles()
    rays = np.array([[AWAY, DOWN], [[0.25, 0.5, -1.5, 0, 0, 1], AWAY]], np.float32)
    hits = scene.list_intersections(rays)
    assert hits["ray_splits"].tolist() == [0, 0, 3, 5, 5]
    assert hits["ray_ids"].tolist() == [1, 1, 1, 2, 2]
    assert hits["t_hit"].tolist() == [0.5, 1, 1.5, 0.5, 1.5]
    assert hits["geometry_ids"].tolist() == [0, 2, 2, 2, 0]
    assert hits["primitive_ids"].tolist() == [0, 1, 0, 1, 0]
    assert hits["primitive_uvs"].tolist() == [[0.25, 0.5]] * 5
    names = ("ray_splits", "ray_ids", "geometry_ids", "primitive_ids")
    assert all(hits[name].dtype == np.uint32 for name in names)
    counts = scene.count_intersections(rays)
    assert counts.dtype == np.int32
    assert counts.tolist() == [[0, 3], [2, 0]]


def test_counts_crossings_through_edges_and_corners_once():
    rays = np.array([[0.5, 0.5, -1, 0, 0, 1], [-1, -1, -1, 1, 1, 1], [0.5, 0.5, 0.5, 1, 1, 0]], np.float32)
    assert cube().count_intersections(rays).tolist() == [2, 2, 1]


def test_closest_points():
    nearest = two_triangles().compute_closest_points([[0.25, 0.5, 1], [-1, 0, -1.1], [np.nan, 0, 0]])
    assert np.array_equal(nearest["points"], [[0.25, 0.5, 0], [0, 0, -1], [np.nan] * 3], equal_nan=True)
    assert nearest["points"].dtype == np.float32
    assert nearest["geometry_ids"].tolist() == [0, 2, INVALID]
    assert nearest["primitive_ids"].tolist() == [0, 1, INVALID]
    assert nearest["primitive_uvs"].tolist() == [[0.25, 0.5], [0, 0], [0, 0]]
    assert nearest["primitive_normals"].tolist() == [[0, 0, 1], [0, 0, 1], [0, 0, 0]]


@pytest.mark.parametrize("samples", [1, 3])
def test_distances_and_sides(samples):
    points = np.array([[0.5, 0.5, 0.5], [-0.5, -0.5, -0.5], [0.5, 0.5, 0.75]], np.float32)
    distances = cube().compute_distance(points)
    assert np.allclose(distances, [0.5, np.sqrt(0.75), 0.25])
    assert np.array_equal(cube().compute_signed_distance(points, nsamples=samples), distances * [-1, 1, -1])
    occupancy = cube().compute_occupancy(points, nsamples=samples)
    assert occupancy.tolist() == [1, 0, 1]
    assert distances.dtype == occupancy.dtype == np.float32


@pytest.mark.parametrize("shape", [(), (0,), (11,), (1, 2, 3), (4, 0)])
def test_answers_have_the_leading_shape(shape):
    scene, count = two_triangles(), int(np.prod(shape))
    rays, points = np.full((*shape, 6), 0.25, np.float32), np.full((*shape, 3), 0.25, np.float32)
    last = {"primitive_uvs": (2,), "primitive_normals": (3,), "points": (3,)}
    for answer in (scene.cast_rays(rays), scene.compute_closest_points(points)):
        assert all(array.shape == (*shape, *last.get(name, ())) for name, array in answer.items())
    for query in (scene.test_occlusions, scene.count_intersections):
        assert query(rays).shape == shape
    for query in (scene.compute_distance, scene.compute_signed_distance, scene.compute_occupancy):
        assert query(points).shape == shape
    hits = scene.list_intersections(rays)
    assert hits["ray_splits"].shape == (count + 1,)
    assert len(hits["t_hit"]) == scene.count_intersections(rays).sum()


@pytest.mark.parametrize("has_empty_mesh", [False, True])
def test_a_scene_without_triangles_misses(has_empty_mesh):
    scene = RaycastingScene()
    if has_empty_mesh:
        scene.add_triangles(np.empty((0, 3)), np.empty((0, 3), np.int64))
    hits = scene.cast_rays([DOWN])
    assert (hits["t_hit"][0], hits["geometry_ids"][0], hits["primitive_ids"][0]) == (np.inf, INVALID, INVALID)
    assert scene.list_intersections([DOWN])["ray_splits"].tolist() == [0, 0]
    nearest = scene.compute_closest_points([[0, 0, 0]])
    assert nearest["geometry_ids"].tolist() == [INVALID]
    assert np.isnan(nearest["points"]).all()
    assert scene.compute_signed_distance([[0, 0, 0]]).tolist() == [np.inf]


def test_meshes_are_copied_and_may_come_after_queries():
    scene, vertices, faces = RaycastingScene(), TRIANGLE_VERTICES.copy(), TRIANGLE_FACES.copy()
    scene.add_triangles(vertices, faces)
    vertices += 5
    faces[:] = 0
    assert scene.cast_rays([DOWN])["t_hit"].tolist() == [0.5]
    assert scene.add_triangles(TRIANGLE_VERTICES + np.array([0, 0, 0.5]), TRIANGLE_FACES) == 1
    hits = scene.cast_rays([DOWN])
    assert (hits["t_hit"].tolist(), hits["geometry_ids"].tolist()) == ([0.25], [1])
    assert scene.count_intersections([DOWN]).tolist() == [2]


def test_takes_meshes_and_tensors():
    vertices, faces = Tensor(TRIANGLE_VERTICES), Tensor(TRIANGLE_FACES)
    whole = SimpleNamespace(
        vertex=SimpleNamespace(positions=vertices), triangle=SimpleNamespace(indices=faces)
    )
    legacy = SimpleNamespace(vertices=TRIANGLE_VERTICES.tolist(), triangles=TRIANGLE_FACES.tolist())
    like_trimesh = SimpleNamespace(
        vertices=TRIANGLE_VERTICES, faces=TRIANGLE_FACES, triangles=TRIANGLE_VERTICES[TRIANGLE_FACES]
    )
    scene = RaycastingScene(nthreads=2, device="CPU:0")
    assert scene.add_triangles(whole) == 0
    assert scene.add_triangles(mesh=legacy) == 1
    assert scene.add_triangles(treelet.Mesh(TRIANGLE_VERTICES, TRIANGLE_FACES)) == 2
    assert scene.add_triangles(vertex_positions=vertices, triangle_indices=faces) == 3
    assert scene.add_triangles(like_trimesh) == 4
    rays = Tensor(np.array([DOWN], np.float32))
    assert scene.list_intersections(rays, nthreads=1)["geometry_ids"].tolist() == [0, 1, 2, 3, 4]


def test_large_coordinates_keep_float64():
    corner = np.array([4e8, 5e8, 100.0])  # between float32 numbers here lie 32
    scene = RaycastingScene()
    scene.add_triangles(TRIANGLE_VERTICES + corner, TRIANGLE_FACES)
    ray = np.concatenate([corner + DOWN[:3], DOWN[3:]])
    assert scene.cast_rays([ray])["t_hit"].tolist() == [0.5]
    nearest = scene.compute_closest_points([corner + np.array([0.25, 0.5, 1])])
    assert nearest["points"].tolist() == [(corner + np.array([0.25, 0.5, 0])).tolist()]


def test_float32_stays_float32_far_from_the_origin():
    scene = RaycastingScene()
    scene.add_triangles(TRIANGLE_VERTICES + np.float32(2**20), TRIANGLE_FACES)
    assert scene.compute_closest_points([[0, 0, 0]])["points"].dtype == np.float32


def test_a_face_without_area_has_no_normal():
    scene = RaycastingScene()
    scene.add_triangles(np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]], np.float32), TRIANGLE_FACES)
    assert scene.compute_closest_points([[0.75, 1, 0]])["primitive_normals"].tolist() == [[0, 0, 0]]


def both_scenes(open3d, meshes):
    scenes = RaycastingScene(), open3d.t.geometry.RaycastingScene()
    for vertices, faces in meshes:
        ids = {scene.add_triangles(vertices, faces.astype(np.uint32)) for scene in scenes}
        assert len(ids) == 1
    return scenes


def test_answers_as_open3d():
    open3d = pytest.importorskip("open3d")
    mine, theirs = both_scenes(open3d, [torus(48, 24), random_triangles(500, seed=6)])
    rng = np.random.default_rng(7)
    rays = rng.normal(size=(20, 500, 6)).astype(np.float32)
    points = rng.uniform(-2, 2, (20, 50, 3)).astype(np.float32)
    for query, given in (("cast_rays", rays), ("compute_closest_points", points)):
        here, there = getattr(mine, query)(given), getattr(theirs, query)(given)
        assert here.keys() == there.keys()
        for name, array in there.items():
            expected = array.numpy()
            assert (here[name].dtype, here[name].shape) == (expected.dtype, expected.shape)
            if query == "cast_rays" or name == "points":
                agree = np.isclose(here[name], expected, rtol=1e-3, atol=1e-3)
                assert agree.mean() > 0.999  # hits through an edge belong to either face
    counts = theirs.count_intersections(rays).numpy()
    assert np.mean(mine.count_intersections(rays) == counts) > 0.999
    assert np.allclose(mine.compute_distance(points), theirs.compute_distance(points).numpy(), atol=1e-5)
    view = (60, [0.5, 0.5, 0.5], [-1, -1, -1], [0, 0, 1], 32, 24)
    expected = open3d.t.geometry.RaycastingScene.create_rays_pinhole(*view).numpy()
    assert np.allclose(RaycastingScene.create_rays_pinhole(*view), expected, atol=1e-6)
