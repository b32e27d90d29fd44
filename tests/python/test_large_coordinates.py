"""Vertices in float64 far from the origin, where float32 is too coarse: an offset keeps them precise."""

import pickle
import warnings

import numpy as np
import pytest
from exact_oracle import exact_hits
from sample_meshes import TRIANGLE_FACES, grid, random_triangles

import treelet
from treelet import _inputs

UTM = np.array([450_000.0, 5_400_000.0, 120.0])  # metres
EXTENT = 100.0


def hills(cells=14):
    """(V, 3) float64: 100 m by 100 m of smooth hills, at UTM coordinates that float32 cannot hold."""
    vertices, faces = grid(cells)
    points = vertices.astype(np.float64) * EXTENT
    points[:, 2] = 5 * np.sin(points[:, 0] / 9) * np.cos(points[:, 1] / 7)
    return points + UTM + 0.123456789, faces


def rays_from_above(count=200, seed=4):
    """Origins in float64, directions that float32 holds exactly."""
    rng = np.random.default_rng(seed)
    origins = UTM + rng.random((count, 3)) * [EXTENT, EXTENT, 20] + [0, 0, 30]
    directions = np.float32(rng.standard_normal((count, 3)) * [0.4, 0.4, 0.1] - [0, 0, 1])
    return origins, directions


@pytest.fixture(scope="module")
def expected():
    """The closest face and its t of each ray, by rational arithmetic over the float64 mesh."""
    vertices, faces = hills()
    corners = vertices[faces]
    found = []
    for origin, direction in zip(*rays_from_above(), strict=True):
        hits = exact_hits(origin, direction, corners, range(len(faces)))
        face = min(hits, key=hits.__getitem__, default=-1)
        found.append((face, float(hits[face]) if face >= 0 else np.inf))
    faces_hit, t = zip(*found, strict=True)
    return np.array(faces_hit), np.array(t)


def count_faults(bvh, expected, rays=None):
    """Rays whose face is wrong, or whose t is off by more than positions of 100 m in float32 explain."""
    hits = bvh.intersect(*(rays or rays_from_above()))
    face, t = expected
    with np.errstate(invalid="ignore"):
        is_off = ~(np.abs(hits.t - t) <= 4 * np.spacing(np.float32(EXTENT))) & np.isfinite(t)
    return int(((hits.face != face) | is_off).sum())


@pytest.mark.parametrize("recipe", ["balanced", "lbvh > bvh2", "lbvh > cwbvh", "best"])
def test_every_ray_hits_its_triangle(expected, recipe):
    assert (expected[0] >= 0).sum() > 100
    vertices, faces = hills()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        bvh = treelet.build(vertices, faces, recipe)
    assert count_faults(bvh, expected) == 0
    assert bvh.report.vertex_rounding <= np.spacing(np.float32(EXTENT)) / 2
    assert bvh.validate(vertices, faces) == []


def test_float32_would_not_do(expected):
    vertices, faces = hills()
    bvh = treelet.build(vertices.astype(np.float32), faces)
    np.testing.assert_array_equal(bvh.offset, 0)
    assert count_faults(bvh, expected) > 100


def test_float32_vertices_stay_where_they_are():
    vertices, faces = random_triangles(50)
    far = vertices + np.float32(UTM)
    for given in (far, far.astype(">f4"), far.astype("f4", order="F")):
        bvh = treelet.build(given, faces)
        np.testing.assert_array_equal(bvh.offset, 0)
        assert bvh.report.vertex_rounding == 0
        assert bvh.bounds.dtype == np.float32
        np.testing.assert_array_equal(bvh.bounds, [far.min(axis=0), far.max(axis=0)])


def test_brute_force_and_every_query_know_the_offset(expected):
    vertices, faces = hills()
    origins, directions = rays_from_above()
    bvh = treelet.build(vertices, faces)
    hits = bvh.intersect(origins, directions)
    for ours, others in zip(
        hits, treelet.intersect_brute_force(vertices, faces, origins, directions), strict=True
    ):
        np.testing.assert_array_equal(ours, others)
    np.testing.assert_array_equal(bvh.occluded(origins, directions), hits.face >= 0)
    np.testing.assert_array_equal(bvh.intersect(origins, directions, reorder=True).t, hits.t)
    assert bvh.traversal_cost(origins, directions).nodes.max() < 100  # the rays start near the tree


def test_bounds_are_in_the_mesh_s_coordinates():
    vertices, faces = hills()
    bounds = treelet.build(vertices, faces).bounds
    assert bounds.dtype == np.float64
    np.testing.assert_allclose(bounds, [vertices.min(axis=0), vertices.max(axis=0)], rtol=0, atol=1e-5)


def test_axes_near_the_origin_are_left_alone():
    vertices, faces = hills()
    offset = treelet.build(vertices, faces).offset
    assert offset[2] == 0
    assert (np.abs(offset[:2] - UTM[:2]) <= EXTENT).all()
    near = vertices - UTM
    np.testing.assert_array_equal(treelet.build(near, faces).offset, 0)


@pytest.mark.parametrize("scale", [1e-300, 1e-30, 1e-3, 1.0, 1e6, 1e30, 1e290])
@pytest.mark.parametrize("spread", [1e-14, 1e-9, 1e-3, 0.3, 10.0])
def test_the_offset_is_subtracted_exactly(scale, spread):
    """Fractions, not floats, tell."""
    from fractions import Fraction

    from treelet._offset import choose_offset, subtract_offset

    seed = 3
    rng = np.random.default_rng(seed)
    vertices = (rng.choice([-1, 1], 3) * rng.random(3) + spread * rng.random((200, 3))) * scale
    offset = choose_offset(vertices)
    local = subtract_offset(vertices, offset)
    for axis in range(3):
        for far, near in zip(vertices[:, axis].tolist(), local[:, axis].tolist(), strict=True):
            assert Fraction(near) == Fraction(far) - Fraction(offset[axis])
    if spread < 0.01:
        assert any(offset)
    assert np.abs(local).max() <= 3 * np.ptp(vertices, axis=0).max()


@pytest.mark.parametrize(
    "vertices",
    [
        np.full((3, 3), 5e6),
        np.full((3, 3), np.nan),
        np.zeros((0, 3)),
        [[1e308, 0, 0], [-1e308, 0, 0], [0, 1e308, 0]],
        [[5e6, 1e-320, 0], [5e6, 0, 1e-320], [5e6, 0, 0]],
        [[np.inf, 0, 0], [1e39, 0, 0], [0, 0, 0]],
        np.array([[np.longdouble("1e400"), 0, 0], [5e6, 0, 0], [np.nan, 5e6, 0]]),
    ],
)
@pytest.mark.filterwarnings("ignore::treelet.PrecisionWarning")
def test_meshes_without_an_extent_or_beyond_floats(vertices):
    bvh = treelet.build(vertices, TRIANGLE_FACES if len(vertices) else [])
    assert np.isfinite(bvh.offset).all()
    bvh.intersect([0, 0, 1], [0, 0, -1])


def test_integers_are_vertices_too():
    vertices = np.array([[0, 0, 0], [2, 0, 0], [0, 2, 0]]) + 2**40 + 1
    bvh = treelet.build(vertices, TRIANGLE_FACES)
    assert bvh.report.vertex_rounding == 0
    assert bvh.intersect(vertices[0] + [0.5, 0.5, 8], [0, 0, -1]).t == 8


def test_a_refit_keeps_the_offset_and_a_rebuild_chooses_that_of_a_build(expected):
    vertices, faces = hills()
    bvh = treelet.build(vertices + 30, faces, updatable=True)
    for update in (bvh.refit, bvh.rebuild, bvh.rebuild, bvh.refit):
        is_rebuild = update == bvh.rebuild
        offset = treelet.build(vertices, faces).offset if is_rebuild else bvh.offset
        update(vertices)
        assert count_faults(bvh, expected) == 0
        np.testing.assert_array_equal(bvh.offset, offset)
        assert not is_rebuild or bvh.mesh_hash == treelet.mesh_hash(vertices, faces)
        assert 0 < bvh.report.vertex_rounding < 1e-5
        assert bvh.validate(vertices, faces) == []
        assert pickle.loads(pickle.dumps(bvh)).report.vertex_rounding == bvh.report.vertex_rounding


def test_a_refit_that_leaves_the_offset_behind_is_warned_of_and_a_rebuild_follows():
    vertices, faces = hills()
    bvh = treelet.build(vertices, faces, updatable=True)
    with pytest.warns(treelet.PrecisionWarning, match="subtract an offset nearer to the mesh") as caught:
        bvh.refit(vertices + 1e6)
    assert caught[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        bvh.rebuild(vertices + 1e6)
    assert bvh.report.vertex_rounding < 1e-5


def test_saved_trees_keep_the_offset(expected, tmp_path):
    vertices, faces = hills()
    bvh = treelet.build(vertices, faces)
    bvh.save(tmp_path / "a.treelet")
    for loaded in (treelet.load(tmp_path / "a.treelet"), pickle.loads(pickle.dumps(bvh))):
        assert count_faults(loaded, expected) == 0
        np.testing.assert_array_equal(loaded.offset, bvh.offset)
        np.testing.assert_array_equal(loaded.bounds, bvh.bounds)
        assert loaded.mesh_hash == bvh.mesh_hash == treelet.mesh_hash(vertices, faces)
    assert treelet.mesh_hash(vertices - 2**20, faces) != bvh.mesh_hash


def test_points_become_relative_to_an_offset():
    points = UTM + np.array([[[1.25, 2.5, 3.0]], [[-1.25, 0.0, 0.5]]])
    shape, rows = _inputs.as_points(points, offset=(450_000.0, 5_400_000.0, 0.0))
    assert shape == (2, 1)
    assert rows.dtype == np.float32
    np.testing.assert_array_equal(rows, [[1.25, 2.5, 123], [-1.25, 0, 120.5]])
    assert _inputs.as_points([1, 2, 3]).shape == ()
    with pytest.raises(ValueError, match=r"^queries must have shape \(\.\.\., 3\), not \(2,\)$"):
        _inputs.as_points([1, 2], "queries")
