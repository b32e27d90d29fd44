from __future__ import annotations

import json
import math
import re

import pytest
from compare_lines import RECIPES, begin, golden_lines, line

from treelet.bench.compare import gather, short_tables, summary, write_markdown
from treelet.bench.compare.estimate import Forecast, describe_seconds
from treelet.bench.compare.payoff import mean_curves, mean_ranges, treelet_ranges
from treelet.bench.compare.results import means
from treelet.bench.compare.suite import SceneChoice
from treelet.bench.compare.variants import families, has_word, read_steps


@pytest.fixture
def results():
    return gather(golden_lines(), [begin()])


def table(results, key):
    return next(each for each in short_tables(results) if each.key == key)


def test_shares_are_of_the_reference(results):
    small, large = results.scenes
    assert small.share("SBVH", "diffuse") == pytest.approx(1.0)
    assert small.share("LBVH", "diffuse") == pytest.approx(0.5)
    assert large.share("treelets of 7", "diffuse") == pytest.approx(0.9)
    assert large.build_share("LBVH") == pytest.approx(0.01)
    assert large.rate("LBVH", "diffuse") == pytest.approx(0.25e6)
    assert small.share("LBVH", "primary") is None


def test_means_are_arithmetic_and_geometric():
    found = means([0.25, 1.0, None, 0.0])
    assert (found.arithmetic, found.geometric) == (pytest.approx(0.625), pytest.approx(0.5))
    assert (found.least, found.most, found.scenes) == (0.25, 1.0, 2)
    assert means([None]) is None


def test_a_share_is_of_one_session():
    """A recipe that a slower machine measured later is compared with the reference there."""
    later = [
        line("small", "SBVH", "diffuse", 3.0, view="near", session="2"),
        line("small", "LBVH", "diffuse", 4.0, view="near", session="2"),
    ]
    own = [each for each in golden_lines() if each.details.get("view") != "far"]
    small = gather([*own, *later], [begin()]).scenes[0]
    assert small.share("LBVH", "diffuse") == pytest.approx(0.75)
    assert small.share("treelets of 6", "diffuse") == pytest.approx(0.8)


def test_lines_of_other_commits_do_not_count():
    newer = begin(commit="new")
    fresh = line("small", "SBVH", "build", 1.0, sah=1.0)
    object.__setattr__(fresh, "commit", "new")
    assert [scene.name for scene in gather([*golden_lines(), fresh], [begin(), newer]).scenes] == ["small"]


def test_noise_is_told(results):
    """Samples are the median, half and twice of it."""
    assert (results.noise.typical, results.noise.bad) == (pytest.approx(1.5), pytest.approx(1.5))


def test_nothing_to_report_is_an_error():
    with pytest.raises(ValueError, match="there is nothing to report"):
        gather([], [begin()])
    with pytest.raises(ValueError, match="there is nothing to report"):
        gather(golden_lines(), [])


def test_best_ranges_of_the_mean(results):
    """Both scenes have the same curve but for a factor in both build and rays, so the crossings are exact."""
    ranges = mean_ranges(mean_curves(results, "diffuse"))
    # Equal times: b1 + n t1 = b2 + n t2, in millions of rays.
    sixth = (0.4 - 0.2) / (1.25 - 1.0 / 0.9)
    seventh = (10.0 - 0.4) / (1.0 / 0.9 - 1.0)
    assert [each.label for each in ranges] == ["treelets of 6", "treelets of 7", "SBVH"]
    assert ranges[0].end == pytest.approx(sixth * 1e6, rel=1e-6)
    assert ranges[1].end == pytest.approx(seventh * 1e6, rel=1e-6)
    assert (ranges[0].start, ranges[-1].end) == (1e6, 1e12)
    [joined] = treelet_ranges(results, ranges)
    assert (joined.start, joined.end) == (ranges[0].start, ranges[1].end)


def test_effective_rates_tend_to_the_share(results):
    curves = {curve.label: curve for curve in mean_curves(results, "diffuse")}
    assert curves["LBVH"].at(1e15) == pytest.approx(0.5)
    assert curves["SBVH"].at(1e6) == pytest.approx(1.0 / 11.0)


def test_a_recipe_that_a_scene_lacks_has_no_mean(results):
    lines = [each for each in golden_lines() if (each.scene, each.label) != ("large", "LBVH")]
    labels = [curve.label for curve in mean_curves(gather(lines, [begin()]), "diffuse")]
    assert labels == [label for label in RECIPES if label != "LBVH"]


def test_treelet_sizes_stand_beside_the_talk(results):
    sizes = table(results, "sizes")
    assert [column.heading for column in sizes.columns][-2:] == ["diffuse %", "talk, Soda Hall %"]
    assert [[row[0].text, row[-2].text, row[-1].text] for row in sizes.rows] == [
        ["treelets of 6", "80.0", "88.0"],
        ["treelets of 7", "90.0", "97.0"],
    ]


def test_budgets_have_a_table(results):
    budgets = table(results, "budget-0")
    assert "`presplit(...) > lbvh > bvh8(leaf=8)`" in budgets.note
    assert [row[1].value for row in budgets.rows] == [10, 30]


def test_report_is_as_before(snapshots, results, tmp_path):
    snapshots.check("compare_report", write_markdown(results, tmp_path / "report.md").read_text())


def test_skipped_and_failed_scenes_are_told_of(tmp_path):
    sessions = [
        begin(),
        {"event": "failed", "session": "0", "scene": "old", "reason": "of an older session"},
        {"event": "skipped", "session": "1", "scene": "moon", "reason": "not there"},
        {"event": "failed", "session": "1", "scene": "mars", "label": "LBVH", "reason": "out of memory"},
    ]
    text = write_markdown(gather(golden_lines(), sessions), tmp_path / "report.md").read_text()
    assert "* skipped: moon: not there" in text
    assert "* failed: mars, LBVH: out of memory" in text
    assert "older session" not in text


def test_summary_is_plain_json(results):
    facts = json.loads(json.dumps(summary(results), allow_nan=False))
    [lbvh] = [each for each in facts["recipes"] if each["label"] == "LBVH"]
    assert lbvh["share_of_reference"]["diffuse"]["geometric"] == pytest.approx(0.5)
    assert facts["best"]["diffuse"]["all_scenes"][0]["from"] == 1e6
    assert set(facts["best"]["diffuse"]["scenes"]) == {"small", "large"}


def test_recipes_are_read():
    assert read_steps("lbvh > treelet(size=7, rounds=3) > bvh8(leaf=8)") == [
        ("lbvh", {}),
        ("treelet", {"size": 7, "rounds": 3}),
        ("bvh8", {"leaf": 8}),
    ]
    assert has_word("lbvh > treelet(size=7)", "treelet")
    assert not has_word("lbvh > bvh8", "treelet")
    with pytest.raises(ValueError, match="is not a recipe"):
        read_steps("lbvh > treelet(7")


def test_families_need_two_values():
    recipes = {"a": "lbvh > treelet(size=7, gamma=0)", "b": "lbvh > treelet(size=7, gamma=7)"}
    assert families(recipes, "treelet", ("size", "gamma"), "size") == []
    [family] = families(recipes, "treelet", ("size", "gamma"), "gamma")
    assert [each.label for each in family.variants] == ["a", "b"]


def test_forecast_is_corrected():
    first, second = SceneChoice("city", 1000), SceneChoice("city", 2000)
    forecast = Forecast({first: 0.0, second: 10.0})
    assert forecast.total == 10.0
    assert math.isfinite(forecast.finish(first))
    assert forecast.finish(second) == 0.0
    assert forecast.finish(second) is None


@pytest.mark.parametrize(("seconds", "text"), [(0.2, "1 s"), (80, "80 s"), (600, "10 min"), (9000, "2.5 h")])
def test_durations_read_well(seconds, text):
    assert describe_seconds(seconds) == text


def test_plots_are_written_and_repeat(results, tmp_path):
    pytest.importorskip("matplotlib")
    from treelet.bench.compare import write_plots

    files = write_plots(results, tmp_path / "a")
    names = ["shares.png", "effective.png", "build-and-rate.png", "treelet-sizes.png"]
    assert [file.name for file in files] == names
    again = write_plots(results, tmp_path / "b")
    assert [one.read_bytes() == other.read_bytes() for one, other in zip(files, again, strict=True)] == [
        True
    ] * 4


def test_page_needs_nothing_from_elsewhere(results, tmp_path):
    pytest.importorskip("plotly")
    pytest.importorskip("matplotlib")
    from plotly.offline import get_plotlyjs

    from treelet.bench.compare import write_page

    page = write_page(results, tmp_path / "page.html").read_text(encoding="utf-8")
    assert page.count(get_plotlyjs()) == 1
    ours = page.replace(get_plotlyjs(), "")
    assert not re.search(r"<!--[A-Z]+-->", ours)
    assert not re.search(r"""(src|href)\s*=|url\(|@import|https?://""", ours)
    assert "default-src 'none'" in ours
    data = json.loads(re.search(r'id="data">(.*?)</script>', ours, re.DOTALL)[1])
    assert [recipe["label"] for recipe in data["recipes"]] == list(RECIPES)
    assert data["shares"]["diffuse"][0][1] == pytest.approx(0.5)


def test_page_shows_names_as_they_are(tmp_path):
    pytest.importorskip("plotly")
    pytest.importorskip("matplotlib")
    from treelet.bench.compare import write_page

    evil = gather(golden_lines(), [begin(title="</script><b>&")])
    ours = write_page(evil, tmp_path / "page.html").read_text(encoding="utf-8")
    assert "<title>&lt;/script&gt;&lt;b&gt;&amp;</title>" in ours
