from __future__ import annotations

import json
import re
import subprocess
import sys

import numpy as np
import pytest

pytest.importorskip("rich")
pytest.importorskip("typer")

from command_line import plain_terminal, run_cli
from typer.testing import CliRunner

import treelet
from treelet import scenes
from treelet.bench import read_measurements
from treelet.cli.app import app
from treelet.cli.facts import gather_facts, weld
from treelet.cli.sample_rays import sample_rays
from treelet.cli.text import bar, byte_count, mega, milliseconds
from treelet.mesh import Mesh

COMMANDS = ["demo", "build", "info", "validate", "render", "bench", "compare", "list"]
SMALL = ["--triangles", "1000"]


_plain_terminal = plain_terminal


def help_words(text: str) -> str:
    """Help without frames and types, which differ from one release of typer to the next."""
    text = re.sub(r"[╭╮╰╯│─]|<\w+>|\[x>=\d\]|[{}]", " ", text)
    return "\n".join(" ".join(line.split()) for line in text.splitlines() if line.strip())


def masked_numbers(text: str) -> str:
    """Tables without what differs from run to run: timings, bars of their shares, widths of columns."""
    text = re.sub(r"[█▏▎▍▌▋▊▉]+", "", re.sub(r"(?<![a-z])\d+([.,]\d+)*", "N", text))
    return "\n".join(" ".join(line.split()) for line in re.sub(r"─+", "──", text).splitlines())


@pytest.mark.parametrize("command", ["", *COMMANDS])
def test_help(snapshots, command):
    result = run_cli(*command.split(), "--help")
    snapshots.check(f"help_{command or 'treelet'}", help_words(result.stdout))


def test_no_arguments_show_the_help():
    assert "Usage" in CliRunner().invoke(app, []).output


def test_version_is_the_package_s():
    assert run_cli("--version").stdout == f"treelet {treelet.__version__}\n"


def test_python_m_treelet_is_the_program():
    answer = subprocess.run(
        [sys.executable, "-m", "treelet", "--version"], capture_output=True, text=True, timeout=60, check=True
    )
    assert answer.stdout == f"treelet {treelet.__version__}\n"


def test_help_loads_nothing_heavy():
    heavy = "{'matplotlib', 'PIL', 'trimesh'}"
    code = f"import sys; from treelet.cli.app import app; sys.exit(bool({heavy} & set(sys.modules)))"
    subprocess.run([sys.executable, "-c", code], timeout=60, check=True)


def test_list_of_scenes(snapshots):
    snapshots.check("list_scenes", run_cli("list", "scenes").stdout)


def test_list_of_recipes(snapshots):
    snapshots.check("list_recipes", run_cli("list", "recipes").stdout)


def test_list_of_views(snapshots):
    snapshots.check("list_views", run_cli("list", "views", "menger").stdout)


def test_list_as_json_has_all_topics():
    lists = json.loads(run_cli("list", "--json").stdout)
    assert [scene["name"] for scene in lists["scenes"]] == scenes.names()
    assert lists["recipes"]["presets"] == treelet.presets()
    views = json.loads(run_cli("list", "views", "city", "--json").stdout)["views"]
    assert views[-1]["name"] == "automatic"


def test_info(snapshots):
    snapshots.check("info_menger", run_cli("info", "menger", *SMALL).stdout)


def test_info_with_tree(snapshots):
    snapshots.check("info_city_bvh", masked_numbers(run_cli("info", "city", *SMALL, "--bvh").stdout))


def test_info_as_json():
    facts = json.loads(run_cli("info", "sphere", *SMALL, "--bvh", "--json").stdout)
    assert facts["closed"] is True
    assert facts["bvh"]["references"] == facts["faces"]


def test_build(snapshots):
    result = run_cli("build", "city", *SMALL, "--validate")
    snapshots.check("build_city", masked_numbers(result.stdout))


def test_build_as_json():
    facts = json.loads(run_cli("build", "city", *SMALL, "-r", "fast", "--threads", "1", "--json").stdout)
    assert facts["recipe"] == treelet.parse_recipe("fast")
    assert facts["threads"] == 1
    assert sum(stage["seconds"] for stage in facts["stages"]) <= facts["build_seconds"]
    assert facts["epo"] >= 0.0


@pytest.mark.parametrize("scene", ["sphere", "soup", "interior"])
def test_validate_passes_sound_scenes(scene):
    verdict = json.loads(run_cli("validate", scene, *SMALL, "--rays", "64", "--json").stdout)
    assert verdict["passed"] is True
    assert verdict["violations"] == []
    assert verdict["wrong_rays"] == []


def test_validate_prints_a_verdict(snapshots):
    snapshots.check("validate_sphere", run_cli("validate", "sphere", *SMALL).stdout)


def test_validate_fails_where_brute_force_differs(monkeypatch):
    right = treelet.intersect_brute_force

    def wrong(*arguments, **options):
        hits = right(*arguments, **options)
        return hits._replace(face=hits.face + 1)

    monkeypatch.setattr(treelet, "intersect_brute_force", wrong)
    result = run_cli("validate", "sphere", *SMALL, "--rays", "8", code=1)
    assert "FAILED  rays that differ from brute force: 8 of 8" in result.stdout


def test_validate_fails_where_the_tree_is_broken(monkeypatch):
    monkeypatch.setattr(treelet.Bvh, "validate", lambda self, *mesh: ["node 3 has no box"])
    result = run_cli("validate", "sphere", *SMALL, "--rays", "8", code=1)
    assert "node 3 has no box" in result.stdout


def test_validate_is_strict_about_left_out_faces_if_asked(tmp_path):
    path = tmp_path / "flawed.npz"
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [np.nan, 0, 0]], dtype=np.float32)
    np.savez(path, vertices=vertices, faces=np.array([[0, 1, 2], [0, 1, 3], [0, 0, 1]]))
    assert "faces left out of the tree: 2" in run_cli("validate", str(path)).stdout
    run_cli("validate", str(path), "--strict", code=1)


@pytest.mark.parametrize("mode", ["path", "ao", "normals", "depth", "heat"])
def test_render_writes_a_picture(tmp_path, mode):
    path = tmp_path / "new" / "picture.png"
    result = run_cli(
        "render", "city", *SMALL, "-o", str(path), "-m", mode, "--size", "48x30", "-s", "2", "--json"
    )
    facts = json.loads(result.stdout)
    assert path.read_bytes().startswith(b"\x89PNG")
    assert facts["width"] == 48
    assert facts["view"]["name"] == scenes.load("city", 1000).views[0].name


def test_render_takes_cameras(tmp_path):
    common = ["render", "sphere", *SMALL, "-o", str(tmp_path / "a.png"), "--size", "8x8", "-s", "1", "--json"]
    placed = run_cli(*common, "--eye", "0,-5,1", "--look-at", "0,0,0", "--up", "0,0,1", "--fov", "30")
    assert json.loads(placed.stdout)["view"] | {"name": ""} == {
        "name": "",
        "eye": [0.0, -5.0, 1.0],
        "look_at": [0.0, 0.0, 0.0],
        "up": [0.0, 0.0, 1.0],
        "fov_degrees": 30.0,
    }
    assert json.loads(run_cli(*common, "--view", "automatic").stdout)["view"]["name"] == "automatic"


def test_bench_writes_json_lines(tmp_path):
    options = ["--size", "16x10", "--builds", "1", "--repeats", "1", "--out", str(tmp_path)]
    rows = json.loads(
        run_cli("bench", "city", *SMALL, "-r", "fast", "-r", "balanced", *options, "--json").stdout
    )
    assert [row["label"] for row in rows] == ["fast", "balanced"]
    assert len(read_measurements(tmp_path / "city.jsonl")) == 8


def test_bench_prints_a_table(snapshots, tmp_path):
    options = ["--size", "16x10", "--builds", "1", "--repeats", "1", "--out", str(tmp_path)]
    snapshots.check("bench_city", masked_numbers(run_cli("bench", "city", *SMALL, *options).stdout))


def test_demo_does_the_main_job(tmp_path):
    options = ["--out", str(tmp_path), "--size", "32x20", "--samples", "1", "--repeats", "1"]
    result = run_cli("demo", *SMALL, *options)
    for word in ("LBVH", "treelet", "sweep SAH", "build ms", "SAH", "EPO", "1T", "Best for diffuse rays"):
        assert word in result.stdout
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == ["effective.png", "heat.png", "measurements.jsonl", "picture.png"]


def test_demo_takes_a_mesh_file(tmp_path):
    ball = scenes.load("sphere", triangles=1000)
    path = tmp_path / "ball.npz"
    np.savez(path, vertices=ball.vertices, faces=ball.faces)
    options = [
        "--out",
        str(tmp_path / "out"),
        "--size",
        "32x20",
        "--samples",
        "1",
        "--repeats",
        "1",
        "--json",
    ]
    facts = json.loads(run_cli("demo", str(path), *options).stdout)
    assert facts["faces"] == len(ball.faces)
    assert [row["label"] for row in facts["rows"]] == ["LBVH", "treelet", "sweep SAH"]
    assert list(facts["rows"][0]["effective_rays_per_second"]) == [
        "1M",
        "10M",
        "100M",
        "1G",
        "10G",
        "100G",
        "1T",
    ]


ERRORS = {
    "scene": ["build", "citty"],
    "file": ["info", "nowhere.ply"],
    "extension": ["info", "mesh.docx"],
    "triangles": ["build", "city", "--triangles", "7"],
    "recipe": ["build", "city", *SMALL, "-r", "lbvh > trelet > bvh2"],
    "size": ["render", "city", *SMALL, "--size", "12"],
    "view": ["render", "city", *SMALL, "--view", "moon"],
    "eye": ["render", "city", *SMALL, "--eye", "1,2,3"],
    "vector": ["render", "city", *SMALL, "--eye", "1,2", "--look-at", "0,0,0"],
    "png": ["render", "city", *SMALL, "-o", "picture.jpg"],
    "views_of_nothing": ["list", "views"],
    "scenes_of_something": ["list", "scenes", "city"],
}


def test_errors_are_one_paragraph_each(snapshots):
    paragraphs = []
    for name, arguments in ERRORS.items():
        result = run_cli(*arguments, code=2)
        assert result.stdout == "", name
        assert len(result.stderr.strip().splitlines()) == 1, result.stderr
        paragraphs.append(f"$ treelet {' '.join(arguments)}\n{result.stderr}")
    snapshots.check("errors", "\n".join(paragraphs))


def test_debug_shows_the_traceback_wherever_it_stands():
    for arguments in (["--debug", "build", "citty"], ["build", "citty", "--debug"]):
        with pytest.raises(ValueError, match="citty"):
            run_cli(*arguments)
    run_cli("build", "citty", code=2)


@pytest.mark.parametrize(
    "arguments", [["render"], ["render", "city", "--mode", "x-ray"], ["no-such-command"], ["list", "--x"]]
)
def test_wrong_usage_is_exit_code_2(arguments):
    run_cli(*arguments, code=2)


def test_colour_follows_no_color(monkeypatch):
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm-256color")
    assert "\x1b[3" not in run_cli("info", "soup", *SMALL).stdout


def test_facts_count_flaws():
    vertices = np.array(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [-0.0, 0, 0], [2, 0, 0], [np.inf, 0, 0]], dtype=np.float32
    )
    faces = np.array([[0, 1, 2], [2, 1, 3], [0, 3, 1], [0, 1, 4], [0, 1, 5]], dtype=np.int32)
    facts = gather_facts(Mesh(vertices, faces, "flawed"))
    assert facts.distinct_positions == 5
    assert (facts.non_finite_faces, facts.degenerate_faces, facts.zero_area_faces, facts.duplicate_faces) == (
        1,
        1,
        1,
        1,
    )
    assert facts.high == [2.0, 1.0, 0.0]
    assert not facts.is_closed


def test_facts_of_nothing():
    facts = gather_facts(Mesh(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int32), "nothing"))
    assert (facts.faces, facts.open_edges, facts.is_closed) == (0, 0, False)


def test_welding_gives_equal_positions_one_id():
    ids, count = weld(np.array([[1, 2, 3], [0, 0, 0], [1, 2, 3], [-0.0, 0, 0]], dtype=np.float32))
    assert count == 2
    assert ids[0] == ids[2] != ids[1] == ids[3]


def test_sample_rays_repeat_and_aim_at_the_mesh():
    mesh = scenes.load("sphere", triangles=1000)
    origins, directions = sample_rays(mesh, mesh.bounds, 64, seed=3)
    np.testing.assert_array_equal(directions, sample_rays(mesh, mesh.bounds, 64, seed=3)[1])
    np.testing.assert_allclose(np.linalg.norm(origins + directions, axis=1), 1.0, atol=0.02)


def test_numbers_read_well():
    assert [milliseconds(value) for value in (0.001234, 0.01234, 0.1234, 1.234)] == [
        "1.23",
        "12.3",
        "123",
        "1,234",
    ]
    assert [mega(value) for value in (1.2345e6, 1.2345e7, 1.2345e8)] == ["1.23", "12.3", "123"]
    assert [byte_count(value) for value in (12, 2048, 3 << 30)] == ["12 B", "2.0 KiB", "3.0 GiB"]
    assert [bar(share, 2) for share in (0.0, 0.5, 1.0, 9.0)] == ["", "█", "██", "██"]
