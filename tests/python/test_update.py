"""What refit() and rebuild() promise: answers of the moved mesh, and memory that stays."""

import numpy as np
import pytest
from sample_meshes import TRIANGLE_FACES, TRIANGLE_VERTICES, grid, random_triangles
from sample_rays import as_bytes, crossing_rays

import treelet

RECIPES = ["fast", "balanced", "lbvh > treelet > bvh2", "sweep"]


@pytest.fixture(scope="module")
def mesh():
    return treelet.Mesh(*random_triangles(2000))


def moved(vertices, frame):
    """Waves through the mesh; frame 0 leaves it as it is."""
    x, y, z = vertices.astype(np.float64).T
    amount = 0.1 * frame
    bent = np.stack([x + amount * np.sin(5 * y + frame), y + amount * z, z + amount * np.cos(4 * x)], axis=1)
    return bent.astype(np.float32)


def assert_brute_force(bvh, vertices, faces, seed=3, count=300):
    rays = crossing_rays(treelet.Mesh(vertices, faces), count, np.random.default_rng(seed))
    expected = treelet.intersect_brute_force(vertices, faces, *rays)
    assert as_bytes(bvh.intersect(*rays)) == as_bytes(expected)
    np.testing.assert_array_equal(bvh.occluded(*rays), expected.face >= 0)
    assert (expected.face >= 0).any()


def untimed(report):
    times = ("stages", "build_seconds", "refit_seconds", "held_bytes")
    return {name: value for name, value in report.as_dict().items() if name not in times}


@pytest.mark.parametrize("recipe", RECIPES)
def test_refit_answers_like_brute_force(mesh, recipe):
    bvh = treelet.build(mesh.vertices, mesh.faces, recipe, updatable=True)
    for frame in (1, 5, 40, 0):
        vertices = moved(mesh.vertices, frame)
        assert bvh.refit(vertices) is None
        assert bvh.validate() == bvh.validate(vertices, mesh.faces) == []
        assert_brute_force(bvh, vertices, mesh.faces)
        np.testing.assert_array_equal(bvh.bounds, [vertices.min(axis=0), vertices.max(axis=0)])


@pytest.mark.parametrize("recipe", RECIPES)
def test_rebuild_is_a_new_build(mesh, recipe):
    bvh = treelet.build(mesh.vertices, mesh.faces, recipe, updatable=True)
    rays = crossing_rays(mesh, 500, np.random.default_rng(1))
    for frame in (1, 2, 7):
        vertices = moved(mesh.vertices, frame)
        bvh.refit(moved(mesh.vertices, 3))
        assert bvh.rebuild(vertices) is None
        fresh = treelet.build(vertices, mesh.faces, recipe)
        assert as_bytes(bvh.intersect(*rays)) == as_bytes(fresh.intersect(*rays))
        assert as_bytes(bvh.traversal_cost(*rays)) == as_bytes(fresh.traversal_cost(*rays))
        assert untimed(bvh.report) == untimed(fresh.report)
        assert bvh.validate(vertices, mesh.faces) == []


def test_vertices_are_converted_as_for_build(mesh):
    bvh = treelet.build(mesh.vertices, mesh.faces, updatable=True)
    vertices = moved(mesh.vertices, 2)
    for given in (vertices.astype(np.float64), vertices.tolist(), np.asfortranarray(vertices)):
        for update in (bvh.refit, bvh.rebuild):
            update(given)
            assert bvh.validate(vertices, mesh.faces) == []
    far = 1e6 + vertices.astype(np.float64)
    with pytest.warns(treelet.PrecisionWarning) as warned:
        bvh.refit(far)
    assert warned[0].filename == __file__
    assert bvh.report.vertex_rounding > 0.01
    bvh.refit(vertices)
    assert bvh.report.vertex_rounding == 0


def test_tree_keeps_its_own_copy():
    vertices, faces = grid(4)
    bvh = treelet.build(vertices, faces, updatable=True)
    faces[:] = 0
    higher = vertices + np.float32([0, 0, 0.5])
    bvh.refit(higher)
    higher[:] = 0
    assert bvh.intersect([0.3, 0.3, 1], [0, 0, -1]).t == 0.5


# The report


def test_report_of_a_refit(mesh):
    bvh = treelet.build(mesh.vertices, mesh.faces, updatable=True)
    built = bvh.report
    assert (built.refits, built.refit_seconds, built.hidden) == (0, 0, 0)
    assert built.layout_sah == built.layout_sah_at_build > 1
    bvh.refit(moved(mesh.vertices, 3))
    bvh.refit(moved(mesh.vertices, 4))
    report = bvh.report
    assert (report.refits, built.refits) == (2, 0)
    assert report.refit_seconds > 0
    assert (report.recipe, report.sah, report.nodes) == (built.recipe, built.sah, built.nodes)
    assert report.layout_sah_at_build == built.layout_sah
    assert report.layout_sah != report.layout_sah_at_build
    bvh.refit(mesh.vertices)
    assert bvh.report.layout_sah == pytest.approx(built.layout_sah, rel=1e-9)
    bvh.rebuild(moved(mesh.vertices, 4))
    assert bvh.report.refits == bvh.report.refit_seconds == 0
    assert bvh.report.layout_sah == bvh.report.layout_sah_at_build < report.layout_sah


def test_trees_that_cannot_be_updated_hold_nothing(mesh):
    report = treelet.build(mesh.vertices, mesh.faces).report
    assert report.held_bytes == report.refits == 0
    assert report.layout_sah == report.layout_sah_at_build > 1


def test_memory_stays_constant_over_rebuilds(mesh):
    bvh = treelet.build(mesh.vertices, mesh.faces, updatable=True)
    assert bvh.report.bytes < bvh.report.held_bytes < 2 * bvh.report.bytes
    held = []
    for frame in range(50):
        bvh.rebuild(moved(mesh.vertices, frame % 4))
        held.append(bvh.report.held_bytes)
    assert max(held[10:]) <= max(held[:10])


# Bad triangles


def test_triangles_that_become_bad_are_hidden_and_come_back(mesh):
    bvh = treelet.build(mesh.vertices, mesh.faces, updatable=True)
    bad = mesh.vertices.copy()
    bad[mesh.faces[4, 1], 2] = np.nan
    bad[mesh.faces[5]] = np.inf
    bad[mesh.faces[7, 0]] = bad[mesh.faces[7, 2]]
    bvh.refit(bad)
    assert (bvh.report.hidden, bvh.report.left_out_non_finite, bvh.report.left_out_degenerate) == (3, 0, 0)
    assert bvh.validate() == []
    assert np.isfinite(bvh.bounds).all()
    rays = crossing_rays(mesh, 500, np.random.default_rng(1))
    expected = treelet.intersect_brute_force(bad, mesh.faces, *rays)
    assert as_bytes(bvh.intersect(*rays)) == as_bytes(expected)
    bvh.refit(mesh.vertices)
    assert bvh.report.hidden == 0
    assert bvh.validate(mesh.vertices, mesh.faces) == []


def test_triangles_left_out_at_the_build_stay_out_until_a_rebuild(mesh):
    bad = mesh.vertices.copy()
    bad[mesh.faces[:100, 1]] = np.nan
    bvh = treelet.build(bad, mesh.faces, updatable=True)
    bvh.refit(mesh.vertices)
    assert (bvh.report.left_out_non_finite, bvh.report.hidden) == (100, 0)
    rays = crossing_rays(mesh, 500, np.random.default_rng(1))
    assert bvh.intersect(*rays).face[bvh.intersect(*rays).face >= 0].min() >= 100
    bvh.rebuild(mesh.vertices)
    assert bvh.report.left_out_non_finite == 0
    assert_brute_force(bvh, mesh.vertices, mesh.faces)


@pytest.mark.parametrize("value", [0.25, np.nan, np.inf])
def test_a_mesh_that_collapses_is_missed_and_comes_back(mesh, value):
    bvh = treelet.build(mesh.vertices, mesh.faces, updatable=True)
    rays = crossing_rays(mesh, 200, np.random.default_rng(1))
    point = np.full_like(mesh.vertices, value)
    for update in (bvh.refit, bvh.rebuild):
        update(point)
        assert (bvh.intersect(*rays).face == -1).all()
        assert not bvh.occluded([-1, -1, -1], [1.25, 1.25, 1.25])
        assert bvh.validate() == []
    assert bvh.report.references == 0
    bvh.rebuild(mesh.vertices)
    assert_brute_force(bvh, mesh.vertices, mesh.faces)


def test_an_empty_mesh_can_be_updated():
    bvh = treelet.build([], [], updatable=True)
    bvh.refit([])
    bvh.rebuild(np.zeros((0, 3)))
    assert bvh.intersect([0, 0, 1], [0, 0, -1]).face == -1


# Errors


def test_a_tree_that_is_not_updatable_says_what_to_do():
    bvh = treelet.build(TRIANGLE_VERTICES, TRIANGLE_FACES)
    message = (
        r"^this tree cannot be updated: build it with treelet\.build\(vertices, faces, updatable=True\)$"
    )
    for update in (bvh.refit, bvh.rebuild):
        with pytest.raises(RuntimeError, match=message):
            update(TRIANGLE_VERTICES)


@pytest.mark.parametrize("name", ["refit", "rebuild"])
@pytest.mark.parametrize(
    ("vertices", "error", "message"),
    [
        (np.zeros((4, 3)), ValueError, "^the tree was built over 3 vertices and cannot be updated with 4: "),
        ([], ValueError, "^the tree was built over 3 vertices and cannot be updated with 0: "),
        (np.zeros((3, 2)), ValueError, r"^vertices must have shape \(V, 3\), not \(3, 2\)$"),
        (np.zeros(9), ValueError, r"^vertices must have shape \(V, 3\), not \(9,\)$"),
        ([["a"] * 3] * 3, TypeError, "^vertices must hold real numbers"),
        (None, TypeError, "^vertices must hold real numbers"),
    ],
)
def test_a_failed_update_leaves_the_tree_as_it_was(name, vertices, error, message):
    bvh = treelet.build(TRIANGLE_VERTICES, TRIANGLE_FACES, updatable=True)
    before = bvh.report
    with pytest.raises(error, match=message):
        getattr(bvh, name)(vertices)
    assert bvh.report is before
    assert bvh.intersect([0.2, 0.2, 1], [0, 0, -1]).t == 1
    getattr(bvh, name)(TRIANGLE_VERTICES + np.float32([0, 0, 0.5]))
    assert bvh.intersect([0.2, 0.2, 1], [0, 0, -1]).t == 0.5


def test_to_cpu_is_itself():
    bvh = treelet.build(TRIANGLE_VERTICES, TRIANGLE_FACES)
    assert bvh.to("cpu") is bvh
    with pytest.raises(ValueError, match=r"device must be .*, not 'tpu'"):
        bvh.to("tpu")


@pytest.mark.parametrize("update", ["refit", "rebuild"])
def test_a_wrong_number_of_vertices_is_all_that_is_said(update):
    bvh = treelet.build(TRIANGLE_VERTICES, TRIANGLE_FACES, updatable=True)
    rounded = np.full((4, 3), 1e7) + np.arange(12).reshape(4, 3) / 8  # as many would be warned of
    with pytest.raises(ValueError, match="built over 3 vertices and cannot be updated with 4"):
        getattr(bvh, update)(rounded)


@pytest.mark.parametrize("recipe", RECIPES)
def test_bounds_keep_a_place_for_hidden_triangles(mesh, recipe):
    bvh = treelet.build(mesh.vertices, mesh.faces, recipe, updatable=True)
    low, high = bvh.bounds
    bvh.refit(np.full_like(mesh.vertices, np.nan))
    assert bvh.report.hidden == len(mesh.faces)
    assert (low <= bvh.bounds).all()
    assert (bvh.bounds <= high).all()
    bvh.rebuild(np.full_like(mesh.vertices, np.nan))
    np.testing.assert_array_equal(bvh.bounds, [[np.inf] * 3, [-np.inf] * 3])
