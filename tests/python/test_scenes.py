"""The embedded scenes, those from a folder, and the one way in."""

import json
import re

import numpy as np
import pytest

from treelet import scenes
from treelet.mesh import Mesh

NAMES = ["hairball", "city", "terrain", "forest", "interior", "menger", "sphere", "soup"]
CLOSED = ["city", "menger", "sphere"]


def hit_share(view, mesh, width=12, height=8):
    """The share of the view's rays that hit, by testing every triangle (Moeller and Trumbore)."""
    forward = np.array(view.direction)
    right = np.cross(forward, view.up)
    right /= np.linalg.norm(right)
    above = np.cross(right, forward)
    slope = np.tan(np.radians(view.fov_degrees) / 2)
    across = ((np.arange(width) + 0.5) / width * 2 - 1) * slope * width / height
    upwards = ((np.arange(height) + 0.5) / height * 2 - 1) * slope
    directions = (forward + across[None, :, None] * right + upwards[:, None, None] * above).reshape(-1, 1, 3)
    corners = mesh.vertices[mesh.faces].astype(np.float64)
    edge_1, edge_2, offset = (
        corners[:, 1] - corners[:, 0],
        corners[:, 2] - corners[:, 0],
        view.eye - corners[:, 0],
    )
    normal_1, normal_2 = np.cross(offset, edge_1), np.cross(directions, edge_2)
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = 1 / (normal_2 * edge_1).sum(axis=-1)
        u = (normal_2 * offset).sum(axis=-1) * scale
        v = (directions * normal_1).sum(axis=-1) * scale
        t = (edge_2 * normal_1).sum(axis=-1) * scale
        return ((u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0)).any(axis=1).mean()


def test_names_and_descriptions():
    assert scenes.names() == NAMES
    for name in NAMES:
        description = scenes.describe(name)
        assert 20 < len(description) < 110
        assert "\n" not in description


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("count", [1000, 1234, 1800, 2500, 5000, 20_000, 100_000])
def test_count_is_near_the_one_asked_for(name, count):
    mesh = scenes.make(name, count)
    assert len(mesh.faces) == pytest.approx(count, rel=0.07 if count < 5000 else 0.04)
    assert mesh.vertices.dtype == np.float32
    assert mesh.faces.dtype == np.int32
    assert np.isfinite(mesh.vertices).all()
    assert mesh.faces.min() == 0
    assert mesh.faces.max() == len(mesh.vertices) - 1
    assert mesh.name == name


def test_soup_is_exact():
    assert len(scenes.make("soup", 12_345).faces) == 12_345


def test_hairball_follows_its_recipe():
    mesh = scenes.make("hairball", 2_880_000)
    assert len(mesh.faces) == 2000 * 120 * 6 * 2
    rings = mesh.vertices.reshape(2000, 121, 6, 3)
    radii = np.linalg.norm(rings - rings.mean(axis=2, keepdims=True), axis=-1).mean(axis=2)
    np.testing.assert_allclose(radii[:, -1] / radii[:, 0], 0.3, rtol=1e-3)
    assert np.linalg.norm(mesh.vertices, axis=1).max() < 1.25


@pytest.mark.parametrize("name", NAMES)
def test_seed_decides_the_bytes(name):
    first, again, other = (scenes.make(name, 3000, seed) for seed in (1, 1, 2))
    assert first.vertices.tobytes() == again.vertices.tobytes()
    assert first.faces.tobytes() == again.faces.tobytes()
    if name not in ("menger", "sphere"):
        assert first.vertices.tobytes() != other.vertices.tobytes()


@pytest.mark.parametrize("name", CLOSED)
@pytest.mark.parametrize("count", [1000, 10_000])
def test_closed_scenes_have_every_edge_once_each_way(name, count):
    faces = scenes.make(name, count).faces.astype(np.int64)
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    forwards = np.sort(edges[:, 0] << 32 | edges[:, 1])
    backwards = np.sort(edges[:, 1] << 32 | edges[:, 0])
    np.testing.assert_array_equal(forwards, backwards)


@pytest.mark.parametrize("name", CLOSED)
def test_closed_scenes_face_outwards(name):
    mesh = scenes.make(name, 2000)
    corners = mesh.vertices[mesh.faces].astype(np.float64)
    corners -= corners.mean(axis=(0, 1))
    volume = (corners[:, 0] * np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    assert volume > 0


def test_sphere_is_round():
    np.testing.assert_allclose(np.linalg.norm(scenes.make("sphere", 5000).vertices, axis=1), 1, rtol=1e-6)


def test_menger_at_full_width_is_the_sponge():
    mesh = scenes.make("menger", 2 * 1056)  # level 2 has 2 x 20^2 + 4 x 8^2 faces
    assert len(mesh.faces) == 2 * 1056
    np.testing.assert_array_equal(mesh.bounds, [[0, 0, 0], [1, 1, 1]])


@pytest.mark.parametrize("name", ["terrain", "forest"])
def test_ground_is_seen_from_above(name):
    mesh = scenes.make(name, 2000)
    first = mesh.vertices[mesh.faces[:50]]
    assert (np.cross(first[:, 1] - first[:, 0], first[:, 2] - first[:, 0])[:, 2] > 0).all()


def test_interior_triangles_are_long_and_thin():
    mesh = scenes.make("interior", 20_000)
    corners = mesh.vertices[mesh.faces]
    lengths = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    heights = (
        np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        / lengths
    )
    assert np.median(lengths / heights) > 20


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("seed", [0, 7])
def test_views_see_the_scene(name, seed):
    mesh = scenes.make(name, 4000, seed)
    assert 2 <= len(mesh.views) <= 4
    assert len({view.name for view in mesh.views}) == len(mesh.views)
    for view in mesh.views:
        assert hit_share(view, mesh) > 0.12, view
        reach = np.linalg.norm(np.subtract(view.look_at, mesh.bounds.mean(axis=0)))
        assert reach < np.linalg.norm(mesh.bounds[1] - mesh.bounds[0])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("cyti",), f"unknown scene 'cyti'; did you mean 'city'? known are {', '.join(NAMES)}"),
        (("x",), f"unknown scene 'x'; known are {', '.join(NAMES)}"),
        (("city", 999), "triangles must be from 1000 to 50000000, not 999"),
        (("city", 50_000_001), "triangles must be from 1000 to 50000000, not 50000001"),
        (("city", 1000, -1), "seed must not be negative, but is -1"),
    ],
)
def test_make_rejects(arguments, message):
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        scenes.make(*arguments)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with one external scene, named by TREELET_SCENES."""
    np.savez(tmp_path / "kite.npz", vertices=np.eye(3), faces=[[0, 1, 2]])
    camera = {"name": "front", "eye": [2, 2, 2], "look_at": [0, 0, 0], "up": [0, 1, 0], "vfov_deg": 33.0}
    index = {
        "_readme": "words",
        "_more": {"file": "x"},
        "paper_kite": {"file": "kite.npz", "cameras": [camera]},
    }
    (tmp_path / "scenes.json").write_text(json.dumps(index))
    monkeypatch.setenv("TREELET_SCENES", str(tmp_path))
    return tmp_path


@pytest.fixture
def no_folder(monkeypatch):
    monkeypatch.delenv("TREELET_SCENES", raising=False)


def test_external_scene_has_its_cameras(folder):
    assert scenes.external_names() == ["paper_kite"]
    mesh = scenes.load("paper_kite")
    assert mesh.name == "paper_kite"
    assert len(mesh.faces) == 1
    (view,) = mesh.views
    assert (view.name, view.eye, view.up, view.fov_degrees) == ("front", (2, 2, 2), (0, 1, 0), 33.0)


@pytest.mark.usefixtures("no_folder")
def test_no_external_scenes_without_the_variable():
    assert scenes.external_names() == []
    with pytest.raises(
        ValueError, match=r"^scene 'kite' is not embedded, and TREELET_SCENES names no folder of scenes$"
    ):
        scenes.load_external("kite")


def test_unknown_external_scene(folder):
    message = f"unknown scene 'kite' in {folder}; did you mean 'paper_kite'? known are paper_kite"
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        scenes.load_external("kite")


@pytest.mark.parametrize("content", [None, "{", "[]"])
def test_damaged_index_of_external_scenes(tmp_path, monkeypatch, content):
    monkeypatch.setenv("TREELET_SCENES", str(tmp_path))
    if content is not None:
        (tmp_path / "scenes.json").write_text(content)
    with pytest.raises(ValueError, match=re.escape(str(tmp_path / "scenes.json"))):
        scenes.external_names()


@pytest.mark.parametrize(
    ("index", "reason"),
    [
        ({"a": 3}, "scene 'a' must be an object with a file, not 3"),
        ({"a": {"file": 3}}, "scene 'a' must have a text as its file, not 3"),
        (
            {"a": {"file": "kite.npz", "cameras": [7]}},
            "scene 'a' must have a list of objects as its cameras, not [7]",
        ),
        ({"a": {"file": "kite.npz", "cameras": [{"eye": [0, 0, 1]}]}}, "scene 'a': camera 0 has no look_at"),
        (
            {"a": {"file": "kite.npz", "cameras": [{"eye": [0, 1], "look_at": [0, 0, 0]}]}},
            "scene 'a': camera 0: eye must be three finite numbers, not [0, 1]",
        ),
    ],
)
def test_index_of_external_scenes_names_the_bad_entry(folder, index, reason):
    (folder / "scenes.json").write_text(json.dumps(index))
    with pytest.raises(ValueError, match=f"^{re.escape(str(folder / 'scenes.json'))}: {re.escape(reason)}$"):
        scenes.load("a")


def test_embedded_scenes_and_files_come_before_the_folder(folder, monkeypatch):
    (folder / "scenes.json").write_text(json.dumps({"sphere": {"file": "kite.npz"}}))
    assert len(scenes.load("sphere", 1000).faces) > 1
    monkeypatch.setenv("TREELET_SCENES", "/nonsense")
    assert len(scenes.load("sphere", 1000).faces) > 1
    assert scenes.load(folder / "kite.npz").name == "kite"


def test_negative_seeds_are_refused_for_files_too(folder):
    for name in ("sphere", str(folder / "kite.npz")):
        with pytest.raises(ValueError, match=r"^seed must not be negative, but is -1$"):
            scenes.load(name, seed=-1)


@pytest.mark.usefixtures("no_folder")
def test_load_takes_names_and_paths(tmp_path):
    assert isinstance(scenes.load("sphere", 2000), Mesh)
    assert len(scenes.load("sphere").faces) == pytest.approx(100_000, rel=0.02)
    np.savez(tmp_path / "kite.npz", vertices=np.eye(3), faces=[[0, 1, 2]])
    assert scenes.load(tmp_path / "kite.npz").name == "kite"
    with pytest.raises(
        ValueError, match=r"is a mesh file with its own triangles; only embedded scenes take a count$"
    ):
        scenes.load(tmp_path / "kite.npz", 1000)
    with pytest.raises(FileNotFoundError, match=r"there is no such mesh file$"):
        scenes.load("nowhere.ply")


@pytest.mark.usefixtures("no_folder")
def test_load_of_an_unknown_name():
    message = (
        f"'hairbal' is neither a scene nor a mesh file; did you mean 'hairball'? known are {', '.join(NAMES)}"
        " (the variable TREELET_SCENES could name a folder with more)"
    )
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        scenes.load("hairbal")
