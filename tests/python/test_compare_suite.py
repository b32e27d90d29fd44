from __future__ import annotations

from pathlib import Path

import pytest

from treelet.bench.compare import load_suite

SUITES = Path(__file__).parents[2] / "bench" / "suites"
SMALL = """
reference = "A"
[recipes]
A = "sbvh > bvh8"
B = "fast"
[[scene]]
mesh = "city"
"""


def write(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "some.toml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("name", ["quick", "builders", "treelet-sizes", "treelet-rounds", "budgets", "full"])
def test_committed_suites_are_sound(name):
    suite = load_suite(SUITES / f"{name}.toml")
    assert suite.reference.startswith("SBVH")
    assert len(suite.candidates) > 2


def test_the_full_suite_has_scenes_enough():
    suite = load_suite(SUITES / "full.toml")
    assert len(suite.scenes) >= 16
    assert {"primary", "diffuse", "ambient_occlusion"} == set(suite.kinds)


def test_defaults(tmp_path):
    suite = load_suite(write(tmp_path, SMALL))
    assert suite.title == "some"
    assert [each.recipe for each in suite.candidates] == [
        "sbvh(budget=100) > bvh8(leaf=8)",
        "lbvh > bvh8(leaf=8)",
    ]
    assert suite.scenes[0].views == ()
    assert suite.plan.width * suite.plan.height == pytest.approx(suite.rays, rel=0.01)


def test_scenes_can_be_chosen(tmp_path):
    suite = load_suite(write(tmp_path, SMALL + '[[scene]]\nmesh = "soup"\n'))
    assert [scene.mesh for scene in suite.chosen(["soup"]).scenes] == ["soup"]
    with pytest.raises(ValueError, match="the suite has no scene 'moon': it has city, soup"):
        suite.chosen(["moon"])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("reference", "referense", "reference is missing; is 'referense' meant to be it"),
        ('"A"', '"C"', r"reference is 'C', which \[recipes\] lacks; known are A, B"),
        ("reference", "repeat = 3\nreference", "unknown key 'repeat'; did you mean 'repeats'"),
        (
            "mesh",
            'vievs = ["street"]\nmesh',
            r"\[\[scene\]\] number 1: unknown key 'vievs'; did you mean 'views'",
        ),
        ("reference", "rays = 0\nreference", "rays must be a whole number from 1 to .*, not 0"),
        ("reference", "builds = true\nreference", "builds must be a whole number of at least 1, not True"),
        ("reference", "epo = 1\nreference", "epo must be true or false, not 1"),
        ("reference", 'kinds = ["difuse"]\nreference', "kinds: unknown 'difuse'; did you mean 'diffuse'"),
        ("reference", "kinds = []\nreference", "kinds must be a list of texts"),
        ('"fast"', '"lbvh > trelet"', "recipes.'B': .*did you mean 'treelet'"),
        ('"fast"', '"sbvh"', "'A' and 'B' are the same recipe"),
        ('"fast"', "7", "recipes.'B'"),
        ("mesh", "triangles = 7\nmesh", "triangles must be a whole number from 1000"),
        ('"city"', '"a.ply"\ntriangles = 2000', "'a.ply' has its own triangles"),
        ('"city"', '"city"\n[[scene]]\nmesh = "city"', "a scene is there twice"),
        ("[[scene]]", "[scene]", r"scene must be one or more \[\[scene\]\]"),
        ("=", "", "is not TOML"),
    ],
)
def test_what_is_wrong_is_named(tmp_path, old, new, message):
    path = write(tmp_path, SMALL.replace(old, new, 1))
    with pytest.raises(ValueError, match=message) as caught:
        load_suite(path)
    assert str(path) in str(caught.value)
