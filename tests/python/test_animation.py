"""The comparison of refit and rebuild, and the example that uses both."""

import json
import runpy
from pathlib import Path

import numpy as np
import pytest

from treelet import scenes
from treelet.bench import animation, read_measurements
from treelet.bench.animation import WAYS, Plan, find_animations, load_animation, measure, waving_terrain

EXAMPLE = Path(__file__).parents[2] / "examples" / "animate.py"
PLAN = Plan(width=32, height=20, repeats=2)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder of scenes with one animation of three frames."""
    mesh = scenes.make("sphere", 1000)
    frames = np.stack([mesh.vertices * np.float32(1 + 0.2 * k) for k in range(3)])
    np.savez(tmp_path / "ball_anim.npz", faces=mesh.faces, vertices=frames, times=np.arange(3))
    (tmp_path / "scenes.json").write_text("{}")
    monkeypatch.setenv("TREELET_SCENES", str(tmp_path))
    return tmp_path


def test_every_way_is_measured_in_every_frame():
    waves = waving_terrain(2000, 3)
    records = list(measure(waves, PLAN))
    keys = [(each.details["frame"], each.label, each.kind) for each in records]
    assert keys == [
        (frame, way.label, kind) for frame in (1, 2) for way in WAYS for kind in (way.action, "diffuse")
    ]
    for record in records:
        assert len(record.samples) == 2
        assert record.faces == len(waves.faces)
        assert record.scene == "waving_terrain"
        if record.kind == "diffuse":
            assert record.rays > 100
            assert record.details["nodes_per_ray"] > 1
            assert record.details["triangles_per_ray"] > 1
        else:
            assert record.rays == record.details["hidden"] == 0
            assert record.details["layout_sah"] > 1
    rays = {(each.details["frame"], each.rays) for each in records if each.kind == "diffuse"}
    assert len(rays) == 2  # all ways trace the same


def test_a_rebuild_has_the_cost_of_its_build_and_a_refit_another():
    for record in measure(waving_terrain(2000, 2), PLAN):
        if record.kind != "diffuse":
            same = record.details["layout_sah"] == record.details["layout_sah_at_build"]
            assert same == (record.kind == "rebuild")


def test_terrain_waves_and_keeps_its_faces():
    waves = waving_terrain(2000, 4)
    still = scenes.make("terrain", 2000)
    np.testing.assert_array_equal(waves.frames[0], still.vertices)
    np.testing.assert_array_equal(waves.faces, still.faces)
    steps = [np.abs(b - a).max() for a, b in zip(waves.frames, waves.frames[1:], strict=False)]
    assert min(steps) > 0.05


def test_animations_are_found(folder, monkeypatch):
    assert [each.name for each in find_animations([], 2000, 2)] == ["waving_terrain", "ball"]
    [ball] = find_animations(["ball"], 2000, 2)
    assert ball.frames.shape[0] == 3
    assert ball.mesh(2).bounds[1].max() == pytest.approx(1.4 * ball.mesh(0).bounds[1].max())
    with pytest.raises(FileNotFoundError):
        list(find_animations(["bowl"], 2000, 2))
    monkeypatch.delenv("TREELET_SCENES")
    assert [each.name for each in find_animations([], 2000, 2)] == ["waving_terrain"]


def test_a_mesh_that_does_not_move_is_refused(tmp_path):
    mesh = scenes.make("sphere", 1000)
    np.savez(tmp_path / "still_anim.npz", faces=mesh.faces, vertices=mesh.vertices)
    with pytest.raises(ValueError, match="two frames at least"):
        load_animation(tmp_path / "still_anim.npz")


@pytest.mark.parametrize(
    ("arrays", "what"),
    [
        ({}, "numeric arrays `faces` and `vertices`"),
        ({"faces": [[0, 1, 2]]}, "numeric arrays"),
        ({"faces": [[0, 1, 2]], "vertices": [[["x"] * 3] * 3] * 2}, "numeric arrays"),
        ({"faces": [[0, 1, 2]], "vertices": np.zeros((2, 3, 2))}, "two frames at least"),
        ({"faces": [[0, 1, 2.5]], "vertices": np.zeros((2, 3, 3))}, "integers of shape"),
        ({"faces": [0, 1, 2], "vertices": np.zeros((2, 3, 3))}, "integers of shape"),
        ({"faces": [[0, 1, 3]], "vertices": np.zeros((2, 3, 3))}, "indices of the 3 vertices"),
    ],
)
def test_a_file_that_is_no_animation_is_refused(tmp_path, arrays, what):
    np.savez(tmp_path / "bad_anim.npz", **arrays)
    with pytest.raises(ValueError, match=what):
        load_animation(tmp_path / "bad_anim.npz")


def test_a_file_that_is_no_archive_is_refused(tmp_path):
    for content in (b"", b"not a zip file", b"PK\x03\x04 cut short"):
        (tmp_path / "bad_anim.npz").write_bytes(content)
        with pytest.raises(ValueError, match="numeric arrays"):
            load_animation(tmp_path / "bad_anim.npz")


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        (["bowl"], "no animation 'bowl'"),
        (["--triangles", "7"], "'7' is not a whole number from 1000 to 50000000"),
        (["--frames", "1"], "'1' is not a whole number of at least 2"),
        (["--repeats", "0"], "'0' is not a whole number of at least 1"),
        (["--width", "wide"], "'wide' is not a whole number"),
        (["ball", "--output", "no/such/folder/x.jsonl"], "cannot write no/such/folder/x.jsonl: No such"),
    ],
)
def test_bad_arguments_end_with_a_sentence(folder, capsys, arguments, what):
    with pytest.raises(SystemExit) as end:
        animation.main(arguments)
    assert end.value.code == 2
    assert what in capsys.readouterr().err.splitlines()[-1]


def test_the_command_writes_measurements(folder, tmp_path, capsys):
    small = ["ball", "--width", "32", "--height", "20", "--repeats", "1"]
    animation.main([*small, "--output", str(tmp_path / "out.jsonl")])
    records = read_measurements(tmp_path / "out.jsonl")
    assert len(records) == 2 * len(WAYS) * 2
    assert capsys.readouterr().out == ""
    animation.main(small)
    lines = capsys.readouterr().out.splitlines()
    assert [json.loads(line)["label"] for line in lines] == [record.label for record in records]


def test_the_example_refits_and_rebuilds(capsys):
    script = runpy.run_path(str(EXAMPLE))
    script["main"].__globals__.update(CELLS=20, FRAMES=12, RAYS=100)
    script["main"]()
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "800 triangles, 100 rays a frame"
    assert {line.split()[2] for line in lines[1:]} == {"refit", "rebuild"}
    assert len(lines) == 13
