"""What the program says and does where files, folders, terminals or users are difficult."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys

import numpy as np
import pytest
from command_line import plain_terminal, run_cli

import treelet
from treelet import scenes
from treelet.cli import main

SMALL = ["--triangles", "1000"]
PICTURE = ["--size", "16x10", "--samples", "1"]
ROUNDING = (
    "treelet: warning: rounding the vertices to float32 moves them by up to 0.249, in a mesh of extent 200: "
    "subtract an offset nearer to the mesh from vertices and ray origins first"
)

_plain_terminal = plain_terminal


def write_ball(path, scale=1.0, offset=0.0, dtype=np.float64):
    ball = scenes.load("sphere", triangles=1000)
    vertices = ball.vertices.astype(np.float64) * scale + offset
    np.savez(path, vertices=vertices.astype(dtype), faces=ball.faces)
    return path


@pytest.mark.parametrize(
    "command",
    [
        ["info", "--bvh"],
        ["validate", "--rays", "8"],
        ["render", *PICTURE, "-o", "a.png"],
        ["demo", *PICTURE, "--repeats", "1", "--out", "out"],
        ["bench", "--size", "16x10", "--builds", "1", "--repeats", "1", "--out", "out"],
    ],
)
def test_rounding_is_one_line_of_warning(tmp_path, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    write_ball(tmp_path / "far.npz", 100.0, 5e6)
    lines = run_cli(command[0], "far.npz", *command[1:]).stderr.splitlines()
    assert [line for line in lines if not line.startswith("wrote ")] == [ROUNDING]


def test_a_build_keeps_an_offset_instead_of_rounding(tmp_path):
    write_ball(tmp_path / "far.npz", 100.0, 5e6)
    assert run_cli("build", str(tmp_path / "far.npz")).stderr == ""


@pytest.mark.parametrize("scale", [1e19, 1e37, 3.4e38])
@pytest.mark.parametrize("mode", ["path", "ao", "normals", "depth", "heat"])
def test_huge_meshes_are_drawn_without_warnings(tmp_path, scale, mode):
    mesh, picture = write_ball(tmp_path / "huge.npz", scale, dtype=np.float32), tmp_path / "a.png"
    result = run_cli("render", str(mesh), "-m", mode, "-o", str(picture), "--size", "40x30", "-s", "2")
    assert result.stderr == f"wrote {picture}\n"


@pytest.mark.parametrize("scale", [1e19, 1e37, 3.4e38])
def test_huge_meshes_are_checked_without_warnings(tmp_path, scale):
    mesh = write_ball(tmp_path / "huge.npz", scale, dtype=np.float32)
    verdict = run_cli("validate", str(mesh), "--json")
    assert verdict.stderr == ""
    assert json.loads(verdict.stdout)["passed"] is True


def test_vertex_beyond_float32_is_left_out_and_counted(tmp_path):
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1e300, 0, 0]])
    np.savez(tmp_path / "a.npz", vertices=vertices, faces=[[0, 1, 2], [0, 1, 3]])
    facts = json.loads(run_cli("info", str(tmp_path / "a.npz"), "--bvh", "--json").stdout)
    assert facts["non_finite_faces"] == facts["bvh"]["left_out_non_finite"] == 1


def test_folder_of_scenes_that_is_missing_does_not_matter_to_others(tmp_path, monkeypatch):
    monkeypatch.setenv("TREELET_SCENES", "/nonsense")
    run_cli("info", str(write_ball(tmp_path / "ball.npz")))
    listed = run_cli("list", "scenes", "--json")
    assert [scene["name"] for scene in json.loads(listed.stdout)["scenes"]] == scenes.names()
    assert listed.stderr.startswith(
        "treelet: no external scenes: TREELET_SCENES is '/nonsense', but /nonsense/scenes.json cannot be read"
    )


def test_names_may_hold_brackets(tmp_path, monkeypatch):
    path = write_ball(tmp_path / "a[red]b.npz")
    assert "a[red]b" in run_cli("info", str(path)).stdout
    assert "a[red]b: 990 triangles" in run_cli("build", str(path)).stdout
    (tmp_path / "scenes.json").write_text(json.dumps({"[/b]": {"file": path.name}}))
    monkeypatch.setenv("TREELET_SCENES", str(tmp_path))
    assert re.search(r"^ *\[/b\] +external", run_cli("list", "scenes").stdout, re.MULTILINE)


def test_external_scene_under_an_embedded_name(tmp_path, monkeypatch):
    write_ball(tmp_path / "ball.npz")
    (tmp_path / "scenes.json").write_text(json.dumps({"city": {"file": "ball.npz"}}))
    monkeypatch.setenv("TREELET_SCENES", str(tmp_path))
    listed = run_cli("list", "scenes", "--json")
    assert [scene["name"] for scene in json.loads(listed.stdout)["scenes"]].count("city") == 1
    note = "treelet: external scene 'city' cannot be reached: the embedded one of that name wins\n"
    assert listed.stderr == note


@pytest.mark.parametrize("exposure", ["nan", "-1", "0", "inf"])
def test_exposure_is_a_finite_factor(exposure):
    result = run_cli("render", "sphere", *SMALL, "--exposure", exposure, code=2)
    words = f"treelet: exposure is {float(exposure)}, but it must be finite and above 0\n"
    assert result.stderr == words


def test_eye_out_of_range():
    result = run_cli("render", "sphere", *SMALL, "--eye", "1e300,5,5", "--look-at", "0,0,0", code=2)
    assert result.stderr == "treelet: eye (1e+300, 5.0, 5.0) is out of float32 range\n"


@pytest.mark.parametrize("command", ["build", "info", "validate", "render", "bench", "demo"])
def test_negative_seeds_are_wrong_usage(command):
    mesh = [] if command == "demo" else ["sphere"]
    result = run_cli(command, *mesh, *SMALL, "--seed", "-1", code=2)
    assert "Invalid value for '--seed'" in result.stderr


@pytest.mark.parametrize("columns", [40, 60])
def test_narrow_tables_keep_their_labels(monkeypatch, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    text = run_cli("build", "sphere", *SMALL, "--no-epo").stdout
    assert max(map(len, text.splitlines())) <= columns
    for label in ("recipe", "SAH cost", "triangles a leaf", "left out, not finite", "left out, degenerate"):
        assert re.search(rf"^ *{label} ", text, re.MULTILINE), label


def test_validate_fails_where_nothing_is_left(tmp_path):
    np.savez(tmp_path / "a.npz", vertices=np.full((3, 3), np.nan, np.float32), faces=[[0, 1, 2], [2, 1, 0]])
    result = run_cli("validate", str(tmp_path / "a.npz"), code=1)
    assert "    nothing to trace: all 2 faces were left out of the tree\n" in result.stdout


def test_validate_asks_brute_force_in_parts(monkeypatch):
    asked = []
    right = treelet.intersect_brute_force

    def counted(vertices, faces, origins, directions):
        asked.append(len(origins))
        return right(vertices, faces, origins, directions)

    monkeypatch.setattr(treelet, "intersect_brute_force", counted)
    monkeypatch.setattr("treelet.cli.validate._TESTS_AT_ONCE", 10_000)
    verdict = json.loads(run_cli("validate", "sphere", *SMALL, "--rays", "64", "--json").stdout)
    assert (verdict["rays"], verdict["wrong_rays"]) == (64, [])
    assert sum(asked) == 64
    assert len(asked) > 5


def test_interrupted_command_is_one_line(monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(treelet, "build", interrupted)
    assert run_cli("build", "sphere", *SMALL, code=130).stderr == "interrupted\n"


def test_interrupted_import_is_one_line(monkeypatch, capsys):
    class Interrupting:
        def find_spec(self, name, *_):
            if name == "treelet.cli.app":
                raise KeyboardInterrupt

    monkeypatch.delitem(sys.modules, "treelet.cli.app")
    monkeypatch.setattr(sys, "meta_path", [Interrupting(), *sys.meta_path])
    with pytest.raises(SystemExit) as left:
        main(["--version"])
    assert left.value.code == 130
    assert capsys.readouterr().err == "interrupted\n"


@pytest.mark.skipif(os.name == "nt", reason="signals are those of POSIX")
def test_signal_ends_the_program(tmp_path):
    code = (
        "import os, signal, treelet.bvh, treelet\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"  # ignored below nohup
        "treelet.build = lambda *_, **__: os.kill(os.getpid(), signal.SIGINT)\n"
        "from treelet.cli import main\n"
        "main(['build', 'sphere', '--triangles', '1000'])\n"
    )
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert (answer.returncode, answer.stderr) == (128 + signal.SIGINT, "interrupted\n")
