from __future__ import annotations

import json
from pathlib import Path

import pytest

pytest.importorskip("rich")
pytest.importorskip("typer")
pytest.importorskip("matplotlib")

from command_line import plain_terminal, run_cli

import treelet
from treelet.bench import read_measurements

_plain_terminal = plain_terminal

SUITE = """
title = "Tiny"
reference = "SBVH"
kinds = ["primary", "diffuse", "ao"]
rays = 160
bounces = 2
builds = 2
repeats = 2

[recipes]
SBVH = "sbvh > bvh8"
treelet = "balanced"

[[scene]]
mesh = "city"
triangles = 1000
views = ["skyline", "street"]

[[scene]]
mesh = "sphere"
triangles = 1000
views = ["outside"]
"""
LINES = 2 * (1 + 3 * 2) + 2 * (1 + 3)  # recipes by a build and three kinds from each view


@pytest.fixture
def suite(tmp_path) -> Path:
    path = tmp_path / "tiny.toml"
    path.write_text(SUITE)
    return path


def lines_of(folder: Path):
    return read_measurements(folder / "measurements.jsonl")


def run(suite: Path, *options: str, code: int = 0):
    return run_cli("compare", str(suite), "--out", str(suite.parent / "out"), *options, code=code)


def test_whole_way(suite):
    result = run(suite)
    out = suite.parent / "out"
    lines = lines_of(out)
    assert len(lines) == LINES
    assert {each.kind for each in lines} == {"build", "primary", "diffuse", "ambient_occlusion"}
    assert all(len(each.samples) == 2 for each in lines)
    assert all(each.details["nodes_per_ray"] > 0.0 for each in lines if each.kind != "build")
    assert "Recipes" in result.stdout
    assert "Effective performance, diffuse rays" in result.stdout
    names = {path.name for path in out.iterdir()}
    assert {"report.md", "effective.png", "shares.png", "build-and-rate.png", "sessions.jsonl"} <= names


def test_the_time_is_told_first(suite):
    text = run(suite, "--estimate").stderr
    assert "Tiny: scenes: 2, recipes: 2, about" in text
    assert not (suite.parent / "out").exists()


def test_a_second_run_measures_nothing(suite):
    run(suite)
    before = (suite.parent / "out" / "measurements.jsonl").read_bytes()
    assert "Tiny: nothing is left to measure" in run(suite).stderr
    assert (suite.parent / "out" / "measurements.jsonl").read_bytes() == before


def test_a_run_that_was_cut_off_goes_on(suite):
    run(suite)
    path = suite.parent / "out" / "measurements.jsonl"
    kept = path.read_text().splitlines()[:-2]
    path.write_text("\n".join(kept) + '\n{"kind": "diff')
    run(suite)
    assert len(lines_of(path.parent)) == LINES


def test_a_new_recipe_is_measured_beside_the_reference(suite):
    run(suite)
    suite.write_text(SUITE.replace('treelet = "balanced"', 'treelet = "balanced"\nLBVH = "fast"'))
    run(suite)
    added = lines_of(suite.parent / "out")[LINES:]
    assert {each.label for each in added} == {"SBVH", "LBVH"}
    assert len({each.details["session"] for each in added}) == 1
    assert len(added) == LINES


def test_options_override_the_suite(suite):
    run(suite, "--scenes", "sphere", "--rays", "40", "--repeats", "3", "--builds", "1")
    lines = lines_of(suite.parent / "out")
    assert {each.scene for each in lines} == {"sphere"}
    assert {len(each.samples) for each in lines if each.kind == "build"} == {1}
    assert {(len(each.samples), each.rays) for each in lines if each.kind == "primary"} == {(3, 40)}


def test_a_bad_scene_does_not_lose_the_others(suite):
    suite.write_text(SUITE.replace('"outside"', '"inside"'))
    result = run(suite, code=1)
    assert "failed: sphere: sphere has no view 'inside'" in result.stderr
    assert {each.scene for each in lines_of(suite.parent / "out")} == {"city"}
    assert "* failed: sphere" in (suite.parent / "out" / "report.md").read_text()


def test_absent_scenes_are_skipped(suite):
    suite.write_text(
        SUITE
        + '[[scene]]\nmesh = "soda_hall"\n[[scene]]\nmesh = "nowhere/a.ply"\n[[scene]]\nmesh = "citty"\n'
    )
    result = run(suite)
    assert "skipped, TREELET_SCENES names no folder of scenes: soda_hall" in result.stderr
    assert "or did you mean 'city'?: citty" in result.stderr
    assert "* skipped: nowhere/a.ply: " in (suite.parent / "out" / "report.md").read_text()


def test_nothing_at_all_is_an_error(suite):
    suite.write_text(SUITE[: SUITE.index("[[scene]]")] + '[[scene]]\nmesh = "soda_hall"\n')
    assert "none of the scenes of 'Tiny' is there" in run(suite, code=2).stderr
    suite.write_text(SUITE[: SUITE.index("[[scene]]")] + '[[scene]]\nmesh = "city"\nviews = ["moon"]\n')
    assert "failed: city: city has no view 'moon'" in run(suite, code=1).stderr


def test_a_bad_recipe_does_not_lose_the_others(suite, monkeypatch):
    build = treelet.build

    def fails_for_treelets(vertices, faces, recipe="balanced", **options):
        if "treelet" in recipe:
            raise RuntimeError("no room")
        return build(vertices, faces, recipe, **options)

    monkeypatch.setattr(treelet, "build", fails_for_treelets)
    result = run(suite, code=1)
    assert "failed: city, treelet: no room" in result.stderr
    assert {each.label for each in lines_of(suite.parent / "out")} == {"SBVH"}


def test_report_alone_says_the_same(suite):
    first = json.loads(run(suite, "--json").stdout)
    out = suite.parent / "out"
    text = (out / "report.md").read_text()
    (out / "report.md").unlink()
    again = json.loads(run_cli("compare", "--report-only", str(out), "--json").stdout)
    assert again == first
    assert (out / "report.md").read_text() == text


def test_json_has_shares_and_ranges(suite):
    facts = json.loads(run(suite, "--json").stdout)
    assert [each["label"] for each in facts["recipes"]] == ["SBVH", "treelet"]
    assert facts["recipes"][0]["share_of_reference"]["diffuse"]["arithmetic"] == 1.0
    assert facts["best"]["diffuse"]["all_scenes"][-1]["to"] == 1e12
    assert facts["failures"] == 0


def test_work_counts_repeat(suite):
    """They do not depend on timings: two runs count the same nodes and triangles."""
    run(suite)
    first = lines_of(suite.parent / "out")
    run_cli("compare", str(suite), "--out", str(suite.parent / "other"))
    second = lines_of(suite.parent / "other")
    names = ("row", "nodes_per_ray", "triangles_per_ray", "sah", "epo")
    facts = [[[each.details.get(name) for name in names] for each in lines] for lines in (first, second)]
    assert facts[0] == facts[1]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "give a suite, such as `treelet compare bench/suites/quick.toml`"),
        (["nowhere.toml"], "nowhere.toml: no such file or directory"),
        (["--report-only", "nowhere"], "nowhere holds no measurements.jsonl"),
        (["a.toml", "--report-only", "b"], "--report-only FOLDER measures nothing"),
    ],
)
def test_bad_usage_is_told(arguments, message):
    assert message in run_cli("compare", *arguments, code=2).stderr


def test_a_damaged_session_file_is_named(suite):
    run(suite)
    out = suite.parent / "out"
    with (out / "sessions.jsonl").open("a") as file:
        file.write("[]\n")
    assert "is not of a session" in run_cli("compare", "--report-only", str(out), code=2).stderr
