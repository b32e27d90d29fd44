"""What is made of measurements of a GPU: tables, effective performance, goals. Needs no GPU."""

import json

import pytest

from treelet.bench import Measurement
from treelet.bench.effective import Curve, Range, best_ranges, curves_of, ranges_of
from treelet.bench.gpu import goals, kernels, report, tables
from treelet.bench.gpu.effective import (
    builder_of,
    choose_curves,
    range_sentences,
    share_table,
    treelets_pay_from,
)
from treelet.bench.gpu.results import Scene, group, table

MILLION = 1_000_000


def measurement(kind, label, seconds, scene="city", faces=MILLION, rays=0, task="rays city", **details):
    recipe = label.partition(",")[0].replace(" (CPU)", "")
    details = {"task": task, "sah": 30.0, "bytes": 10**8, "stages": []} | details
    return Measurement(
        kind=kind,
        scene=scene,
        faces=faces,
        label=label,
        recipe=recipe,
        samples=[seconds],
        rays=rays,
        details=details,
        machine={"gpu": "Test GPU", "cpu": "Test CPU"},
        commit="abc",
    )


def trees(scene="city", scale=1.0):
    """Builds and rays of four recipes over a scene: the LBVH, treelets, these with sorted rays, the sweep."""
    found = [
        measurement("build", "lbvh > bvh2", 0.5e-3, scene),
        measurement("build", "lbvh > treelet > bvh2", 1.5e-3, scene),
        measurement("build", "sweep > bvh2 (CPU)", 1.0, scene, built_on="cpu"),
    ]
    rates = {
        "lbvh > bvh2": 2.0e9,
        "lbvh > treelet > bvh2": 3.0e9,
        "lbvh > treelet > bvh2, reorder": 3.6e9,
        "sweep > bvh2 (CPU)": 3.2e9,
    }
    for label, rate in rates.items():
        work = {"nodes_per_ray": 20.0, "triangles_per_ray": 5.0, "disagreements": 0}
        for kind in ("primary", "diffuse"):
            found.append(measurement(kind, label, MILLION / rate / scale, scene, rays=MILLION, **work))
    return found


def test_later_measurements_replace_earlier_ones_of_the_same_task():
    old, new = measurement("build", "lbvh > bvh2", 1.0), measurement("build", "lbvh > bvh2", 2.0)
    other = measurement("build", "lbvh > bvh2", 3.0, task="builds city")
    [scene] = group([old, new, other]).scenes
    assert [each.seconds for each in scene.of_kind("build")] == [2.0, 3.0]
    assert [each.seconds for each in scene.of_kind("build", "builds")] == [3.0]
    assert scene.find("build", "lbvh > bvh2") is other
    assert scene.find("build", "hploc > bvh2") is None


def test_rays_in_another_order_have_the_build_of_their_recipe():
    curves = {curve.label: curve for curve in curves_of(trees(), "diffuse")}
    assert curves["lbvh > treelet > bvh2, reorder"].build_seconds == 1.5e-3
    assert curves["sweep > bvh2 (CPU)"].build_seconds == 1.0
    assert len(curves) == 4
    assert curves_of([measurement("diffuse", "lbvh > bvh2", 1.0, rays=1)]) == []


def test_neighbouring_ranges_of_a_word_are_joined():
    ranges = [Range("lbvh", 1, 2), Range("a treelet", 2, 3), Range("b treelet", 3, 5), Range("treelet", 7, 9)]
    assert ranges_of(ranges, "treelet") == [Range("treelet", 2, 5), Range("treelet", 7, 9)]
    assert ranges_of(ranges, "hploc") == []


def test_treelets_pay_where_the_better_rate_has_paid_for_the_build():
    [scene] = group(trees()).scenes
    curves = scene.curves("diffuse")
    start = treelets_pay_from(curves)
    # 1.5 ms + r / 3.6e9 = 0.5 ms + r / 2e9
    assert start == pytest.approx(1e-3 / (1 / 2e9 - 1 / 3.6e9))
    sentences = "\n".join(range_sentences(scene, curves))
    assert "lbvh > treelet > bvh2, reorder from 4.5M to 1T" in sentences
    assert "Treelets are in the best one for 4.5M to 1T rays" in sentences
    assert "beats `lbvh` from 4.5M rays on: 4.5M a million triangles" in sentences


@pytest.mark.parametrize("rate", [1e9, 2e9])
def test_treelets_that_do_not_trace_faster_never_pay(rate):
    plain, slower = Curve("lbvh > bvh2", 1e-3, 2e9), Curve("lbvh > treelet > bvh2", 2e-3, rate)
    assert treelets_pay_from([plain, slower]) is None
    assert treelets_pay_from([plain]) is None
    assert treelets_pay_from([]) is None
    scene = Scene("city", MILLION)
    assert "no number of rays" in range_sentences(scene, [plain, slower])[1]


def test_treelets_that_are_never_behind_pay_at_once():
    plain, better = Curve("lbvh > bvh2", 2e-3, 2e9), Curve("lbvh > treelet > bvh2", 1e-3, 3e9)
    assert treelets_pay_from([plain, better]) == 0.0


def test_a_plot_shows_each_builder_once():
    [scene] = group(trees()).scenes
    chosen = choose_curves(scene.curves("diffuse"))
    assert [curve.label for curve in chosen] == [
        "lbvh > bvh2",
        "lbvh > treelet > bvh2, reorder",
        "sweep > bvh2 (CPU)",
    ]
    assert builder_of("presplit(budget=30) > lbvh > treelet > cwbvh, reorder") == "presplit > lbvh > treelet"
    assert builder_of("sweep > bvh2 (CPU)") == "sweep (CPU)"


def test_the_best_of_each_number_of_rays_is_marked(capsys, tmp_path):
    path = tmp_path / "gpu.jsonl"
    path.write_text("".join(json.dumps(each.as_dict()) + "\n" for each in trees()))
    assert report.main([str(path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    [lbvh] = [line for line in lines if line.startswith("| lbvh > bvh2 ") and "**" in line][:1]
    cells = [cell.strip() for cell in lbvh.split("|")]
    assert cells[2] == "0.50"
    assert cells[3] == "**1,000**"  # a million rays: 1e6 / (0.5 ms + 0.5 ms)
    assert "Test GPU, Test CPU, commit abc" in "\n".join(lines)


def test_shares_of_the_best_are_means_over_scenes():
    lines = share_table(group([*trees("city"), *trees("forest", 10.0)]))
    shares = {line.split("|")[1].strip(): line.split("|")[-2].strip() for line in lines[2:]}
    assert shares["lbvh > treelet > bvh2, reorder"] == "100"  # of a trillion rays
    assert shares["lbvh > bvh2"] == str(round(100 * 2.0 / 3.6))
    only = [
        *trees("city"),
        measurement("build", "a", 1.0, "soup"),
        measurement("diffuse", "a", 1.0, "soup", rays=9),
    ]
    assert share_table(group(only)) == []
    assert share_table(group([])) == []


def test_goals_without_measurements_are_not_yet_measured():
    lines = goals.goal_table(group([]))
    assert len(lines) == 2 + len(goals.GOALS)
    assert all(goals.NOT_YET in line for line in lines[2:])


def test_goals_are_found_in_measurements():
    everything = [each for name in goals.GOAL_SCENES for each in trees(name, 3.0)]
    results = group(everything)
    assert goals.primary_rate(results) == ("10.80 Grays/s, lbvh > treelet > bvh2, reorder", True)
    mean = goals.diffuse_mean(results)
    assert mean.is_met
    assert mean.text == "10.80 Grays/s, lbvh > treelet > bvh2, reorder, 9 scenes"
    assert not goals.diffuse_mean(group(trees("city", 3.0))).is_met  # one scene is not the nine
    assert goals.treelet_quality(results) == ("94 % of sweep's, 9 scenes", False)  # 3.0 of 3.2
    better = [
        measurement("diffuse", "sbvh > bvh2 (CPU)", MILLION / 9.1e9, name, rays=MILLION)
        for name in goals.GOAL_SCENES
    ]
    # 9.0 of 9.1
    assert goals.treelet_quality(group([*everything, *better])) == ("99 % of sbvh's, 9 scenes", True)
    assert goals.treelet_quality(group([*everything, *better[:2]])) == ("99 % of sbvh's, 2 scenes", False)
    assert goals.effective_start(results) == ("13.5M (median), 13.5M (most), 9 scenes", False)
    assert goals.effective_start(group(trees())) == ("4.5M (median), 4.5M (most), 1 scene", False)
    slower = group([each for name in goals.GOAL_SCENES for each in trees(name)])
    assert goals.effective_start(slower) == ("4.5M (median), 4.5M (most), 9 scenes", True)


def test_goals_of_builds_and_calls():
    label = "lbvh > bvh2"
    fast, slow = (
        measurement("build", label, s, task="builds city", faces=f) for s, f in ((2e-4, 10**6), (1e-2, 10**7))
    )
    results = group([fast, slow, measurement("build", label, 1.0, faces=10_000, task="builds city")])
    found = dict(zip((goal.figure for goal in goals.GOALS), goals.GOALS, strict=True))
    assert found["`lbvh > bvh2`, 1M triangles or more"].find(results) == ("1,000 to 5,000 Mtri/s", False)
    small = measurement("build_call", "lbvh > treelet > bvh8", 2.5e-4, faces=9_950, task="builds sphere")
    assert goals.small_build(group([small])) == ("0.25 ms", True)
    calls = [
        measurement("call_overhead", f"lbvh, {name}", s, task="calls")
        for name, s in (("a", 3e-5), ("b", 6e-5))
    ]
    assert goals.call_overhead(group(calls)) == ("60 us", False)


def test_stages_are_held_against_copies():
    stages = [
        {"name": "sort", "seconds": 1e-3, "bytes": 2e9, "bytes_per_second": 2e12},
        {"name": "think", "seconds": 1e-3},
    ]
    build = measurement("build", "lbvh > bvh2", 2e-3, faces=10**7, task="builds city", stages=stages)
    copy = measurement("copy", "copy", 1e-3, scene="memory", faces=0, task="copy memory", bytes=4 * 10**9)
    results = group([copy, build])
    assert results.copy_rate == 4e12
    sort, think = tables.stages(results)[2:]
    assert [cell.strip() for cell in sort.split("|")][3:8] == ["sort", "10,000,000", "1.000", "2,000", "2.0"]
    assert [cell.strip() for cell in think.split("|")][6:8] == ["", ""]
    assert goals.worst_stage(results) == ("2.0, sort", True)
    assert goals.worst_stage(group([build])) is None


def test_bytes_of_rays_follow_from_their_work():
    results = group(trees())
    [first, *_] = [line for line in tables.ray_limits(results) if "lbvh > bvh2 " in line]
    assert f" {20 * 64 + 5 * 40 + 40:,} " in first
    assert tables.ray_limits(group([measurement("diffuse", "lbvh > dream", 1.0, rays=1)])) == []


def test_wrong_answers_stand_in_the_table():
    wrong = measurement("diffuse", "lbvh > bvh2", 1.0, rays=9, disagreements=3)
    assert "no: 3 rays" in tables.rays(group([wrong]))[2]


def test_a_table_without_rows_is_none():
    assert table(["a", "b"], []) == []
    assert table(["a", "b"], [["x", "1"]]) == ["| a | b |", "|---|--:|", "| x | 1 |"]


@pytest.mark.parametrize(
    ("registers", "warps"), [(0, 64), (32, 64), (33, 48), (40, 48), (64, 32), (80, 24), (128, 16), (255, 8)]
)
def test_registers_limit_the_warps_of_a_processor(registers, warps):
    assert kernels.warps_by_registers(registers) == warps


def test_shared_memory_limits_the_blocks_of_a_processor():
    assert [kernels.blocks_by_shared(size) for size in (0, 34_720, 47_104)] == [32, 6, 4]


WIDE = """\
==PROF== Connected to process 7
"ID","Kernel Name","dram__bytes.sum","gpu__time_duration.sum","smsp__inst_executed.sum"
"","","byte","ns",""
"0","void treelet::cuda::(anonymous namespace)::sort<int, (bool)1>(int *)","2,000","1,000","50"
"1","void treelet::cuda::<unnamed>::sort<int, (bool)1>(int *)","4000","1000","70"
"2","treelet::cuda::trace(Ray)","100","10","5"
"""
LONG = """\
"ID","Kernel Name","Metric Name","Metric Unit","Metric Value"
"0","trace(int)","gpu__time_duration.sum","ns","10"
"0","trace(int)","dram__bytes.sum","byte","100"
"0","trace(int)","another.metric","","1"
"1","trace(int)","gpu__time_duration.sum","ns","(no value)"
"""


def test_counters_are_read_in_both_forms(tmp_path):
    path = tmp_path / "counters.csv"
    path.write_text(WIDE)
    lines = kernels.counter_table(kernels.read_counters(path), 4e9)
    cells = [cell.strip() for cell in lines[2].split("|")]
    assert cells[1:7] == ["sort<int, (bool)1>", "2", "2.0", "3", "0.75", "120"]
    assert lines[3].startswith("| trace ")
    path.write_text(LONG)
    assert kernels.read_counters(path) == [
        kernels.Counters("trace(int)", {"nanoseconds": 10.0, "bytes": 100.0})
    ]
    path.write_text("no counters\n")
    with pytest.raises(ValueError, match="no heading of Nsight Compute"):
        kernels.read_counters(path)


def test_the_report_takes_registers_and_counters(tmp_path, capsys):
    function = {"source": "a.cu", "name": "treelet::cuda::trace(int)", "is_kernel": True, "registers": 80}
    function |= {"spill_stores": 4, "spill_loads": 8, "shared": 0}
    cub = function | {"name": "cub::sort()"}
    resources, counters = tmp_path / "kernels.jsonl", tmp_path / "counters.csv"
    resources.write_text("".join(json.dumps(each) + "\n" for each in (function, cub)))
    counters.write_text(WIDE)
    assert report.main(["--goals", f"--resources={resources}", f"--counters={counters}"]) == 0
    text = capsys.readouterr().out
    assert "| a.cu | trace  |        80 |            12 |            0 |          24 |           32 |" in text
    assert "cub" not in text
    assert "## Kernels" in text


@pytest.mark.parametrize(("text", "what"), [("{}\n", "line 1 is not a measurement"), (None, "No such file")])
def test_files_that_cannot_be_read_end_with_a_sentence(tmp_path, capsys, text, what):
    path = tmp_path / "gpu.jsonl"
    if text is not None:
        path.write_text(text)
    with pytest.raises(SystemExit) as end:
        report.main([str(path)])
    assert end.value.code == 2
    assert what in capsys.readouterr().err


def test_best_ranges_of_equal_curves_do_not_break():
    same = [Curve("a", 1e-3, 1e9), Curve("b", 1e-3, 1e9)]
    assert [each.label for each in best_ranges(same)] == ["a"]
