"""Recipes as text: what they mean, and what is said of bad ones."""

import re

import pytest
from sample_meshes import TRIANGLE_FACES, TRIANGLE_VERTICES

import treelet

TREELET = "treelet(size=7, rounds=3, gamma=0)"


@pytest.mark.parametrize(
    ("text", "meaning"),
    [
        ("fast", "lbvh > bvh8(leaf=8)"),
        ("balanced", "lbvh > treelet(size=7, rounds=2, gamma=14) > bvh8(leaf=8)"),
        ("lbvh", "lbvh > bvh8(leaf=8)"),
        ("sweep", "sweep > bvh8(leaf=8)"),
        ("lbvh>bvh2", "lbvh > bvh2(leaf=8)"),
        (
            " lbvh  > treelet ( rounds = 1 ,size=4 )\n> bvh2() ",
            "lbvh > treelet(size=4, rounds=1, gamma=0) > bvh2(leaf=8)",
        ),
        ("lbvh > treelet(gamma=1e3)", "lbvh > treelet(size=7, rounds=3, gamma=1000) > bvh8(leaf=8)"),
        (
            "sweep > treelet > treelet(size=8)",
            f"sweep > {TREELET} > treelet(size=8, rounds=3, gamma=0) > bvh8(leaf=8)",
        ),
        ("lbvh > bvh2(leaf=64)", "lbvh > bvh2(leaf=64)"),
        ("presplit > lbvh", "presplit(budget=30) > lbvh > bvh8(leaf=8)"),
    ],
)
def test_meaning(text, meaning):
    assert treelet.parse_recipe(text) == meaning
    assert treelet.parse_recipe(meaning) == meaning
    assert treelet.build(TRIANGLE_VERTICES, TRIANGLE_FACES, text).report.recipe == meaning


STAGES = "There are: " + ", ".join(word.name for word in treelet.recipe_words())
ALL_NAMES = ", ".join([STAGES, *treelet.presets()])


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("fsat", f"unknown preset or stage 'fsat'; did you mean 'fast'? {ALL_NAMES}"),
        ("balancd", f"unknown preset or stage 'balancd'; did you mean 'balanced'? {ALL_NAMES}"),
        ("lbhv > bvh2", f"unknown stage 'lbhv'; did you mean 'lbvh'? {STAGES}"),
        ("lbvh > treelets(size=5)", f"unknown stage 'treelets'; did you mean 'treelet'? {STAGES}"),
        (
            "lbvh > treelet(sise=7)",
            "unknown argument treelet(sise); did you mean 'size'? There are: size, rounds, gamma",
        ),
        ("lbvh(bits=60)", "unknown argument lbvh(bits); there are none"),
        ("lbvh > treelet(size=3)", "treelet(size) must be a whole number from 4 to 8"),
        ("lbvh > treelet(size=9)", "treelet(size) must be a whole number from 4 to 8"),
        ("lbvh > treelet(size=4.5)", "treelet(size) must be a whole number from 4 to 8"),
        ("lbvh > treelet(rounds=-1)", "treelet(rounds) must be a whole number from 0 to 16"),
        ("lbvh > bvh2(leaf=0)", "bvh2(leaf) must be a whole number from 1 to 64"),
        ("lbvh > bvh2(leaf=65)", "bvh2(leaf) must be a whole number from 1 to 64"),
        ("lbvh > bvh8(leaf=17)", "bvh8(leaf) must be a whole number from 1 to 16"),
        ("lbvh > treelet(size=7, size=8)", "gives treelet(size) twice"),
        ("bvh2", "must begin with a builder, not with the layout 'bvh2'"),
        ("presplit", "needs a builder after 'presplit'"),
        ("presplit > treelet", "needs a builder after 'presplit', not the optimizer 'treelet'"),
        ("presplit > bvh8", "needs a builder after 'presplit', not the layout 'bvh8'"),
        ("presplit > presplit > lbvh", "has a second splitter, 'presplit'"),
        ("presplit > trysplit > lbvh", "has a second splitter, 'trysplit'"),
        ("trysplit(margin=-1) > lbvh", "trysplit(margin) must be a whole number from 0 to 100"),
        ("trysplit(gate=1) > lbvh", "unknown argument trysplit(gate); there are: budget, margin"),
        ("lbvh > presplit", "the splitter 'presplit' must come first"),
        ("treelet > bvh2", "must begin with a builder, not with the optimizer 'treelet'"),
        ("lbvh > sweep", "has a second builder, 'sweep'"),
        ("lbvh > bvh2 > treelet", "the layout 'bvh2' must come last"),
        ("", "expected the name of a stage at character 1"),
        ("lbvh >", "expected the name of a stage at character 7"),
        ("lbvh bvh2", "expected '>' or the end at character 6"),
        ("lbvh > treelet(7)", "expected '=' after 7 at character 17"),
        ("lbvh > treelet(size=)", "expected a number at character 21"),
        ("lbvh > treelet(size=nan)", "expected a number at character 21"),
        ("lbvh > treelet(size=7", "expected ',' or ')' at character 22"),
    ],
)
def test_bad_recipes(text, what):
    message = "^" + re.escape(f'recipe "{text}": {what}') + "$"
    with pytest.raises(ValueError, match=message):
        treelet.parse_recipe(text)
    with pytest.raises(ValueError, match=message):
        treelet.build(TRIANGLE_VERTICES, TRIANGLE_FACES, text)


def test_what_resembles_nothing_gets_no_suggestion():
    with pytest.raises(ValueError, match="unknown preset or stage 'xyzzyxyzzy'") as caught:
        treelet.parse_recipe("xyzzyxyzzy")
    assert "did you mean" not in str(caught.value)


@pytest.mark.parametrize("bad", [7, b"fast", ["fast"]])
def test_a_recipe_must_be_text(bad):
    message = f"^recipe must be text, not {type(bad).__name__}$"
    with pytest.raises(TypeError, match=message):
        treelet.parse_recipe(bad)
    with pytest.raises(TypeError, match=message):
        treelet.build(TRIANGLE_VERTICES, TRIANGLE_FACES, bad)


def test_presets_are_recipes():
    assert list(treelet.presets()) == ["fast", "balanced", "better", "best"]
    for name, recipe in treelet.presets().items():
        assert treelet.parse_recipe(name) == treelet.parse_recipe(recipe)


def test_words_describe_themselves():
    words = {word.name: word for word in treelet.recipe_words()}
    kinds = {
        "presplit": "splitter",
        "trysplit": "splitter",
        "lbvh": "builder",
        "sweep": "builder",
        "treelet": "optimizer",
    } | dict.fromkeys(["bvh2", "bvh8", "cwbvh"], "layout")
    assert kinds.items() <= {name: word.kind for name, word in words.items()}.items()
    assert all(len(word.summary) > 20 for word in words.values())
    size = words["treelet"].parameters[0]
    assert isinstance(size, treelet.Parameter)
    assert size[:4] == ("size", 7, 4, 8)


def recipe_with(word, parameter, value):
    """A whole recipe in which one argument is given."""
    stages = {"splitter": "", "builder": "lbvh", "optimizer": "", "layout": ""}
    stages[word.kind] = f"{word.name}({parameter.name}={value})"
    return " > ".join(filter(None, stages.values()))


@pytest.mark.parametrize("word", treelet.recipe_words(), ids=lambda word: word.name)
def test_limits_of_parameters_are_those_described(word):
    for parameter in word.parameters:
        for value in (parameter.minimum, parameter.default, parameter.maximum):
            assert f"{parameter.name}={value}" in treelet.parse_recipe(recipe_with(word, parameter, value))
        for value in (parameter.minimum - 1, parameter.maximum + 1):
            with pytest.raises(ValueError, match="must be a whole number from"):
                treelet.parse_recipe(recipe_with(word, parameter, value))
