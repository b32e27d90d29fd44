from __future__ import annotations

import json

import pytest

from treelet import scenes
from treelet.bench import (
    Candidate,
    Curve,
    Measurement,
    Plan,
    best_ranges,
    crossover,
    curves_of,
    effective_rate,
    measure,
    read_measurements,
    write_measurements,
)
from treelet.bench.machine import describe_machine
from treelet.bench.suite import run_suite, summary
from treelet.view import View

FAST, SLOW = Curve("fast build", 0.1, 1e6), Curve("fast rays", 1.1, 2e6)
CANDIDATES = (Candidate("LBVH", "fast"), Candidate("treelet", "balanced"))
PLAN = Plan(CANDIDATES, ("primary", "diffuse", "ambient_occlusion"), width=32, height=20, builds=2, repeats=3)


@pytest.fixture(scope="module")
def mesh():
    return scenes.load("city", triangles=2000)


def test_effective_rate_counts_the_build():
    assert effective_rate(1e6, 1.0, 1e6) == pytest.approx(0.5e6)
    assert effective_rate(1e12, 1.0, 1e6) == pytest.approx(1e6, rel=1e-5)


def test_crossover_is_where_both_take_equally_long():
    rays = crossover(FAST, SLOW)
    assert rays == pytest.approx(2e6)
    assert FAST.at(rays) == pytest.approx(SLOW.at(rays))
    assert crossover(SLOW, FAST) == pytest.approx(rays)


def test_there_is_no_crossover_with_a_curve_that_never_wins():
    assert crossover(FAST, Curve("worse", 0.2, 0.5e6)) is None
    assert crossover(FAST, Curve("as fast", 0.2, 1e6)) is None


def test_best_ranges_cover_everything_without_gaps():
    hopeless = Curve("hopeless", 5.0, 0.1e6)
    ranges = best_ranges([hopeless, SLOW, FAST])
    assert [(each.label, each.start, each.end) for each in ranges] == [
        ("fast build", 1e6, pytest.approx(2e6)),
        ("fast rays", pytest.approx(2e6), 1e12),
    ]


def test_best_range_of_one_curve_is_all():
    assert [(each.start, each.end) for each in best_ranges([FAST])] == [(1e6, 1e12)]


def test_measure_keeps_every_sample(mesh):
    steps = []
    result = measure(mesh, mesh.views[0], PLAN, steps.append)
    kinds = [(each.label, each.kind, len(each.samples)) for each in result.measurements]
    counts = {"build": 2, "primary": 3, "diffuse": 3, "ambient_occlusion": 3}
    assert kinds == [(each.label, kind, count) for each in CANDIDATES for kind, count in counts.items()]
    assert len(steps) == PLAN.steps
    assert set(result.bvhs) == {"LBVH", "treelet"}
    assert all(seconds > 0.0 for each in result.measurements for seconds in each.samples)


def test_candidates_take_turns_and_trace_the_same_rays(mesh):
    steps = []
    result = measure(mesh, mesh.views[0], PLAN, steps.append)
    assert steps[:4] == ["build LBVH", "build treelet"] * 2
    assert steps[4:6] == ["trace primary rays with LBVH", "trace primary rays with treelet"]
    rays = {(each.kind, each.rays) for each in result.measurements if each.kind != "build"}
    assert len(rays) == 3
    assert ("primary", 32 * 20) in rays


def test_builds_carry_the_quality_of_their_tree(mesh):
    build = measure(mesh, mesh.views[0], PLAN).measurements[0]
    assert build.details["sah"] > 0.0
    assert build.details["epo"] >= 0.0
    assert build.faces == len(mesh.faces)
    assert build.rays_per_second == 0.0


def test_unknown_ray_kind_is_named(mesh):
    with pytest.raises(
        ValueError, match="unknown ray kind 'gamma': choose from primary, diffuse, ambient_occlusion"
    ):
        measure(mesh, mesh.views[0], Plan(CANDIDATES, ("gamma",), width=8, height=8, builds=1))


def test_a_view_of_nothing_is_refused(mesh):
    into_the_sky = View((0.0, 0.0, 1e4), (0.0, 0.0, 2e4), (0.0, 1.0, 0.0))
    with pytest.raises(ValueError, match="no camera ray hits city, choose another view"):
        measure(mesh, into_the_sky, PLAN)


def test_measurements_come_back_from_their_file(tmp_path, mesh):
    measurements = measure(mesh, mesh.views[0], PLAN).measurements
    path = write_measurements(tmp_path / "new" / "some.jsonl", measurements)
    assert read_measurements(path) == measurements
    write_measurements(path, measurements[:1], append=True)
    assert read_measurements(path) == [*measurements, measurements[0]]
    line = json.loads(path.read_text().splitlines()[0])
    assert set(line["machine"]) == {"cpu", "cores", "system", "python"}
    assert line["schema"] == 1


def test_a_line_that_is_no_measurement_is_named(tmp_path):
    path = tmp_path / "bad.jsonl"
    path.write_text("\n{}\n")
    with pytest.raises(ValueError, match=r"bad\.jsonl, line 2 is not a measurement"):
        read_measurements(path)


def test_machine_is_described():
    machine = describe_machine()
    assert machine["cores"] >= 1
    assert machine["cpu"]


def test_curves_use_medians():
    common = {"scene": "s", "faces": 1, "label": "L", "recipe": "r"}
    build = Measurement(kind="build", samples=[3.0, 1.0, 2.0], **common)
    diffuse = Measurement(kind="diffuse", samples=[0.5, 9.0, 0.1], rays=100, **common)
    alone = Measurement(kind="build", samples=[1.0], **common | {"label": "never traced"})
    assert curves_of([build, diffuse, alone]) == [Curve("L", 2.0, 200.0)]


def test_suite_writes_one_file_a_mesh(tmp_path, mesh):
    [(path, result)] = run_suite([mesh], PLAN, tmp_path)
    assert path == tmp_path / "city.jsonl"
    rows = list(summary(result))
    assert [row["label"] for row in rows] == ["LBVH", "treelet"]
    assert set(rows[0]["mrays_per_second"]) == {"primary", "diffuse", "ambient_occlusion"}
