"""Trees in files and pickles: the same tree comes back, or an error says what is wrong with the file."""

import copy
import errno
import multiprocessing
import os
import pickle
import subprocess
import sys

import numpy as np
import pytest
from sample_meshes import TRIANGLE_FACES, TRIANGLE_VERTICES, random_triangles
from sample_rays import as_bytes, mixed_rays

import treelet
from treelet.mesh import Mesh

RECIPES = ["lbvh > bvh2", "balanced", "better", "best", "lbvh > treelet > cwbvh", "presplit > lbvh > bvh8"]


@pytest.fixture(scope="module")
def mesh():
    return Mesh(*random_triangles(3000, seed=8))


@pytest.fixture(scope="module")
def rays(mesh):
    return mixed_rays(mesh, 500, seed=2)


@pytest.fixture
def saved(mesh, tmp_path):
    treelet.build(mesh.vertices, mesh.faces).save(tmp_path / "a.treelet")
    return tmp_path / "a.treelet"


def report_of(bvh):
    return bvh.report.as_dict()


def assert_same_tree(loaded, bvh, rays):
    assert report_of(loaded) == report_of(bvh)
    assert as_bytes(loaded.intersect(*rays)) == as_bytes(bvh.intersect(*rays))
    assert as_bytes(loaded.traversal_cost(*rays)) == as_bytes(bvh.traversal_cost(*rays))
    np.testing.assert_array_equal(loaded.bounds, bvh.bounds)
    assert loaded.mesh_hash == bvh.mesh_hash


@pytest.mark.parametrize("recipe", RECIPES)
@pytest.mark.parametrize("mmap", [True, False])
def test_a_loaded_tree_is_the_saved_one(mesh, rays, tmp_path, recipe, mmap):
    bvh = treelet.build(mesh.vertices, mesh.faces, recipe)
    bvh.save(tmp_path / "a.treelet")
    loaded = treelet.load(tmp_path / "a.treelet", mmap, verify=True)
    assert_same_tree(loaded, bvh, rays)
    assert loaded.validate(mesh.vertices, mesh.faces) == []


@pytest.mark.parametrize("recipe", RECIPES)
@pytest.mark.parametrize("protocol", range(2, pickle.HIGHEST_PROTOCOL + 1))
def test_a_tree_can_be_pickled(mesh, rays, recipe, protocol):
    bvh = treelet.build(mesh.vertices, mesh.faces, recipe)
    assert_same_tree(pickle.loads(pickle.dumps(bvh, protocol)), bvh, rays)


def test_an_empty_tree_can_be_saved(tmp_path):
    bvh = treelet.build(np.zeros((0, 3)), [])
    bvh.save(tmp_path / "a.treelet")
    assert treelet.load(tmp_path / "a.treelet").intersect([0, 0, 0], [0, 0, 1]).face == -1
    assert pickle.loads(pickle.dumps(bvh)).face_count == 0


def test_paths_are_text_or_paths(mesh, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    bvh = treelet.build(mesh.vertices, mesh.faces)
    bvh.save("Bäume und Äste.treelet")
    assert treelet.load("Bäume und Äste.treelet").face_count == len(mesh.faces)
    assert [path.name for path in tmp_path.iterdir()] == ["Bäume und Äste.treelet"]


def test_copies_of_an_immutable_tree_are_the_tree(mesh):
    bvh = treelet.build(mesh.vertices, mesh.faces)
    assert copy.copy(bvh) is bvh
    assert copy.deepcopy({"tree": bvh})["tree"] is bvh


def test_updatable_trees_are_saved_as_they_are_now(mesh, rays, tmp_path):
    bvh = treelet.build(mesh.vertices, mesh.faces, updatable=True)
    bvh.refit(mesh.vertices * np.float32(1.5))
    bvh.save(tmp_path / "a.treelet")
    before = as_bytes(bvh.intersect(*rays))
    frozen = [treelet.load(tmp_path / "a.treelet"), copy.copy(bvh), copy.deepcopy(bvh)]
    bvh.refit(mesh.vertices)
    assert as_bytes(bvh.intersect(*rays)) != before
    for tree in frozen:
        assert as_bytes(tree.intersect(*rays)) == before
        assert (tree.report.refits, tree.report.held_bytes) == (1, 0)
        with pytest.raises(RuntimeError, match="cannot be updated"):
            tree.refit(mesh.vertices)


def test_a_tree_outlives_its_file(mesh, rays, saved):
    expected = as_bytes(treelet.build(mesh.vertices, mesh.faces).intersect(*rays))
    bvh = treelet.load(saved)
    treelet.build(mesh.vertices * 2, mesh.faces).save(saved)
    assert as_bytes(bvh.intersect(*rays)) == expected
    if sys.platform != "win32":
        saved.unlink()
        assert as_bytes(bvh.intersect(*rays)) == expected


def trace_file(path, origins, directions):
    return as_bytes(treelet.load(path).intersect(origins, directions))


def trace_tree(bvh, origins, directions):
    return as_bytes(bvh.intersect(origins, directions))


def test_other_processes_load_and_unpickle(saved, rays):
    bvh = treelet.load(saved)
    expected = as_bytes(bvh.intersect(*rays))
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        assert pool.starmap(trace_file, [(saved, *rays)] * 2) == [expected] * 2
        assert pool.apply(trace_tree, (bvh, *rays)) == expected


def test_mesh_hash_is_the_mesh_s_for_every_recipe(mesh):
    expected = treelet.mesh_hash(mesh.vertices, mesh.faces)
    assert len(expected) == 16
    assert {treelet.build(mesh.vertices, mesh.faces, recipe).mesh_hash for recipe in RECIPES} == {expected}
    assert treelet.mesh_hash(mesh.vertices.astype(np.float64), mesh.faces) == expected
    assert treelet.mesh_hash(mesh.vertices, mesh.faces[:-1]) != expected
    assert treelet.mesh_hash(mesh.vertices, np.roll(mesh.faces, 1, axis=1)) != expected


# Refused


def refuse(path, data, words):
    path.write_bytes(data)
    for mmap in (True, False):
        with pytest.raises(treelet.FileError, match=words) as error:
            treelet.load(path, mmap=mmap)
        assert str(error.value).startswith(f"{path}: ")
    assert issubclass(treelet.FileError, ValueError)


def test_files_that_are_no_trees(saved):
    data = saved.read_bytes()
    refuse(saved, b"ply\nformat ascii 1.0\n", "holds no treelet tree: meshes are read by load_mesh")
    refuse(saved, b"", "is cut off: it has 0 bytes")
    refuse(saved, data[:-1], f"is cut off: it has {len(data) - 1} bytes of {len(data)}: copy the file again")
    refuse(saved, data + bytes(64), "do not belong to the tree")
    refuse(saved, data[:12] + b"\2" + data[13:], "has format version 2, this treelet reads version 1: update")
    refuse(saved, data[:8] + data[8:12][::-1] + data[12:], "is big-endian")
    refuse(saved, data[:40] + b"\1" + data[41:], "header, bytes 0 to 168, is damaged")


def test_damage_is_found_when_asked_for(saved):
    data = bytearray(saved.read_bytes())
    data[-100] ^= 1
    saved.write_bytes(data)
    treelet.load(saved)
    with pytest.raises(treelet.FileError, match=r"the triangles, bytes \d+ to \d+, are damaged"):
        treelet.load(saved, verify=True)


def test_damaged_pickles_are_refused(mesh):
    from treelet._load import from_bytes

    data = bytearray(treelet.build(mesh.vertices, mesh.faces).__reduce__()[1][0])
    data[-100] ^= 1
    with pytest.raises(treelet.FileError, match="are damaged"):
        from_bytes(bytes(data))


def test_random_damage_never_crashes(saved):
    """In a process of its own, which would not survive; C++ tests go into more depth."""
    code = f"""
import numpy as np, treelet
path = {str(saved)!r}
data, seed = np.fromfile(path, np.uint8), 1
rng = np.random.default_rng(seed)
rays = rng.random((50, 3)), rng.standard_normal((50, 3))
loaded = 0
for _ in range(300):
    damaged = data.copy()
    damaged[rng.integers(200, len(data), 3)] = rng.integers(0, 256, 3)
    damaged.tofile(path)
    try:
        bvh = treelet.load(path)
    except treelet.FileError:
        continue
    bvh.intersect(*rays)
    bvh.validate()
    del bvh
    loaded += 1
print(loaded)
"""
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60
    )
    assert 0 < int(result.stdout) < 300


@pytest.mark.parametrize("use", [treelet.load, treelet.build([[0, 0, 0]], []).save])
def test_the_system_s_errors_name_the_file(tmp_path, use):
    missing = tmp_path / "missing" / "a.treelet"
    with pytest.raises(FileNotFoundError) as error:
        use(missing)
    assert (error.value.errno, error.value.filename) == (errno.ENOENT, os.fspath(missing))
    with pytest.raises(IsADirectoryError):
        use(tmp_path)
    with pytest.raises(TypeError):
        use(3)


def test_flags_are_flags(saved):
    with pytest.raises(TypeError, match="mmap must be True or False, not str"):
        treelet.load(saved, "r")
    with pytest.raises(TypeError, match="verify must be True or False, not int"):
        treelet.load(saved, verify=1)


def test_a_name_with_a_null_character_is_refused(tmp_path):
    bvh = treelet.build(TRIANGLE_VERTICES, TRIANGLE_FACES)
    for use in (bvh.save, treelet.load):
        with pytest.raises(ValueError, match=r"path must be the name of a file, and .*a\\x00b' holds a null"):
            use(tmp_path / "a\0b")
