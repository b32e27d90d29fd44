"""What intersect_all(), count_hits() and stream_hits() promise."""

from fractions import Fraction

import numpy as np
import pytest
from exact_oracle import exact_hit
from sample_meshes import TRIANGLE_FACES, TRIANGLE_VERTICES, random_triangles, torus
from sample_rays import aimed_rays, crossing_rays

import treelet

LAYOUTS = ["lbvh > bvh2", "sbvh(budget=50) > bvh8", "presplit(budget=50) > lbvh > cwbvh"]


@pytest.fixture(scope="module")
def mesh():
    return treelet.Mesh(*random_triangles(2000))


@pytest.fixture(scope="module", params=LAYOUTS)
def bvh(mesh, request):
    return treelet.build(mesh.vertices, mesh.faces, request.param)


@pytest.fixture(scope="module")
def rays(mesh):
    return crossing_rays(mesh, 1000, np.random.default_rng(5))


@pytest.fixture(scope="module")
def closed():
    return treelet.build(*torus(40, 20))


def test_fields(bvh, rays):
    hits = bvh.intersect_all(*rays)
    assert isinstance(hits, treelet.AllHits)
    assert hits._fields == ("offsets", "t", "face", "u", "v")
    types = [np.int64, np.float32, np.int32, np.float32, np.float32]
    assert [array.dtype for array in hits] == types
    assert hits.offsets.shape == (1001,)
    assert hits.offsets[0] == 0
    assert hits.offsets[-1] == len(hits.t) == len(hits.face) == len(hits.u) == len(hits.v) > 1000
    assert hits.ray.dtype == np.int64
    np.testing.assert_array_equal(np.bincount(hits.ray, minlength=1000), np.diff(hits.offsets))


def test_hits_are_those_of_exact_arithmetic(mesh, bvh, rays):
    hits = bvh.intersect_all(*rays)
    corners = mesh.vertices[mesh.faces]
    for ray in range(0, 1000, 100):
        origin, direction = rays.origins[ray], rays.directions[ray]
        exact = {face: exact_hit(origin, direction, triangle) for face, triangle in enumerate(corners)}
        exact = {face: t for face, t in exact.items() if t is not None and t >= 0}
        row = slice(hits.offsets[ray], hits.offsets[ray + 1])
        assert set(hits.face[row].tolist()) == set(exact)
        for t, face in zip(hits.t[row], hits.face[row].tolist(), strict=True):
            assert abs(Fraction(float(t)) - exact[face]) <= Fraction(float(np.spacing(t)))


def test_rows_are_sorted_and_without_repeats(bvh, rays):
    hits = bvh.intersect_all(*rays)
    order = np.lexsort([hits.face, hits.t, hits.ray])
    np.testing.assert_array_equal(order, np.arange(len(hits.t)))
    assert len(np.unique(np.stack([hits.ray, hits.face]), axis=1).T) == len(hits.t)


def test_the_first_hit_is_the_closest(bvh, rays):
    closest, first = bvh.intersect(*rays), bvh.intersect_all(*rays, limit=1)
    is_hit = closest.face >= 0
    np.testing.assert_array_equal(np.diff(first.offsets), is_hit)
    for ours, others in zip(first[1:], closest, strict=True):
        np.testing.assert_array_equal(ours, others[is_hit])


def test_layouts_threads_and_order_do_not_matter(mesh, bvh, rays):
    expected = treelet.build(mesh.vertices, mesh.faces).intersect_all(*rays)
    threads = treelet.thread_count()
    for count in (1, 3):
        treelet.set_thread_count(count)
        try:
            for reorder in (False, True):
                for ours, theirs in zip(bvh.intersect_all(*rays, reorder=reorder), expected, strict=True):
                    np.testing.assert_array_equal(ours, theirs)
                np.testing.assert_array_equal(
                    bvh.count_hits(*rays, reorder=reorder), np.diff(expected.offsets)
                )
        finally:
            treelet.set_thread_count(threads)


@pytest.mark.parametrize("limit", [1, 2, np.int64(5), 10**30])
def test_limit_keeps_the_first(bvh, rays, limit):
    every, few = bvh.intersect_all(*rays), bvh.intersect_all(*rays, limit=limit)
    place = np.arange(len(every.t)) - every.offsets[every.ray]
    kept = place < float(limit)
    for ours, theirs in zip(few[1:], every[1:], strict=True):
        np.testing.assert_array_equal(ours, theirs[kept])


@pytest.mark.parametrize(("max_hits", "limit"), [(1, None), (100, None), (100, 2), (10**6, None)])
def test_chunks_make_up_the_whole(bvh, rays, max_hits, limit):
    every = bvh.intersect_all(*rays, limit=limit)
    chunks = list(bvh.stream_hits(*rays, max_hits=max_hits, limit=limit))
    assert all(len(chunk.hits.t) <= max_hits or len(chunk.hits.offsets) == 2 for chunk in chunks)
    assert (len(chunks) == 1) == (max_hits == 10**6)
    rows = np.cumsum([0] + [len(chunk.hits.offsets) - 1 for chunk in chunks])
    np.testing.assert_array_equal([chunk.first_ray for chunk in chunks], rows[:-1])
    assert rows[-1] == 1000
    for i in range(1, 5):
        np.testing.assert_array_equal(np.concatenate([chunk.hits[i] for chunk in chunks]), every[i])
    counts = np.concatenate([np.diff(chunk.hits.offsets) for chunk in chunks])
    np.testing.assert_array_equal(counts, np.diff(every.offsets))


def test_any_leading_shape(bvh):
    origins = np.random.default_rng(1).random((4, 1, 3))
    directions = np.random.default_rng(2).standard_normal((5, 3))
    counts = bvh.count_hits(origins, directions)
    assert counts.shape == (4, 5)
    assert counts.dtype == np.int64
    hits = bvh.intersect_all(origins, directions)
    np.testing.assert_array_equal(np.diff(hits.offsets), counts.ravel())
    single = bvh.intersect_all(origins[0, 0], directions[0])
    assert len(single.offsets) == 2
    assert bvh.count_hits(origins[0, 0], directions[0]).shape == ()
    assert bvh.count_hits(np.empty((0, 3)), [0, 0, 1]).shape == (0,)
    np.testing.assert_array_equal(bvh.intersect_all(np.empty((0, 3)), [0, 0, 1]).offsets, [0])
    assert list(bvh.stream_hits(np.empty((0, 3)), [0, 0, 1])) == []


def test_an_empty_tree_has_no_hits():
    empty = treelet.build(np.empty((0, 3)), np.empty((0, 3), np.int32))
    assert empty.count_hits([0, 0, 0], [0, 0, 1]) == 0
    np.testing.assert_array_equal(empty.intersect_all(np.zeros((3, 3)), [0, 0, 1]).offsets, [0] * 4)


def test_bad_rays_have_no_hits():
    tree = treelet.build(TRIANGLE_VERTICES, TRIANGLE_FACES)
    inside, up = [0.2, 0.3, -1], [0, 0, 1]
    assert tree.count_hits(inside, up) == 1
    assert tree.count_hits(inside, [0, 0, 0]) == 0
    assert tree.count_hits([np.nan, 0, 0], up) == 0
    assert tree.count_hits(inside, [0, 0, np.inf]) == 0
    assert tree.count_hits(inside, up, t_min=np.nan) == 0
    assert tree.count_hits(inside, up, t_max=np.nan) == 0
    assert tree.count_hits(inside, up, t_min=2, t_max=0.5) == 0


def test_limits_are_included():
    tree = treelet.build(TRIANGLE_VERTICES, TRIANGLE_FACES)
    inside, up = [0.2, 0.3, -1], [0, 0, 1]
    assert tree.count_hits(inside, up, t_min=1, t_max=1) == 1
    assert tree.count_hits(inside, up, t_max=np.nextafter(np.float32(1), np.float32(0))) == 0
    assert tree.count_hits([0.2, 0.3, 0], up, t_min=0) == 1
    assert tree.count_hits([0.2, 0.3, 1e-38], np.multiply(up, 1e38)) == 0
    assert tree.count_hits([0.2, 0.3, -1e-38], np.multiply(up, 1e38)) == 1


@pytest.mark.parametrize("scale", [1e-30, 1, 1e30])
def test_counts_are_even_from_outside_and_odd_from_inside(scale):
    vertices, faces = torus(40, 20)
    mesh = treelet.Mesh((vertices * np.float32(scale)).astype(np.float32), faces)
    tree = treelet.build(mesh.vertices, mesh.faces)
    rays = aimed_rays(mesh, 100_000, np.random.default_rng(3))
    outside = np.abs(rays.origins[:, 2]) > 0.41 * scale
    counts = tree.count_hits(*rays)
    assert outside.sum() > 10_000
    assert (counts[outside] % 2 == 0).all()
    assert (counts > 0).mean() > 0.3
    ring = np.random.default_rng(4).uniform(0, 2 * np.pi, 100_000)
    inside = np.stack([np.cos(ring), np.sin(ring), 0 * ring], axis=-1) * scale
    targets = mesh.vertices[np.resize(faces.ravel(), len(ring))]
    counts = tree.count_hits(inside, targets - inside)
    assert (counts % 2 == 1).all()


def test_every_vertex_of_a_closed_mesh_seen_along_an_axis(closed):
    vertices, _ = torus(40, 20)
    for axis in range(3):
        direction = np.eye(3)[axis]
        assert (closed.count_hits(vertices - 4 * direction, direction) % 2 == 0).all()


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        ({"limit": 0}, ValueError, "limit must be at least 1, not 0"),
        ({"limit": -3}, ValueError, "limit must be at least 1"),
        ({"limit": 2.5}, TypeError, "limit must be a whole number, not float"),
        ({"limit": True}, TypeError, "limit must be a whole number, not bool"),
        ({"max_hits": 0}, ValueError, "max_hits must be at least 1"),
        ({"reorder": 1}, TypeError, "reorder must be True or False"),
        ({"t_min": "a"}, TypeError, "t_min must hold real numbers"),
    ],
)
def test_mistakes_are_named_at_once(closed, arguments, error, words):
    with pytest.raises(error, match=words):
        closed.stream_hits([0, 0, 0], [0, 0, 1], **arguments)
    if "max_hits" not in arguments:
        with pytest.raises(error, match=words):
            closed.intersect_all([0, 0, 0], [0, 0, 1], **arguments)


def test_shapes_that_do_not_fit_are_named(closed):
    with pytest.raises(ValueError, match="cannot be broadcast"):
        closed.count_hits(np.zeros((3, 3)), np.ones((4, 3)))


def test_an_update_ends_a_stream_of_hits():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
    bvh = treelet.build(vertices, [[0, 1, 2]], updatable=True)
    chunks = bvh.stream_hits(np.full((4, 3), 0.2), [0, 0, -1.0], t_min=-np.inf, max_hits=1)
    next(chunks)
    bvh.refit(vertices + 1)
    with pytest.raises(RuntimeError, match=r"^the tree was updated while its hits were streamed"):
        next(chunks)
