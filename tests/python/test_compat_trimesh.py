"""The interface of trimesh, answered by treelet."""

import copy
import gc
import pickle
from types import SimpleNamespace

import numpy as np
import pytest
from sample_meshes import grid, random_triangles, torus

import treelet
from treelet.compat import _mesh_tree
from treelet.compat.trimesh import ProximityQuery, RayMeshIntersector, closest_point, signed_distance


class PlainMesh:
    def __init__(self, vertices, faces):
        self.vertices, self.faces = vertices, faces


def make_mesh(arrays):
    vertices, faces = arrays
    return PlainMesh(vertices.astype(np.float64), faces)


@pytest.fixture
def ring():
    return make_mesh(torus(40, 20))


def random_rays(count, seed):
    rng = np.random.default_rng(seed)
    return rng.normal(size=(count, 3)), rng.normal(size=(count, 3))


def test_lists_first_hits_of_all_rays_then_second_ones(ring):
    origins, directions = [[-3, 0, 0], [9, 9, 9], [-3, 0, 0.1]], [[2, 0, 0], [1, 0, 0], [1, 0, 0]]
    locations, index_ray, index_tri = RayMeshIntersector(ring).intersects_location(origins, directions)
    assert index_ray.tolist() == [0, 2, 0, 2, 0, 2, 0, 2]
    assert np.all(np.diff(locations[index_ray == 0, 0]) > 0)
    np.testing.assert_allclose(
        locations[index_ray == 0], [[x, 0, 0] for x in (-1.4, -0.6, 0.6, 1.4)], atol=1e-6
    )
    assert (locations.dtype, index_ray.dtype, index_tri.dtype) == (np.float64, np.int64, np.int64)


def test_agrees_with_all_hits(ring):
    origins, directions = random_rays(500, 1)
    hits = treelet.build(ring.vertices, ring.faces).intersect_all(origins, directions)
    index_tri, index_ray = RayMeshIntersector(ring).intersects_id(origins, directions)
    assert sorted(zip(index_ray, index_tri, strict=True)) == sorted(zip(hits.ray, hits.face, strict=True))


def test_max_hits_keeps_the_nearest(ring):
    intersector = RayMeshIntersector(ring)
    rays = random_rays(500, 2)
    all_tri, all_ray = intersector.intersects_id(*rays)
    few_tri, few_ray = intersector.intersects_id(*rays, max_hits=1)
    assert 0 < len(few_ray) < len(all_ray)
    np.testing.assert_array_equal(few_ray, np.unique(all_ray))
    np.testing.assert_array_equal(few_tri, all_tri[: len(few_tri)])
    with pytest.raises(ValueError, match="max_hits must be at least 1, not 0"):
        intersector.intersects_id(*rays, max_hits=0)


def test_first_any_and_single_hits_agree(ring):
    intersector = RayMeshIntersector(ring)
    rays = random_rays(500, 3)
    first, hit = intersector.intersects_first(*rays), intersector.intersects_any(*rays)
    index_tri, index_ray = intersector.intersects_id(*rays, multiple_hits=False)
    assert (first.dtype, hit.dtype) == (np.int64, np.bool_)
    np.testing.assert_array_equal(hit, first != -1)
    np.testing.assert_array_equal(np.flatnonzero(hit), index_ray)
    np.testing.assert_array_equal(first[index_ray], index_tri)


@pytest.mark.parametrize("count", [0, 3])
@pytest.mark.parametrize("multiple_hits", [False, True])
def test_shapes_without_hits(ring, count, multiple_hits):
    rays = np.full((count, 3), 9.0), np.ones((count, 3))
    intersector = RayMeshIntersector(ring)
    locations, index_ray, index_tri = intersector.intersects_location(*rays, multiple_hits=multiple_hits)
    assert (locations.shape, index_ray.shape, index_tri.shape) == ((0, 3), (0,), (0,))
    assert locations.dtype == np.float64
    assert intersector.intersects_first(*rays).tolist() == [-1] * count


def test_locations_lie_on_the_ray_in_float64():
    plane = make_mesh(grid(4))
    origins, directions = np.array([[1 / 3, 0.1, 1.0], [0.2, 1 / 7, 1.0]]), np.array([[0, 0, -3.0]] * 2)
    locations, _, _ = RayMeshIntersector(plane).intersects_location(origins, directions)
    np.testing.assert_array_equal(locations, origins * [1, 1, 0])


def test_locations_of_grazing_rays_lie_on_the_triangle():
    plane = make_mesh(grid(1))
    plane.vertices[:, 2] = np.array([0, 0.1, 0, 0.1]) * 1e-6
    origins, directions = [[-1, 0.3, 4.5e-8]], [[1, 0, -1e-8]]
    locations, _, _ = RayMeshIntersector(plane).intersects_location(origins, directions)
    assert len(locations) > 0
    assert np.all((locations >= -1e-6) & (locations <= 1 + 1e-6))


def test_contains_points(ring):
    points = [[1, 0, 0], [0, 0, 0], [-1, 0, 0.3], [5, 0, 0]]
    assert RayMeshIntersector(ring).contains_points(points).tolist() == [True, False, True, False]


def test_open_mesh_contains_nothing_outside_of_its_bounds():
    vertices, faces = grid(2)
    wall = make_mesh((vertices[:, [2, 0, 1]], faces))
    assert not RayMeshIntersector(wall).contains_points([[5, 0.3, 0.3], [-5, 0.3, 0.3]]).any()


@pytest.mark.parametrize("change", ["in place", "vertices", "faces"])
def test_sees_changes_of_the_mesh(ring, change):
    intersector = RayMeshIntersector(ring)
    ray = [[1, 0, 9]], [[0, 0, -1]]
    assert intersector.intersects_any(*ray).all()
    if change == "in place":
        ring.vertices += 50
    elif change == "vertices":
        ring.vertices = ring.vertices + 50
    else:
        ring.faces = ring.faces[:0]
    assert not intersector.intersects_any(*ray).any()


def test_all_queries_of_a_mesh_share_one_tree(ring):
    ring.vertices[0] = np.nan  # not equal to itself
    tree = _mesh_tree.tree_of(ring)
    closest_point(ring, [[0, 0, 0]])
    RayMeshIntersector(ring).intersects_any([[0, 0, 0]], [[1, 0, 0]])
    assert _mesh_tree.tree_of(ring) is tree


def test_tree_goes_with_its_mesh():
    mesh = make_mesh(torus(8, 8))
    key = id(mesh)
    _mesh_tree.tree_of(mesh)
    assert key in _mesh_tree._trees
    del mesh
    gc.collect()
    assert key not in _mesh_tree._trees


def test_keeps_the_tree_of_an_object_without_weak_references(ring):
    mesh = SimpleNamespace(vertices=ring.vertices, faces=ring.faces)
    intersector, query = RayMeshIntersector(mesh), ProximityQuery(mesh)
    assert intersector._kept.of(mesh) is intersector._kept.of(mesh)
    assert query._kept.of(mesh) is query._kept.of(mesh)
    mesh.vertices = mesh.vertices + 50
    assert intersector.contains_points([[51, 50, 50]]).all()
    assert query.signed_distance([[51, 50, 50]])[0] > 0


def test_copies_and_pickles(ring):
    intersector = RayMeshIntersector(ring)
    ray = [[1, 0, 9]], [[0, 0, -1]]
    for other in (copy.deepcopy(intersector), pickle.loads(pickle.dumps(intersector))):
        assert other.mesh is not ring
        assert other.intersects_any(*ray).all()


def brute_force_distance(mesh, points):
    """Of each point to the nearest of many samples of each triangle."""
    weights = np.array([(i, j, 12 - i - j) for i in range(13) for j in range(13 - i)]) / 12
    samples = np.einsum("wc,fcx->fwx", weights, mesh.vertices[mesh.faces]).reshape(-1, 3)
    return np.array([np.linalg.norm(samples - point, axis=1).min() for point in points])


def test_closest_point_is_on_its_triangle_and_nearest():
    mesh = make_mesh(random_triangles(50, seed=5))
    points, _ = random_rays(100, 4)
    closest, distance, face = closest_point(mesh, points)
    assert (closest.dtype, distance.dtype, face.dtype) == (np.float64, np.float64, np.int64)
    np.testing.assert_allclose(distance, np.linalg.norm(points - closest, axis=1), rtol=1e-15)
    sampled = brute_force_distance(mesh, points)
    assert np.all(distance <= sampled + 1e-12)
    assert np.all(distance >= sampled - 0.05)
    corners = mesh.vertices[mesh.faces[face]]
    weights = [np.linalg.lstsq(c.T, p, rcond=None)[0] for c, p in zip(corners, closest, strict=True)]
    assert np.min(weights) >= -1e-9
    np.testing.assert_allclose(np.sum(weights, axis=1), 1, atol=1e-9)


def test_of_triangles_that_share_the_nearest_point_the_one_that_faces_it():
    vertices = np.array([[-1, 0.5, 0], [1, 0.5, 0], [0, -1, -0.5], [0, -1, 0.5]])
    wedge = SimpleNamespace(vertices=vertices, faces=np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [3, 2, 1]]))
    points = [[0, 1, z] for z in (-0.5, -0.1, 0.1, 0.5)]
    closest, _, face = closest_point(wedge, points)
    np.testing.assert_allclose(closest, [[0, 0.5, 0]] * 4, atol=1e-15)
    assert face.tolist() == [0, 0, 2, 2]


def test_signed_distance_is_positive_inside(ring):
    points = np.array([[1, 0, 0], [0, 0, 0], [3, 0, 0], ring.vertices[0]])
    distance = signed_distance(ring, points)
    np.testing.assert_array_equal(np.sign(distance[:3]), [1, -1, -1])
    assert 0 <= distance[3] < 1e-12
    np.testing.assert_array_equal(distance, ProximityQuery(ring).signed_distance(points))


def test_nearest_vertex(ring):
    pytest.importorskip("scipy")
    distance, vertex = ProximityQuery(ring).vertex(ring.vertices[:9] + 1e-3)
    np.testing.assert_array_equal(vertex, np.arange(9))
    np.testing.assert_allclose(distance, np.sqrt(3) * 1e-3)


def test_empty_mesh_and_bad_points():
    nothing = SimpleNamespace(vertices=np.zeros((0, 3)), faces=np.zeros((0, 3), int))
    closest, distance, face = closest_point(nothing, [[0, 0, 0]])
    assert np.isnan(closest).all()
    assert np.isinf(distance).all()
    assert face.tolist() == [-1]
    assert signed_distance(nothing, [[0, 0, 0]]).tolist() == [-np.inf]
    triangle = SimpleNamespace(vertices=np.eye(3), faces=np.array([[0, 1, 2]]))
    assert signed_distance(triangle, [[np.nan, 0, 0], [0, np.inf, 0]]).tolist() == [-np.inf] * 2
    assert not RayMeshIntersector(nothing).contains_points([[0, 0, 0], [np.nan, 0, 0]]).any()


def test_collinear_triangles_do_not_disturb():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]])
    mesh = SimpleNamespace(vertices=vertices, faces=np.array([[0, 1, 2], [0, 1, 3]]))
    closest, distance, _ = closest_point(mesh, [[0.5, -1, 0], [1.5, 0, 3]])
    np.testing.assert_allclose(closest, [[0.5, 0, 0], [1.5, 0, 0]], atol=1e-15)
    np.testing.assert_allclose(distance, [1, 3])


@pytest.mark.parametrize(
    ("origins", "directions", "said"),
    [
        ([0, 0, 0], [0, 0, 1], r"ray_origins must have shape \(n, 3\), not \(3,\)"),
        ([[0, 0, 0]], [[0, 0]], "ray_directions must have shape"),
        ([[0, 0, 0]] * 2, [[0, 0, 1]], r"\(2, 3\) and ray_directions \(1, 3\) must have the same shape"),
    ],
)
def test_refuses_other_shapes(ring, origins, directions, said):
    with pytest.raises(ValueError, match=said):
        RayMeshIntersector(ring).intersects_id(origins, directions)


class TestBesideTrimesh:
    """The same answers as trimesh's own, where it is installed."""

    @pytest.fixture
    def sphere(self):
        trimesh = pytest.importorskip("trimesh")
        return trimesh.creation.icosphere(subdivisions=2)

    def test_rays(self, sphere):
        pytest.importorskip("embreex")
        rays = random_rays(500, 6)
        theirs, ours = (
            engine.intersects_location(*rays) for engine in (sphere.ray, RayMeshIntersector(sphere))
        )
        np.testing.assert_allclose(ours[0], theirs[0], atol=1e-12)
        for expected, index in zip(theirs[1:], ours[1:], strict=True):
            np.testing.assert_array_equal(index, expected)

    def test_sees_changes(self, sphere):
        sphere.ray = RayMeshIntersector(sphere)
        assert sphere.contains([[0, 0, 0]]).all()
        sphere.apply_translation([5, 0, 0])
        assert sphere.contains([[0, 0, 0], [5, 0, 0]]).tolist() == [False, True]

    def test_proximity(self, sphere):
        pytest.importorskip("rtree")
        pytest.importorskip("scipy")
        from trimesh import proximity

        points, _ = random_rays(200, 7)
        for expected, answer in zip(
            proximity.closest_point(sphere, points)[:2], closest_point(sphere, points)[:2], strict=True
        ):
            np.testing.assert_allclose(answer, expected, atol=1e-12)
        np.testing.assert_allclose(
            signed_distance(sphere, points), proximity.signed_distance(sphere, points), atol=1e-12
        )


def test_far_meshes_have_as_few_rivals_for_a_nearest_point_as_near_ones(monkeypatch):
    radii = []
    overlap = treelet.Bvh.overlap_spheres

    def spy(bvh, centers, reach):
        radii.append(np.max(reach, initial=0))
        return overlap(bvh, centers, reach)

    monkeypatch.setattr(treelet.Bvh, "overlap_spheres", spy)
    vertices, faces = torus(40, 20)
    points = np.random.default_rng(5).normal(size=(50, 3))
    for offset in (np.zeros(3), np.array([450_000.0, 5_400_000.0, 0.0])):
        mesh = PlainMesh(vertices.astype(np.float64) + offset, faces)
        distance = closest_point(mesh, points + offset)[1]
        assert np.all(np.isfinite(distance))
    near, far = radii
    assert 0 < far < 4 * near
