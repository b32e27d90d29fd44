"""treelet.build(..., precision="float64"): every answer against whole-number arithmetic, to the last bit."""

import copy
import pickle
import warnings

import numpy as np
import pytest
from double_oracle import as_float, closest, exact_places
from sample_meshes import TRIANGLE_FACES, TRIANGLE_VERTICES, grid, torus

import treelet

UTM = np.array([450_000.0, 5_400_000.0, 120.0])  # metres


def build(vertices, faces, **options):
    return treelet.build(vertices, faces, precision="float64", **options)


def soup(count, seed):
    """Triangles of all sizes from 1e-6 to 1 in the unit cube."""
    rng = np.random.default_rng(seed)
    sizes = 10.0 ** rng.uniform(-6, 0, (count, 1, 1))
    corners = rng.random((count, 1, 3)) + sizes * rng.standard_normal((count, 3, 3))
    return corners.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3)


def rays_at(vertices, faces, count, seed, scale=1.0):
    """From near the mesh at vertices, middles of edges, points inside of triangles, and anywhere."""
    rng = np.random.default_rng(seed)
    triangles = vertices[faces[rng.integers(len(faces), size=count)]]
    weights = np.array([[1, 0, 0], [0.5, 0.5, 0], [0.3, 0.3, 0.4], [0.8, -1.2, 1.4]])
    weights = rng.permuted(weights[np.arange(count) % 4], axis=1)
    targets = np.einsum("nk,nkx->nx", weights, triangles)
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    origins = low + (high - low) * rng.uniform(-0.5, 1.5, (count, 3))
    return origins, (targets - origins) * scale


def check_closest(bvh, vertices, faces, origins, directions, t_min=0.0, t_max=np.inf):
    """All four answers, bit for bit; returns how many rays hit."""
    hits = bvh.intersect(origins, directions, t_min, t_max)
    occluded = bvh.occluded(origins, directions, t_min, t_max)
    corners = vertices[faces]
    for i, (origin, direction) in enumerate(zip(origins, directions, strict=True)):
        expected = closest(exact_places(origin, direction, corners), t_min, t_max)
        found = tuple(array[i].item() for array in hits)
        assert found == expected, f"ray {i}: {origin!r} {direction!r}"
        assert occluded[i] == (expected[1] >= 0)
    return int((hits.face >= 0).sum())


def check_lists(bvh, vertices, faces, origins, directions):
    """What is listed is met, where it says; and rays through the inside alone list all that they meet."""
    hits = bvh.intersect_all(origins, directions)
    np.testing.assert_array_equal(np.diff(hits.offsets), bvh.count_hits(origins, directions))
    corners = vertices[faces]
    generic = 0
    for i, (origin, direction) in enumerate(zip(origins, directions, strict=True)):
        places = exact_places(origin, direction, corners)
        row = slice(hits.offsets[i], hits.offsets[i + 1])
        found = list(zip(*(array[row].tolist() for array in hits[1:]), strict=True))
        assert found == sorted(found, key=lambda hit: hit[:2])
        for t, face, u, v in found:
            assert (t, u, v) == tuple(as_float(value) for value in places[face])
        if all(min(place.u, place.v, 1 - place.u - place.v) > 0 for place in places.values()):
            generic += 1
            ahead = {face for face, place in places.items() if place.t >= 0}
            assert {face for _, face, _, _ in found} == ahead
    return generic


@pytest.mark.parametrize("scale", [1.0, 1e-9, 1e9, 1e-100, 1e100, 1e150, 1e-150, 1e-310, 1e300])
def test_closest_hits_are_exact_at_any_scale(scale):
    vertices, faces = soup(40, seed=1)
    vertices = vertices * scale
    bvh = build(vertices, faces, validate=True)
    origins, directions = rays_at(vertices, faces, 60, seed=2)
    assert check_closest(bvh, vertices, faces, origins, directions) > 30
    assert check_lists(bvh, vertices, faces, origins[:30], directions[:30]) > 5


@pytest.mark.parametrize("scale", [1e-300, 1e-30, 1e-3, 1e30, 1e290])
def test_directions_of_any_length(scale):
    vertices, faces = soup(30, seed=3)
    origins, directions = rays_at(vertices, faces, 40, seed=4, scale=scale)
    assert check_closest(build(vertices, faces), vertices, faces, origins, directions) > 15


@pytest.mark.parametrize("distance", [1e3, 1e9, 1e15, 1e18, 1e200])
def test_origins_far_away(distance):
    """Beyond 1e16 extents no float64 ray can be aimed at a mesh, but it has an answer all the same."""
    vertices, faces = soup(30, seed=5)
    rng = np.random.default_rng(6)
    targets = vertices[faces[rng.integers(len(faces), size=40)]].mean(axis=1)
    origins = targets + distance * rng.standard_normal((40, 3))
    hits = check_closest(build(vertices, faces), vertices, faces, origins, targets - origins)
    assert hits > (20 if distance < 1e8 else -1)


def test_axis_rays_from_very_far_hit():
    vertices, faces = grid(8)
    vertices = vertices.astype(np.float64)
    x, y = np.meshgrid(np.linspace(0, 1, 17), np.linspace(0, 1, 17))
    origins = np.stack([x, y, np.full_like(x, 1e30)], axis=-1).reshape(-1, 3)
    bvh = build(vertices, faces)
    hits = bvh.intersect(origins, [0, 0, -1])
    assert (hits.t == 1e30).all()
    assert (bvh.count_hits(origins[x.ravel() % 1 != 0], [0, 0, -1]) <= 1).all()


def test_tenths_of_millimetres_at_utm_coordinates():
    """Beside a kilometre: neither float32 nor float32 with an offset tells their sides apart."""
    vertices, faces = grid(12)
    points = vertices.astype(np.float64) * 0.0012
    points[:, 2] = 2e-5 * np.sin(points[:, 0] * 3e4) * np.cos(points[:, 1] * 2.5e4)
    field = np.concatenate([points, [[0, 0, 0], [900, 0, 0], [0, 900, 0]]])
    field += UTM + 0.123456789
    faces = np.concatenate([faces, [[len(points), len(points) + 1, len(points) + 2]]])
    rng = np.random.default_rng(7)
    origins = field[0] + rng.random((150, 3)) * [0.0012, 0.0012, 0.001] + [0, 0, 0.001]
    directions = rng.standard_normal((150, 3)) * 0.1 - [0, 0, 1]
    assert check_closest(build(field, faces), field, faces, origins, directions) > 100
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        rounded = treelet.build(field, faces).intersect(origins, directions).face
    exact = build(field, faces).intersect(origins, directions).face
    assert (rounded != exact).sum() > 30


def test_nanometres_beside_kilometres():
    small, faces = torus(9, 7)
    small = small.astype(np.float64) * 1e-9 + [17.0, 0.0, 0.0]
    wide, wide_faces = grid(4)
    wide = wide.astype(np.float64) * 2e3 - 1e3
    vertices = np.concatenate([small, wide])
    faces = np.concatenate([faces, wide_faces + len(small)])
    rng = np.random.default_rng(8)
    targets = small[rng.integers(len(small), size=60)]
    origins = targets + 1e-8 * rng.standard_normal((60, 3))
    bvh = build(vertices, faces)
    assert check_closest(bvh, vertices, faces, origins, targets - origins) > 40
    far = targets + rng.standard_normal((60, 3))
    assert check_closest(bvh, vertices, faces, far, targets - far) > 20


def closed_meshes():
    vertices, faces = torus(24, 16)
    vertices = vertices.astype(np.float64)
    turned = vertices @ np.linalg.qr(np.random.default_rng(9).standard_normal((3, 3)))[0]
    return {
        "unit": (vertices, faces),
        "turned": (turned, faces),
        "utm": (turned * 1e-3 + UTM, faces),
        "tiny": (turned * 1e-200, faces),
        "huge": (turned * 1e200, faces),
        "flat": (turned * [1, 1, 1e-12], faces),
    }


@pytest.mark.parametrize("name", closed_meshes())
def test_counts_are_even_from_outside_and_odd_from_inside(name):
    """Rays at vertices and middles of edges, where floats would count wrong."""
    vertices, faces = closed_meshes()[name]
    bvh = build(vertices, faces)
    ring = vertices.reshape(24, 16, 3)
    inside = ring.mean(axis=1)  # the middle of the tube
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    outside = np.array([2 * low - high, 2 * high - low, [2 * low[0] - high[0], low[1], high[2]]])
    edges = np.unique(np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
    targets = np.concatenate([vertices, vertices[edges].mean(axis=1)])
    for origins, parity in ((outside, 0), (inside[::8], 1)):
        directions = targets[None] - origins[:, None]
        counts = bvh.count_hits(origins[:, None], directions)
        assert counts.max() > parity
        assert (counts % 2 == parity).all()
        np.testing.assert_array_equal(
            np.diff(bvh.intersect_all(origins[:, None], directions).offsets), counts.ravel()
        )


def test_no_ray_slips_through_an_edge():
    vertices, faces = closed_meshes()["utm"]
    bvh = build(vertices, faces)
    inside = vertices.reshape(24, 16, 3).mean(axis=1)[::5]
    edges = vertices[faces[:, :2]].mean(axis=1)
    directions = np.concatenate([vertices, edges])[None] - inside[:, None]
    assert bvh.occluded(inside[:, None], directions).all()
    assert np.isfinite(bvh.intersect(inside[:, None], directions).t).all()


def test_limits_are_included_to_the_bit():
    vertices, faces = soup(20, seed=10)
    origins, directions = rays_at(vertices, faces, 40, seed=11)
    bvh = build(vertices, faces)
    hits = bvh.intersect(origins, directions)
    is_hit = hits.face >= 0
    origins, directions, t = origins[is_hit], directions[is_hit], hits.t[is_hit]
    assert len(t) > 10
    np.testing.assert_array_equal(bvh.intersect(origins, directions, t_max=t).t, t)
    np.testing.assert_array_equal(bvh.intersect(origins, directions, t_min=t).t, t)
    assert not bvh.occluded(origins, directions, t_max=np.nextafter(t, -1)).any()
    assert (bvh.intersect(origins, directions, t_min=np.nextafter(t, np.inf)).t > t).all()
    assert bvh.occluded(origins, directions, t_min=t, t_max=t).all()
    check_closest(bvh, vertices, faces, origins[:10], directions[:10], t_min=-1.0, t_max=0.5)
    check_closest(bvh, vertices, faces, origins[:10], directions[:10], t_min=-np.inf)


def test_of_equal_t_the_smaller_face_wins_and_lists_hold_all():
    vertices = np.concatenate([TRIANGLE_VERTICES] * 5).astype(np.float64)
    faces = np.arange(15).reshape(5, 3)
    bvh = build(vertices, faces)
    hit = bvh.intersect([0.1, 0.2, 1 / 3], [0, 0, -1])
    assert (hit.t, hit.face, hit.u, hit.v) == (1 / 3, 0, 0.1, 0.2)
    hits = bvh.intersect_all([0.1, 0.2, 1], [0, 0, -1])
    assert hits.face.tolist() == [0, 1, 2, 3, 4]
    assert hits.ray.tolist() == [0] * 5
    assert bvh.intersect_all([0.1, 0.2, 1], [0, 0, -1], limit=2).face.tolist() == [0, 1]


def test_the_sign_of_t_is_exact():
    """From a surface: at zero exactly, else before or behind, by however little."""
    bvh = build(TRIANGLE_VERTICES.astype(np.float64), TRIANGLE_FACES)
    for z in (5e-324, 1e-310, 1e-200, 1e-20):
        above, below = [0.25, 0.25, z], [0.25, 0.25, -z]
        assert bvh.intersect(above, [0, 0, -1]).t == z
        assert bvh.count_hits(above, [0, 0, -1e300]) == 1
        assert bvh.count_hits(below, [0, 0, -1e300]) == 0
        assert bvh.intersect(above, [0, 0, -1e300], t_min=5e-324).face == 0
    assert bvh.intersect([0.25, 0.25, 0], [0, 0, -1]).t == 0
    assert bvh.count_hits([0.25, 0.25, 1e300], [0, 0, -1e-300]) == 1  # t is beyond float64
    assert bvh.intersect([0.25, 0.25, 1e300], [0, 0, -1e-300]).face == -1


def test_bad_faces_and_rays():
    good = TRIANGLE_VERTICES.astype(np.float64)
    vertices = np.concatenate([good, np.add(good, [0, 0, 1]), [[np.nan, 0, 0], [np.inf, 1, 0]]])
    faces = [[0, 1, 6], [3, 4, 5], [0, 1, 7], [0, 0, 1], [0, 1, 2]]
    bvh = build(vertices, faces)
    assert (bvh.report.left_out_non_finite, bvh.report.left_out_degenerate) == (2, 1)
    assert bvh.intersect([0.2, 0.2, 3], [0, 0, -1]).face == 1
    assert bvh.count_hits([0.2, 0.2, 3], [0, 0, -1]) == 2
    np.testing.assert_array_equal(bvh.bounds, [[0, 0, 0], [1, 1, 1]])
    rays = [
        ([np.nan, 0, 0], [0, 0, -1]),
        ([0.2, 0.2, np.inf], [0, 0, -1]),
        ([0.2, 0.2, 3], [0, 0, -np.inf]),
        ([0.2, 0.2, 3], [0, 0, 0]),
    ]
    for origin, direction in rays:
        assert bvh.intersect(origin, direction).face == -1
        assert bvh.count_hits(origin, direction) == 0
        assert not bvh.occluded(origin, direction)
    assert bvh.intersect([0.2, 0.2, 3], [0, 0, -1], t_min=np.nan).face == -1
    assert bvh.intersect([0.2, 0.2, 3], [0, 0, -1], t_min=3, t_max=2).face == -1


@pytest.mark.parametrize("vertices", [[], np.zeros((0, 3)), np.full((3, 3), np.nan)])
def test_empty_trees(vertices):
    bvh = build(vertices, TRIANGLE_FACES if len(vertices) else [])
    np.testing.assert_array_equal(bvh.bounds, [[np.inf] * 3, [-np.inf] * 3])
    assert bvh.intersect(np.zeros((2, 3)), [0, 0, 1]).face.tolist() == [-1, -1]
    assert bvh.intersect_all([0, 0, 0], [0, 0, 1]).offsets.tolist() == [0, 0]
    assert bvh.intersect(np.zeros((0, 3)), [0, 0, 1]).t.shape == (0,)


def test_largest_doubles():
    top = np.finfo(np.float64).max
    vertices = np.array([[-top, -top, 0], [top, -top, 0], [0, top, 0]])
    bvh = build(vertices, TRIANGLE_FACES)
    origins = np.array([[0.0, 0, top], [0, 0, 1], [top, 0, top], [-top, top, -top]])
    directions = np.array([[0, 0, -top], [1e-3, 1e-3, -1e-5], [-top, -1, -top], [top, -top, top]])
    assert check_closest(bvh, vertices, TRIANGLE_FACES, origins, directions) >= 3


def test_shapes_and_types():
    bvh = build(TRIANGLE_VERTICES.tolist(), TRIANGLE_FACES)
    hits = bvh.intersect(np.full((4, 1, 3), [0.2, 0.2, 1]), np.full((5, 3), [0, 0, -1]))
    assert [array.dtype for array in hits] == [np.float64, np.int32, np.float64, np.float64]
    assert all(array.shape == (4, 5) for array in hits)
    assert bvh.occluded([0.2, 0.2, 1], [0, 0, -1]).shape == ()
    assert bvh.count_hits([0.2, 0.2, 1], [0, 0, -1]).dtype == np.int64
    assert bvh.face_count == 1
    assert "DoubleBvh of 1 faces" in repr(bvh)
    assert copy.deepcopy(bvh) is bvh is copy.copy(bvh)
    assert np.isnan(bvh.report.epo)


def test_recipes():
    vertices, faces = soup(200, seed=12)
    origins, directions = rays_at(vertices, faces, 200, seed=13)
    expected = build(vertices, faces).intersect(origins, directions)
    for recipe in ("fast", "hploc > bvh8", "sweep > reinsert > bvh8(leaf=16)", "binned"):
        bvh = build(vertices, faces, recipe=recipe, validate=True)
        for ours, others in zip(bvh.intersect(origins, directions), expected, strict=True):
            np.testing.assert_array_equal(ours, others)
    assert "sbvh" not in build(vertices, faces, rays=1e12).report.recipe


def test_any_number_of_threads_gives_the_same(request):
    request.addfinalizer(lambda: treelet.set_thread_count(0))
    vertices, faces = soup(300, seed=14)
    origins, directions = rays_at(vertices, faces, 3000, seed=15)
    answers = []
    for threads in (1, 3):
        treelet.set_thread_count(threads)
        bvh = build(vertices, faces)
        answers.append([*bvh.intersect(origins, directions), *bvh.intersect_all(origins, directions)])
    for ours, others in zip(*answers, strict=True):
        np.testing.assert_array_equal(ours, others)


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"precision": "double"}, ValueError, 'precision must be "float32" or "float64", not \'double\''),
        ({"precision": np.float64}, TypeError, "precision must be text, not type"),
        ({"updatable": True}, ValueError, "a tree in float64 cannot be updated"),
        ({"recipe": "best"}, ValueError, "split no triangles, without presplit, sbvh"),
        ({"recipe": "presplit > lbvh"}, ValueError, "split no triangles"),
        ({"recipe": "lbvh > bvh2"}, ValueError, "of the layout bvh8, not 'lbvh > bvh2"),
        ({"recipe": "nothing"}, ValueError, "nothing"),
    ],
)
def test_what_is_not_there_is_an_error(options, error, message):
    with pytest.raises(error, match=message):
        treelet.build(TRIANGLE_VERTICES, TRIANGLE_FACES, **{"precision": "float64", **options})


def test_bad_arrays_are_errors_that_say_where():
    with pytest.raises(ValueError, match=r"vertices must have shape \(V, 3\), not \(3, 2\)"):
        build(np.zeros((3, 2)), TRIANGLE_FACES)
    with pytest.raises(TypeError, match="vertices must hold real numbers, not complex"):
        build(np.zeros((3, 3), complex), TRIANGLE_FACES)
    with pytest.raises(ValueError, match="face 0 refers to vertex 3, but the mesh has vertices 0 to 2"):
        build(TRIANGLE_VERTICES, [[0, 1, 3]])
    bvh = build(TRIANGLE_VERTICES, TRIANGLE_FACES)
    with pytest.raises(ValueError, match=r"origins must have shape \(\.\.\., 3\), not \(2,\)"):
        bvh.intersect([0, 0], [0, 0, 1])
    with pytest.raises(ValueError, match="cannot be broadcast"):
        bvh.occluded(np.zeros((2, 3)), np.zeros((3, 3)))
    with pytest.raises(ValueError, match="limit must be at least 1, not 0"):
        bvh.intersect_all([0, 0, 1], [0, 0, -1], limit=0)


def test_methods_that_are_missing_say_what_to_do_instead():
    bvh = build(TRIANGLE_VERTICES, TRIANGLE_FACES)
    for name, message in {
        "closest_point": "this is in float32 alone: treelet.build",
        "signed_distance": "this is in float32 alone",
        "refit": "build another one over the moved vertices",
        "save": "save vertices and faces, and build again",
        "to": "on the CPU alone",
    }.items():
        with pytest.raises(AttributeError, match=f"no attribute '{name}': .*{message}"):
            getattr(bvh, name)
    with pytest.raises(AttributeError, match=r"no attribute 'nonsense'$"):
        bvh.nonsense  # noqa: B018
    with pytest.raises(TypeError, match="cannot be pickled yet"):
        pickle.dumps(bvh)
