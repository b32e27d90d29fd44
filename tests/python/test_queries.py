"""What intersect(), occluded() and traversal_cost() promise, ray by ray."""

import numpy as np
import pytest
from sample_meshes import TRIANGLE_FACES, TRIANGLE_VERTICES, grid, random_triangles
from sample_rays import crossing_rays

import treelet

UP, DOWN = (0, 0, 1), (0, 0, -1)


@pytest.fixture(scope="module")
def mesh():
    return treelet.Mesh(*random_triangles(3000))


@pytest.fixture(scope="module")
def bvh(mesh):
    return treelet.build(mesh.vertices, mesh.faces)


@pytest.fixture(scope="module")
def rays(mesh):
    return crossing_rays(mesh, 2000, np.random.default_rng(5))


@pytest.fixture(scope="module")
def triangle():
    return treelet.build(TRIANGLE_VERTICES, TRIANGLE_FACES)


def assert_same(hits, expected):
    for ours, others in zip(hits, expected, strict=True):
        assert ours.dtype == others.dtype
        np.testing.assert_array_equal(ours, others)


def test_fields(bvh, rays):
    hits = bvh.intersect(*rays)
    assert isinstance(hits, treelet.Hits)
    assert hits._fields == ("t", "face", "u", "v")
    assert [array.dtype for array in hits] == [np.float32, np.int32, np.float32, np.float32]
    work = bvh.traversal_cost(*rays)
    assert work._fields == ("nodes", "triangles")
    assert [array.dtype for array in work] == [np.uint32, np.uint32]
    assert bvh.occluded(*rays).dtype == np.bool_
    is_hit = hits.face >= 0
    assert 0.2 < is_hit.mean() < 1
    np.testing.assert_array_equal(np.isfinite(hits.t), is_hit)
    assert (hits.face[~is_hit] == -1).all()
    assert (hits.u[~is_hit] == 0).all()
    assert (hits.v[~is_hit] == 0).all()


def test_hit_point_is_on_ray_and_triangle(mesh, bvh, rays):
    hits = bvh.intersect(*rays)
    hit = hits.face >= 0
    p0, p1, p2 = mesh.vertices[mesh.faces[hits.face[hit]]].astype(np.float64).swapaxes(0, 1)
    u, v = hits.u[hit, None].astype(np.float64), hits.v[hit, None].astype(np.float64)
    assert (u >= 0).all()
    assert (v >= 0).all()
    assert (u + v <= 1 + 2**-23).all()
    on_triangle = (1 - u - v) * p0 + u * p1 + v * p2
    on_ray = rays.origins[hit] + hits.t[hit, None].astype(np.float64) * rays.directions[hit]
    np.testing.assert_allclose(on_triangle, on_ray, rtol=0, atol=1e-6)


def test_u_and_v_belong_to_the_second_and_third_vertex(triangle):
    hits = triangle.intersect([[0.5, 0.25, 1], [0, 0, 1], [1, 0, 1], [0, 1, 1]], DOWN)
    np.testing.assert_array_equal(hits.u, [0.5, 0, 1, 0])
    np.testing.assert_array_equal(hits.v, [0.25, 0, 0, 1])


def test_t_counts_in_units_of_the_direction(triangle):
    hits = triangle.intersect([0.2, 0.2, 3], [[0, 0, -1], [0, 0, -6], [0, 0, -0.5], [0, 0, -1e-30]])
    np.testing.assert_array_equal(hits.t, np.float32([3, 0.5, 6, 3e30]))


def test_both_sides_are_hit(triangle):
    assert triangle.intersect([0.2, 0.2, -1], UP).face == 0
    assert triangle.intersect([0.2, 0.2, 1], DOWN).face == 0


# Shapes


@pytest.mark.parametrize(
    ("origins", "directions", "t_max", "shape"),
    [
        ((3,), (3,), (), ()),
        ((1, 3), (3,), (), (1,)),
        ((3,), (5, 3), (), (5,)),
        ((5, 3), (3,), (), (5,)),
        ((4, 6, 3), (4, 6, 3), (4, 6), (4, 6)),
        ((4, 1, 3), (6, 3), (), (4, 6)),
        ((3,), (3,), (7,), (7,)),
        ((2, 1, 1, 3), (3, 1, 3), (4,), (2, 3, 4)),
        ((0, 3), (0, 3), (), (0,)),
        ((3,), (0, 3), (), (0,)),
        ((0, 3), (1, 3), (1,), (0,)),
        ((4, 0, 3), (3,), (0,), (4, 0)),
        ((1, 1, 3), (1, 3), (1, 1, 1), (1, 1, 1)),
    ],
)
def test_leading_shapes_are_broadcast(bvh, origins, directions, t_max, shape):
    rng = np.random.default_rng(2)
    arguments = [rng.random(origins), rng.standard_normal(directions), np.zeros(()), 1 + rng.random(t_max)]
    full = [np.broadcast_to(a, (*shape, 3)).reshape(-1, 3) for a in arguments[:2]]
    full += [np.broadcast_to(a, shape).reshape(-1) for a in arguments[2:]]
    for query in (bvh.intersect, bvh.traversal_cost):
        for array, flat in zip(query(*arguments), query(*full), strict=True):
            assert array.shape == shape
            np.testing.assert_array_equal(array.reshape(-1), flat)
    assert bvh.occluded(*arguments).shape == shape
    np.testing.assert_array_equal(bvh.occluded(*arguments).reshape(-1), bvh.occluded(*full))


def test_an_image_of_rays(triangle):
    across, along = np.meshgrid(np.linspace(-0.5, 1.5, 32), np.linspace(-0.5, 1.5, 24))
    origins = np.stack([across, along, np.ones_like(across)], axis=-1)
    faces = triangle.intersect(origins, DOWN).face
    inside = (across >= 0) & (along >= 0) & (across + along <= 1)
    np.testing.assert_array_equal(faces == 0, inside)


# Limits


def test_limits_are_included(triangle):
    origin = [0.25, 0.25, 2]
    below, above = np.nextafter(np.float32(2), np.float32([0, 4]))
    assert triangle.intersect(origin, DOWN, t_max=2).face == 0
    assert triangle.intersect(origin, DOWN, t_min=2).face == 0
    assert triangle.intersect(origin, DOWN, t_min=2, t_max=2).face == 0
    assert triangle.intersect(origin, DOWN, t_max=below).face == -1
    assert triangle.intersect(origin, DOWN, t_min=above).face == -1
    hit = triangle.intersect([0.25, 0.25, 0], DOWN)
    assert (hit.face, hit.t) == (0, 0)


def test_limits_may_be_negative(triangle):
    origin = [0.25, 0.25, -2]
    assert triangle.intersect(origin, DOWN).face == -1
    assert triangle.intersect(origin, DOWN, t_min=-5).t == -2
    assert triangle.intersect(origin, DOWN, t_min=-np.inf, t_max=-1).t == -2


def test_limits_of_each_ray(bvh, rays):
    free = bvh.intersect(*rays)
    hit = free.face >= 0
    t_max = np.where(hit, free.t, 0)
    assert_same(bvh.intersect(*rays, 0, t_max), free)
    shorter = bvh.intersect(*rays, 0, np.nextafter(t_max, np.float32(-1)))
    assert (shorter.face == -1).all()
    after = bvh.intersect(*rays, np.nextafter(np.where(hit, free.t, 0), np.float32(np.inf)))
    assert (after.t > free.t)[hit & (after.face >= 0)].all()


def test_empty_interval_misses(triangle):
    assert triangle.intersect([0.2, 0.2, 1], DOWN, t_min=1.5, t_max=0.5).face == -1


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_rays_that_are_not_finite_miss(triangle, bad, axis):
    spoilt = np.zeros(3)
    spoilt[axis] = bad
    origin, direction = np.array([0.2, 0.2, 1]), np.array(DOWN)
    for ray in [(origin + spoilt, direction), (origin, direction + spoilt)]:
        assert triangle.intersect(*ray).face == -1
        assert not triangle.occluded(*ray)


def test_other_rays_that_cannot_hit(triangle):
    origin = (0.2, 0.2, 1)
    assert triangle.intersect(origin, (0, 0, 0)).face == -1
    assert triangle.intersect(origin, (0, 0, -1e-60)).face == -1  # zero as float32
    assert triangle.intersect((0.2, 0.2, 1e300), DOWN).face == -1  # infinite as float32
    assert triangle.intersect(origin, DOWN, t_min=np.nan).face == -1
    assert triangle.intersect(origin, DOWN, t_max=np.nan).face == -1
    assert triangle.intersect(origin, DOWN, t_max=1e300).face == 0


def test_bad_rays_do_not_disturb_their_neighbours(bvh, rays):
    origins, directions = rays.origins.copy(), rays.directions.copy()
    origins[::3], directions[1::3] = np.nan, 0
    hits, expected = bvh.intersect(origins, directions), bvh.intersect(*rays)
    assert (hits.face[::3] == -1).all()
    assert (hits.face[1::3] == -1).all()
    np.testing.assert_array_equal(hits.face[2::3], expected.face[2::3])


# Which face


def test_of_equal_t_the_smaller_face_wins():
    vertices, faces = grid(8)
    permuted = np.random.default_rng(3).permutation(faces)
    origins = np.concatenate([vertices, vertices[permuted].mean(axis=1)]) + np.float32([0, 0, 1])
    for recipe in ("fast", "balanced", "sweep"):
        hits = treelet.build(vertices, permuted, recipe).intersect(origins, DOWN)
        touching = [np.flatnonzero((permuted == vertex).any(axis=1))[0] for vertex in range(len(vertices))]
        np.testing.assert_array_equal(hits.face[: len(vertices)], touching)
        np.testing.assert_array_equal(hits.face[len(vertices) :], np.arange(len(faces)))


def test_of_identical_triangles_the_first_wins():
    bvh = treelet.build(TRIANGLE_VERTICES, np.tile(TRIANGLE_FACES, (1000, 1)), validate=True)
    assert bvh.intersect([0.2, 0.2, 1], DOWN).face == 0


def test_occluded_is_any_hit(bvh, rays):
    rng = np.random.default_rng(8)
    for t_min, t_max in [
        (0, np.inf),
        (0.2, 0.7),
        (rng.random(2000), 1 + rng.random(2000)),
        (-np.inf, np.inf),
    ]:
        expected = bvh.intersect(*rays, t_min, t_max).face >= 0
        np.testing.assert_array_equal(bvh.occluded(*rays, t_min, t_max), expected)
        assert expected.any()


def test_brute_force_takes_the_same_arguments(mesh, bvh, rays):
    some = [array[:300] for array in rays]
    t_min = np.linspace(0, 0.5, 300)
    brute = treelet.intersect_brute_force(mesh.vertices, mesh.faces, *some, t_min, 2.0)
    assert_same(bvh.intersect(*some, t_min, 2.0), brute)
    assert treelet.intersect_brute_force(mesh.vertices, mesh.faces, [0, 0, 9], UP).face.shape == ()


def test_traversal_cost(mesh, bvh, rays):
    work = bvh.traversal_cost(*rays)
    assert (work.nodes[bvh.intersect(*rays).face >= 0] >= 1).all()
    assert work.triangles.max() < len(mesh.faces) / 10
    fewer = bvh.traversal_cost(*rays, 0, 0.1)
    assert fewer.nodes.sum() < work.nodes.sum()
    nothing = bvh.traversal_cost(np.nan * rays.origins, rays.directions)
    assert nothing.nodes.max() == nothing.triangles.max() == 0


def test_reordered_rays_have_the_same_answers(bvh, rays):
    assert_same(bvh.intersect(*rays, reorder=True), bvh.intersect(*rays))
    assert_same(bvh.traversal_cost(*rays, reorder=True), bvh.traversal_cost(*rays))
    assert_same([bvh.occluded(*rays, reorder=True)], [bvh.occluded(*rays)])
    image = bvh.intersect((0.5, 0.5, -1), rays.directions.reshape(20, 100, 3), t_max=2, reorder=True)
    assert_same(image, bvh.intersect((0.5, 0.5, -1), rays.directions.reshape(20, 100, 3), t_max=2))
    assert bvh.occluded(np.empty((0, 3)), (0, 0, 1), reorder=True).shape == (0,)
    with pytest.raises(TypeError):
        bvh.intersect(*rays, 0, 1, True)


def test_results_outlive_the_tree():
    bvh = treelet.build(TRIANGLE_VERTICES, TRIANGLE_FACES)
    hits = bvh.intersect(np.full((10_000, 3), 0.2), DOWN)
    del bvh
    assert (hits.face == 0).all()
    hits.t[0] = 5  # theirs to change
    assert hits.t[0] == 5
