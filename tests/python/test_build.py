"""What build() promises: any sound mesh, the same tree every time, bad triangles left out and counted."""

import json

import numpy as np
import pytest
from sample_meshes import TRIANGLE_FACES, TRIANGLE_VERTICES, grid, random_triangles
from sample_rays import crossing_rays

import treelet
from treelet import scenes

RECIPES = ["fast", "balanced", "sweep"]


@pytest.mark.parametrize("recipe", RECIPES)
def test_empty_mesh_is_missed(recipe):
    for vertices, faces in [([], []), (np.zeros((0, 3)), np.zeros((0, 3), int)), (TRIANGLE_VERTICES, [])]:
        bvh = treelet.build(vertices, faces, recipe, validate=True)
        hits = bvh.intersect([[0, 0, 1]], [[0, 0, -1]])
        assert hits.t.tolist() == [np.inf]
        assert hits.face.tolist() == [-1]
        assert not bvh.occluded([0, 0, 1], [0, 0, -1])
        assert bvh.face_count == bvh.report.nodes == bvh.report.sah == bvh.report.epo == 0
        assert bvh.validate() == bvh.validate(vertices, faces) == []
        np.testing.assert_array_equal(bvh.bounds, [[np.inf] * 3, [-np.inf] * 3])


@pytest.mark.parametrize("recipe", RECIPES)
@pytest.mark.parametrize("count", [1, 2, 3, 9, 100])
def test_small_meshes(recipe, count):
    vertices, faces = random_triangles(count)
    bvh = treelet.build(vertices, faces, recipe, validate=True)
    assert bvh.validate(vertices, faces) == []
    assert bvh.face_count == bvh.report.references == count
    centres = vertices[faces].mean(axis=1)
    assert bvh.occluded(centres + np.float32([0, 0, 3]), [0, 0, -1]).all()


def test_bounds():
    vertices, faces = random_triangles(50)
    bounds = treelet.build(vertices, faces).bounds
    assert bounds.dtype == np.float32
    np.testing.assert_array_equal(bounds, [vertices.min(axis=0), vertices.max(axis=0)])


@pytest.mark.parametrize("recipe", RECIPES)
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_triangles_that_are_not_finite_are_left_out(recipe, bad):
    vertices, faces = random_triangles(20)
    vertices[faces[4, 1], 2] = bad
    vertices[faces[7, 0]] = bad
    report = treelet.build(vertices, faces, recipe, validate=True).report
    assert (report.faces, report.references) == (20, 18)
    assert (report.left_out_non_finite, report.left_out_degenerate) == (2, 0)


@pytest.mark.parametrize("recipe", RECIPES)
def test_triangles_with_equal_vertices_are_left_out(recipe):
    vertices, faces = random_triangles(20)
    faces[3] = faces[3, [0, 1, 1]]
    vertices[faces[5, 2]] = vertices[faces[5, 0]]  # equal in place, not in index
    report = treelet.build(vertices, faces, recipe, validate=True).report
    assert (report.left_out_non_finite, report.left_out_degenerate, report.references) == (0, 2, 18)


def test_collinear_triangles_stay():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]], np.float32)
    assert treelet.build(vertices, TRIANGLE_FACES).report.references == 1


def test_bad_triangles_change_no_other_hit():
    mesh = treelet.Mesh(*random_triangles(200))
    rays = crossing_rays(mesh, 500, np.random.default_rng(1))
    spoilt = np.concatenate([mesh.vertices, [[np.nan, 0, 0], [1e38, 1e38, np.inf]]]).astype(np.float32)
    more_faces = np.concatenate([mesh.faces, [[0, 1, 600], [2, 601, 3], [4, 4, 5]]])
    expected = treelet.build(mesh.vertices, mesh.faces).intersect(*rays)
    hits = treelet.build(spoilt, more_faces).intersect(*rays)
    for ours, others in zip(hits, expected, strict=True):
        np.testing.assert_array_equal(ours, others)
    assert (hits.face >= 0).any()


@pytest.mark.parametrize("recipe", RECIPES)
def test_same_tree_for_any_number_of_threads(recipe, restore_threads):
    mesh = scenes.make("forest", 20_000)
    facts = set()
    for threads in (1, 2, 4):
        treelet.set_thread_count(threads)
        report = treelet.build(mesh.vertices, mesh.faces, recipe).report.as_dict()
        facts.add(json.dumps({k: v for k, v in report.items() if k not in ("stages", "build_seconds")}))
    assert len(facts) == 1


@pytest.fixture
def restore_threads():
    before = treelet.thread_count()
    yield
    treelet.set_thread_count(before)


def test_thread_count(restore_threads):
    treelet.set_thread_count(3)
    assert treelet.thread_count() == 3
    treelet.set_thread_count(0)
    assert treelet.thread_count() >= 1
    for bad in (-1, 1.5, None):
        with pytest.raises(TypeError):
            treelet.set_thread_count(bad)


def test_tree_keeps_its_own_copy():
    vertices, faces = grid(4)
    bvh = treelet.build(vertices, faces)
    vertices[:], faces[:] = 0, 0
    assert bvh.intersect([0.3, 0.3, 1], [0, 0, -1]).t == 1


def test_validate_against_another_mesh():
    vertices, faces = grid(2)
    bvh = treelet.build(vertices, faces)
    assert bvh.validate(vertices, faces) == []
    assert bvh.validate(vertices.astype(np.float64), faces.tolist()) == []
    other = vertices.copy()
    other[4, 2] = 1
    assert "differs from face" in bvh.validate(other, faces)[0]
    assert bvh.validate(vertices, faces[:-1]) != []
    for arguments in ({"vertices": vertices}, {"faces": faces}):
        with pytest.raises(TypeError, match=r"^validate takes both vertices and faces, or neither$"):
            bvh.validate(**arguments)


def test_repr():
    text = repr(treelet.build(*grid(100)))
    assert text.startswith(
        "<treelet.Bvh of 20,000 faces: lbvh > treelet(size=7, rounds=2, gamma=14) > bvh8(leaf=8)"
    )
    assert "\n" not in text


@pytest.mark.parametrize("scale", [1e-30, 1e-10, 1e15, 1e30])
def test_extreme_scales(scale):
    vertices, faces = random_triangles(300)
    scaled = (vertices * scale).astype(np.float32)
    bvh = treelet.build(scaled, faces, validate=True)
    targets = scaled[faces].mean(axis=1)
    origins = np.float32([0.5, 0.5, 5]) * np.float32(scale)
    hits = bvh.intersect(origins, (targets - origins) / np.float32(scale))
    assert (hits.face >= 0).all()
    assert bvh.report.sah == pytest.approx(treelet.build(vertices, faces).report.sah, rel=0.01)


def test_the_number_of_rays_chooses_a_preset():
    vertices, faces = grid(20)
    numbers = (0, len(faces) * 10, len(faces) * 60, 1e12)
    chosen = [treelet.build(vertices, faces, rays=rays).report.recipe for rays in numbers]
    assert chosen == [treelet.parse_recipe(preset) for preset in ("fast", "balanced", "better", "best")]


@pytest.mark.parametrize("rays", [-1, float("nan")])
def test_a_bad_number_of_rays_is_refused(rays):
    with pytest.raises(ValueError, match=r"^rays must be a number that is not negative, not "):
        treelet.build(*grid(2), rays=rays)


def test_a_recipe_beside_rays_is_refused():
    with pytest.raises(TypeError, match=r"^build takes a recipe or the number of rays to choose one by"):
        treelet.build(*grid(2), "fast", rays=10)


def test_an_updatable_tree_is_not_chosen_with_pieces():
    bvh = treelet.build(*grid(20), rays=np.inf, updatable=True)
    assert bvh.report.recipe == treelet.parse_recipe("balanced")
    assert treelet.build(*grid(20), rays=np.inf).report.recipe == treelet.parse_recipe("best")


@pytest.mark.parametrize("flag", ["updatable", "validate"])
def test_a_flag_must_be_a_bool(flag):
    with pytest.raises(TypeError, match=rf"^{flag} must be True or False, not str$"):
        treelet.build(*grid(2), **{flag: "no"})
