"""Commands that write a tree to a file, and those that take one in place of a mesh."""

import json
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rich")
pytest.importorskip("typer")

from command_line import plain_terminal, run_cli

import treelet
from treelet import scenes

_plain_terminal = plain_terminal

SMALL = ["--triangles", "1000"]


@pytest.fixture
def saved(tmp_path):
    path = str(tmp_path / "city.treelet")
    run_cli("build", "city", *SMALL, "--recipe", "lbvh > cwbvh", "--save", path)
    return path


def test_build_saves_the_tree(saved):
    mesh = scenes.load("city", triangles=1000)
    bvh = treelet.load(saved, verify=True)
    assert bvh.validate(mesh.vertices, mesh.faces) == []
    assert bvh.report.recipe == "lbvh > cwbvh(leaf=3)"


def test_build_saves_the_mesh_as_it_lies(tmp_path):
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]]) + 5e6 + 0.1
    np.savez(tmp_path / "far.npz", vertices=vertices, faces=[[0, 1, 2]])
    result = run_cli("build", str(tmp_path / "far.npz"), "--save", str(tmp_path / "far.treelet"))
    assert "warning" not in result.output
    assert treelet.load(tmp_path / "far.treelet").validate(vertices, [[0, 1, 2]]) == []


def test_info_of_a_tree(saved):
    out = run_cli("info", saved).stdout
    mesh = scenes.load("city", triangles=1000)
    for words in (
        "city.treelet",
        "version 1, cwbvh",
        treelet.mesh_hash(mesh.vertices, mesh.faces),
        "SAH cost",
    ):
        assert words in out


def test_info_of_a_tree_as_json(saved):
    facts = json.loads(run_cli("info", saved, "--json").stdout)
    assert facts["file"]["layout"] == "cwbvh"
    assert facts["file"]["mesh_hash"] == treelet.load(saved).mesh_hash
    assert facts["bvh"]["recipe"] == "lbvh > cwbvh(leaf=3)"


def test_info_of_an_empty_tree(tmp_path):
    treelet.build([], []).save(tmp_path / "a.treelet")
    run_cli("info", str(tmp_path / "a.treelet"), "--json")


def test_validate_a_tree(saved):
    assert "FAILED" not in run_cli("validate", saved).stdout
    assert json.loads(run_cli("validate", saved, "--json").stdout)["passed"]


@pytest.mark.parametrize("command", ["info", "validate"])
def test_a_damaged_tree_is_bad_input(saved, command):
    path = Path(saved)
    data = bytearray(path.read_bytes())
    data[-100] ^= 1
    path.write_bytes(data)
    result = run_cli(command, saved, code=2)
    assert "the triangles" in result.output
    assert "Traceback" not in result.output
