"""What bench/peers and its table do beside measuring: scene files, packets, adapters, ratios."""

import json
import sys

import numpy as np
import pytest
from loaded_tools import ROOT, load_tool

from treelet import scenes

sys.path.insert(0, str(ROOT / "bench" / "peers"))

import python_peers
import python_queries
import run
from make_scene import make_scene_file, order_by_tiles
from scene_file import RaySet, SceneFile, read_scene_file, write_scene_file

peers_table = load_tool("peers_table")

# The same file is read by tests/peers/scene_file_test.cpp.
SAVED_SCENE = ROOT / "tests" / "peers" / "two_triangles.scene"


def two_triangles() -> SceneFile:
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
    origins = np.array([[0.25, 0.125, 1], [0.125, 0.25, 1], [2, 2, 1]], np.float32)
    down = np.tile(np.array([0, 0, -1], np.float32), (3, 1))
    sets = [
        RaySet("primary", False, origins, down, np.full(3, np.inf, np.float32)),
        RaySet("ambient_occlusion", True, origins[:2], down[:2], np.array([2, 0.5], np.float32)),
    ]
    return SceneFile(corners, np.array([[0, 1, 2], [0, 2, 3]], np.uint32), sets)


class TestSceneFile:
    def test_writes_the_bytes_that_the_harness_reads(self, tmp_path):
        write_scene_file(tmp_path / "scene", two_triangles())
        assert (tmp_path / "scene").read_bytes() == SAVED_SCENE.read_bytes()

    def test_reads_what_it_wrote(self, tmp_path):
        scene = scenes.make("terrain", 1000)
        written = make_scene_file(tmp_path / "scene", scene, width=17, height=9)
        again = read_scene_file(tmp_path / "scene")
        np.testing.assert_array_equal(again.vertices, scene.vertices)
        np.testing.assert_array_equal(again.faces, scene.faces)
        assert [rays.kind for rays in again.ray_sets] == ["primary", "diffuse", "ambient_occlusion"]
        assert [rays.any_hit for rays in again.ray_sets] == [False, False, True]
        for ours, theirs in zip(again.ray_sets, written.ray_sets, strict=True):
            for part in ("origins", "directions", "t_max"):
                np.testing.assert_array_equal(getattr(ours, part), getattr(theirs, part))

    @pytest.mark.parametrize("length", [4, 30, 100, 300])
    def test_refuses_a_file_that_ends_early(self, tmp_path, length):
        (tmp_path / "scene").write_bytes(SAVED_SCENE.read_bytes()[:length])
        with pytest.raises(ValueError, match="scene"):
            read_scene_file(tmp_path / "scene")

    def test_refuses_a_kind_without_room(self, tmp_path):
        none = np.zeros((0, 3), np.float32)
        rays = RaySet("k" * 25, False, none, none, none[:, 0])
        with pytest.raises(ValueError, match="24 bytes"):
            write_scene_file(tmp_path / "scene", SceneFile(none, none, [rays]))


@pytest.mark.parametrize(("width", "height"), [(8, 8), (7, 5), (1, 3)])
def test_tiles_take_every_pixel_once(width, height):
    order = order_by_tiles(width, height)
    np.testing.assert_array_equal(np.sort(order), np.arange(width * height))


def test_sixteen_rays_in_a_row_are_neighbours():
    y, x = np.divmod(order_by_tiles(64, 32).reshape(-1, 16), 64)
    assert (np.ptp(x, axis=1) == 3).all()
    assert (np.ptp(y, axis=1) == 3).all()


def test_answers_of_the_harness_become_measurements():
    line = {
        "kind": "primary",
        "label": "fast",
        "recipe": "lbvh",
        "rays": 9,
        "threads": 2,
        "samples": [1.0, 3.0],
    }
    [measurement] = run.read_answer(json.dumps(line | {"details": {"differing": 0}}), "city", 12)
    assert (measurement.scene, measurement.faces, measurement.rays_per_second) == ("city", 12, 4.5)
    assert measurement.machine["cores"] >= 1


def test_a_harness_that_is_not_there_is_an_error(tmp_path, capsys):
    for harness in (tmp_path / "missing", tmp_path):
        with pytest.raises(SystemExit, match="2"):
            run.main(["sphere", f"--harness={harness}", f"--out={tmp_path}"])
        assert f"--harness {harness} is no program" in capsys.readouterr().err


@pytest.mark.skipif(sys.platform == "win32", reason="the stand-in harness is a shell script")
def test_a_harness_that_fails_ends_the_race_with_its_words(tmp_path):
    harness = tmp_path / "harness"
    harness.write_text("#!/bin/sh\necho 'no such recipe' >&2\nexit 2\n")
    harness.chmod(0o755)
    words = ["sphere", "--triangles=1000", "--width=16", "--height=16", f"--harness={harness}"]
    with pytest.raises(SystemExit, match="no such recipe"):
        run.main([*words, f"--out={tmp_path}"])


def record(label: str, kind: str, seconds: float, **details) -> dict:
    samples = [seconds, seconds / 2, seconds * 9]
    return {"scene": "s", "faces": 10, "label": label, "kind": kind, "samples": samples, "details": details}


def sample_records(scale: float = 1.0) -> list[dict]:
    kinds = ("primary", "diffuse", "ambient_occlusion")
    times = {"fast": 4.0, "balanced": 2.0, "Embree LOW": 2.0, "Embree HIGH": 1.0 * scale}
    records = [record(label, "build", time, bytes=100 * time) for label, time in times.items()]
    records += [record(label, kind, time) for label, time in times.items() for kind in kinds]
    return [*records, record("Embree HIGH packets", "primary", 0.5)]


class TestTable:
    def test_compares_medians_with_the_right_embree(self):
        scene = peers_table.Scene(sample_records())
        values = {column.heading: column.of(scene) for column in peers_table.goal_columns("fast", "balanced")}
        assert values == {
            "fast: build / LOW": 0.5,
            "fast: diffuse / LOW": 0.5,
            "build / LOW": 1.0,
            "diffuse / HIGH": 0.5,
            "any hit / HIGH": 0.5,
            "primary / HIGH": 0.5,
            "primary / packets": 0.25,
            "B/triangle": 20.0,
            "of HIGH": 10.0,
        }

    def test_means_leave_long_thin_scenes_out(self):
        ordinary, clinic = peers_table.Scene(sample_records()), peers_table.Scene(sample_records(4.0))
        clinic.name = "clinic"
        heading, _, _, means, others = peers_table.goal_table([ordinary, clinic], "fast", "balanced")
        column = heading.index("diffuse / HIGH")
        assert (means[column], others[column]) == ("1.00", "0.50")

    def test_what_was_not_measured_is_a_dash(self):
        records = [each for each in sample_records() if each["kind"] != "diffuse"]
        rows = peers_table.contender_table([peers_table.Scene(records)])
        assert rows[0][3:5] == ["diffuse / LOW", "diffuse / HIGH"]
        assert [row[3:5] for row in rows[1:]] == [["–", "–"]] * 4

    def test_shows_the_work_of_those_who_count(self):
        records = sample_records()
        counted = next(each for each in records if (each["label"], each["kind"]) == ("fast", "diffuse"))
        counted["details"] = {"nodes_per_ray": 3.0, "triangles_per_ray": 5.0}
        heading, *rows = peers_table.contender_table([peers_table.Scene(records)])
        column = heading.index("nodes/ray")
        assert {row[0]: row[column : column + 2] for row in rows} == {
            "fast": ["3.00", "5.00"],
            "balanced": ["–", "–"],
            "Embree LOW": ["–", "–"],
            "Embree HIGH": ["–", "–"],
        }

    def test_reads_the_files_that_have_both_embrees(self, tmp_path, capsys):
        for name, labels in (("both", ("LOW", "HIGH")), ("one", ("LOW",))):
            lines = [json.dumps(record(f"Embree {label}", "build", 1.0)) for label in labels]
            (tmp_path / f"{name}.jsonl").write_text("\n".join(lines) + "\n")
        assert len(peers_table.read_scenes(tmp_path, {"Embree LOW", "Embree HIGH"})) == 1
        peers_table.main([str(tmp_path)])
        assert "| Embree LOW | 1.00 |" in capsys.readouterr().out

    def test_holds_trees_against_each_other(self, tmp_path, capsys):
        ours, theirs = peers_table.OUR_TREE, peers_table.THEIR_TREE
        work = {"nodes_per_ray": 4.0, "triangles_per_ray": 2.0, "unequal": 0.0}
        records = [record(ours, "build", 1.0, sah=10.0), record(theirs, "build", 3.0, sah=5.0)]
        records += [record(ours, "diffuse", 1.0, **work)]
        records += [record(theirs, "diffuse", 2.0, **work | {"nodes_per_ray": 2.0, "unequal": 0.25})]
        records = [each | {"rays": 4} for each in records]
        heading, row, _ = peers_table.tree_table([peers_table.Scene(records)], ours, theirs)
        values = dict(zip(heading, row, strict=True))
        assert (values["SAH"], values["build time"], values["layout SAH"]) == ("0.50", "3.00", "–")
        assert (values["diffuse nodes"], values["diffuse triangles"]) == ("0.50", "1.00")
        assert (values["diffuse time"], values["primary time"]) == ("2.00", "–")
        assert values["unequal rays"] == "1.00"
        (tmp_path / "s.jsonl").write_text("\n".join(map(json.dumps, records)) + "\n")
        peers_table.main([str(tmp_path)])
        assert f"{theirs} over {ours}" in capsys.readouterr().out

    def test_says_what_is_missing(self, tmp_path, capsys):
        with pytest.raises(SystemExit, match="2"):
            peers_table.main([str(tmp_path)])
        assert "no measurements of Embree LOW and Embree HIGH" in capsys.readouterr().err


def test_adapters_give_the_same_hits(tmp_path):
    """Of those whose packages are installed; the others say why they are not."""
    adapters = python_peers.load_adapters()
    assert next(iter(adapters.ready)) == "treelet"
    assert all(adapters.missing.values())
    scene = make_scene_file(tmp_path / "scene", scenes.make("city", 2000), width=40, height=30)
    entrants = python_peers.race(scene, adapters.ready, rounds=1)
    for entrant in entrants.values():
        assert set(entrant.differing) == {"primary", "diffuse"}
        assert max(entrant.differing.values()) < 0.01
    records = python_peers.measurements("city", scene, entrants)
    assert len(records) == 3 * len(entrants)


def test_answers_that_differ_are_counted():
    expected, actual = np.array([1, 2, np.inf, np.inf]), np.array([1.00001, 2.001, np.inf, 3])
    assert python_peers.share_of_differences(expected, actual) == 0.5


class TestQueryRace:
    def test_times_every_query_and_compares_answers(self, monkeypatch):
        def ask_false(vertices, faces):
            return {
                "counts": lambda origins, directions: np.full(len(origins), 99),
                "closest_point": lambda points: points[:, 0],
            }

        ours = python_queries.CONTENDERS["treelet"]
        contenders = {"treelet": ours, "again": ours, "false": ask_false}
        monkeypatch.setattr(python_queries, "CONTENDERS", contenders)
        monkeypatch.setitem(python_queries.SLOWER, ("again", "counts"), 4)
        mesh = scenes.make("sphere", 1000)
        timings = python_queries.race(mesh, python_queries.make_inputs(mesh, 40, 30), rounds=2)
        records = python_queries.measurements("sphere", len(mesh.faces), timings)
        assert {record.kind for record in records} == set(python_queries.QUERIES)
        assert all(len(record.samples) == 2 for record in records)
        assert timings["counts"]["again"].items == 10
        assert timings["signed_distance"]["treelet"].items == 30
        assert all(query["again"].differing == query["again"].other_sign == 0 for query in timings.values())
        assert timings["counts"]["false"].differing == 1
        assert timings["closest_point"]["false"].differing > 0.5

    def test_skips_what_is_not_installed(self, monkeypatch, capsys):
        def ask_nothing(vertices, faces):
            raise ImportError("no such package")

        monkeypatch.setattr(python_queries, "CONTENDERS", {"other": ask_nothing})
        assert python_queries.load_contenders(scenes.make("sphere", 1000)) == {}
        assert "skipped other: ImportError: no such package" in capsys.readouterr().err
