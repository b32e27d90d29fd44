"""The figures that the project is after on one H200, against what was measured."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Sized
from typing import NamedTuple

from treelet.bench.gpu.effective import treelets_pay_from
from treelet.bench.gpu.results import HOST_MARK, Results, Scene, table

NOT_YET = "not yet measured"
RESEARCH = ("sibenik", "conference", "crytek_sponza", "breakfast_room", "dragon", "armadillo")
EMBEDDED = ("city", "forest", "interior")
GOAL_SCENES = RESEARCH + EMBEDDED


class Found(NamedTuple):
    """A measured figure."""

    text: str
    is_met: bool


Find = Callable[[Results], "Found | None"]


class Goal(NamedTuple):
    """A figure: what it is, what is wanted, what others publish, and how to find it."""

    figure: str
    wanted: str
    others: str
    find: Find


def goal_table(results: Results) -> list[str]:
    """One row a goal."""
    rows = []
    for goal in GOALS:
        found = goal.find(results)
        met = ("yes" if found.is_met else "no") if found else ""
        rows.append([goal.figure, goal.wanted, goal.others, found.text if found else NOT_YET, met])
    return table(["figure", "goal", "others", "measured", "met"], rows, left=5)


def _scenes(results: Results, names: tuple[str, ...], kind: str) -> list[Scene]:
    return [scene for scene in results.scenes if scene.name in names and scene.of_kind(kind, "rays")]


def _count(scenes: Sized) -> str:
    return f"{len(scenes)} scene{'s' if len(scenes) != 1 else ''}"


def _rates(scene: Scene, kind: str) -> dict[str, float]:
    """Grays/s by label."""
    return {each.label: each.rays_per_second / 1e9 for each in scene.of_kind(kind, "rays")}


def primary_rate(results: Results) -> Found | None:
    """Primary rays of Sponza through the best of the device's trees."""
    for scene in _scenes(results, ("crytek_sponza",), "primary"):
        rates = {label: rate for label, rate in _rates(scene, "primary").items() if HOST_MARK not in label}
        if rates:
            label = max(rates, key=rates.__getitem__)
            return Found(f"{rates[label]:.2f} Grays/s, {label}", rates[label] >= 9.0)
    return None


def diffuse_mean(results: Results) -> Found | None:
    """The arithmetic mean over the scenes, of the one recipe for which it is highest."""
    found = [_rates(scene, "diffuse") for scene in _scenes(results, GOAL_SCENES, "diffuse")]
    shared = set.intersection(*map(set, found)) if found else set()
    means = {
        label: statistics.fmean(rates[label] for rates in found)
        for label in sorted(shared)
        if HOST_MARK not in label
    }
    if not means:
        return None
    label = max(means, key=means.__getitem__)
    is_whole = len(found) >= len(GOAL_SCENES)
    text = f"{means[label]:.2f} Grays/s, {label}, {_count(found)}"
    return Found(text, is_whole and means[label] >= 3.5)


def treelet_quality(results: Results) -> Found | None:
    """The diffuse rate over `lbvh > treelet` trees against SBVH's, or else the sweep's, layout by layout."""
    for builder in ("sbvh", "sweep"):
        scenes = _scenes(results, GOAL_SCENES, "diffuse")
        ratios = [ratio for scene in scenes if (ratio := _ratio_to(builder, _rates(scene, "diffuse")))]
        if ratios:
            mean = statistics.geometric_mean(ratios)
            is_whole = builder == "sbvh" and len(ratios) >= len(GOAL_SCENES)  # the sweep only stands in
            return Found(f"{100 * mean:.0f} % of {builder}'s, {_count(ratios)}", is_whole and mean >= 0.97)
    return None


def _ratio_to(builder: str, rates: dict[str, float]) -> float | None:
    pairs = [
        rates[ours] / rates[reference]
        for reference in rates
        if reference.startswith(f"{builder} >") and (ours := _treelet_like(reference)) in rates
    ]
    return statistics.geometric_mean(pairs) if pairs else None


def _treelet_like(reference: str) -> str:
    return f"lbvh > treelet >{reference.partition('>')[2]}".replace(f" {HOST_MARK}", "")


def effective_start(results: Results) -> Found | None:
    """Rays a million triangles from which on treelets beat the LBVH."""
    starts = []
    for scene in _scenes(results, GOAL_SCENES, "diffuse"):
        start = treelets_pay_from(scene.curves("diffuse"))
        starts.append(math.inf if start is None else start / scene.faces)
    if not starts:
        return None
    median, most = statistics.median(starts), max(starts)
    is_whole = len(starts) >= len(GOAL_SCENES)
    text = f"{median:.1f}M (median), {most:.1f}M (most), {_count(starts)}"
    return Found(text, is_whole and median <= 7.0)


def call_overhead(results: Results) -> Found | None:
    """The worst library's."""
    found = [each.seconds for _, calls in results.measured("call_overhead") for each in calls]
    return Found(f"{max(found) * 1e6:.0f} us", max(found) < 50e-6) if found else None


def _build_rate(recipe: str, goal: float) -> Find:
    """Million triangles a second of the device, over scenes of about a million triangles or more."""

    def find(results: Results) -> Found | None:
        rates = [
            each.faces / each.seconds / 1e6
            for _, measurements in results.measured("build", "builds")
            for each in measurements
            if each.label == recipe and each.faces >= 900_000
        ]
        return Found(f"{min(rates):,.0f} to {max(rates):,.0f} Mtri/s", min(rates) >= goal) if rates else None

    return find


def small_build(results: Results) -> Found | None:
    """The whole call over about 10 000 triangles."""
    seconds = [
        each.seconds
        for _, measurements in results.measured("build_call", "builds")
        for each in measurements
        if each.label == "lbvh > treelet > bvh8" and 9_000 <= each.faces < 20_000
    ]
    return Found(f"{max(seconds) * 1e3:.2f} ms", max(seconds) <= 0.3e-3) if seconds else None


def worst_stage(results: Results) -> Found | None:
    """How many times a copy's time of its bytes the worst stage takes, over ten million triangles or more."""
    rate = results.copy_rate
    times = [
        (rate / stage["bytes_per_second"], stage["name"])
        for _, measurements in results.measured("build", "builds")
        for each in measurements
        for stage in each.details["stages"]
        if rate and each.faces >= 9_000_000 and stage.get("bytes_per_second")
    ]
    return Found(f"{max(times)[0]:.1f}, {max(times)[1]}", max(times)[0] <= 3.0) if times else None


_TREELET, _SPLIT = "lbvh > treelet > bvh8", "presplit(budget=30) > lbvh > treelet > bvh8"
GOALS = (
    Goal("`lbvh > bvh2`, 1M triangles or more", "4 000 Mtri/s", "", _build_rate("lbvh > bvh2", 4000.0)),
    Goal(f"`{_TREELET}`, likewise", "1 000 Mtri/s", "", _build_rate(_TREELET, 1000.0)),
    Goal("the same with `presplit(budget=30)`", "700 Mtri/s", "", _build_rate(_SPLIT, 700.0)),
    Goal("a build of 10 000 triangles, the call", "0.3 ms at most", "", small_build),
    Goal("time of the worst stage against a copy's of its bytes", "3 at most", "", worst_stage),
    Goal("primary rays, crytek_sponza", "9 Grays/s", "5 (RTX 5080 laptop, binary tree)", primary_rate),
    Goal(
        "diffuse rays, mean of nine scenes", "3.5 Grays/s", "at most 1.5 (RTX 4070 Ti, 8-wide)", diffuse_mean
    ),
    Goal("diffuse rate over a treelet tree against SBVH", "97 %", "", treelet_quality),
    Goal("rays a million triangles that treelets need to beat the LBVH", "7M at most", "", effective_start),
    Goal("a call of 1M rays from Python, beyond the kernel", "50 us at most", "", call_overhead),
)
