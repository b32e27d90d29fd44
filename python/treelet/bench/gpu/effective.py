"""Effective performance on a GPU: which recipe for how many rays, and where treelets pay."""

from __future__ import annotations

import statistics
from collections.abc import Sequence

from treelet.bench.effective import Curve, best_ranges, crossover, ranges_of
from treelet.bench.gpu.results import HOST_MARK, Results, Scene, table
from treelet.plots.effective import ray_count_text

_DECADES = tuple(10.0**power for power in range(6, 13))


def effective_tables(results: Results, kind: str = "diffuse") -> list[str]:
    """For each scene the effective Mrays/s of every recipe, the best marked, and the ranges in words."""
    lines: list[str] = []
    for scene in results.scenes:
        curves = scene.curves(kind)
        if curves:
            lines += [*([""] if lines else []), *_scene_lines(scene, curves, kind)]
    return lines


def share_table(results: Results, kind: str = "diffuse") -> list[str]:
    """Each recipe's effective rate as a share of the best one's, the mean over all scenes that have it."""
    scenes = [{curve.label: curve for curve in scene.curves(kind)} for scene in results.scenes]
    scenes = [curves for curves in scenes if curves]
    shared = [label for label in scenes[0] if all(label in curves for curves in scenes)] if scenes else []
    rows = []
    for label in shared:
        shares = [
            statistics.fmean(
                curves[label].at(rays) / max(curve.at(rays) for curve in curves.values()) for curves in scenes
            )
            for rays in _DECADES
        ]
        rows.append([label, *(f"{100 * share:.0f}" for share in shares)])
    return table(["recipe", *map(ray_count_text, _DECADES)], rows)


def _scene_lines(scene: Scene, curves: Sequence[Curve], kind: str) -> list[str]:
    best = [max(curve.at(rays) for curve in curves) for rays in _DECADES]
    rows = []
    for curve in curves:
        rates = [curve.at(rays) for rays in _DECADES]
        cells = [f"{rate / 1e6:,.0f}" for rate in rates]
        marked = [
            f"**{cell}**" if rate == most else cell
            for cell, rate, most in zip(cells, rates, best, strict=True)
        ]
        rows.append([curve.label, f"{curve.build_seconds * 1e3:,.2f}", *marked])
    headings = ["recipe", "build ms", *map(ray_count_text, _DECADES)]
    lines = [f"{scene.name}, {scene.faces:,} triangles, {kind} rays, effective Mrays/s:", ""]
    return [*lines, *table(headings, rows), "", *range_sentences(scene, curves)]


def range_sentences(scene: Scene, curves: Sequence[Curve]) -> list[str]:
    """Which recipe is best where, where treelets are, and from how many rays on they beat the LBVH."""
    ranges = best_ranges(curves)
    named = [
        f"{each.label} from {ray_count_text(each.start)} to {ray_count_text(each.end)}" for each in ranges
    ]
    treelets = [
        f"{ray_count_text(each.start)} to {ray_count_text(each.end)}" for each in ranges_of(ranges, "treelet")
    ]
    lines = [f"* Best: {'; '.join(named)}."]
    lines.append(f"* Treelets are in the best one for {' and '.join(treelets) or 'no number of'} rays.")
    start = treelets_pay_from(curves)
    if start is not None:
        per_million = ray_count_text(start / (scene.faces / 1e6))
        lines.append(
            f"* `lbvh > treelet` beats `lbvh` from {ray_count_text(start)} rays on: {per_million} a million "
            "triangles."
        )
    return lines


def treelets_pay_from(curves: Sequence[Curve]) -> float | None:
    """From how many rays on `lbvh > treelet` beats `lbvh`, each in the layout and order that traces fastest.

    None where it never does, or one of them was not measured.
    """
    plain = _fastest([curve for curve in curves if builder_of(curve.label) == "lbvh"])
    treelet = _fastest([curve for curve in curves if builder_of(curve.label) == "lbvh > treelet"])
    if plain is None or treelet is None or treelet.rays_per_second <= plain.rays_per_second:
        return None
    return crossover(plain, treelet) or 0.0


def choose_curves(curves: Sequence[Curve]) -> list[Curve]:
    """What a plot can show: each builder once, in the layout and order in which it traces fastest."""
    groups: dict[str, list[Curve]] = {}
    for curve in curves:
        groups.setdefault(builder_of(curve.label), []).append(curve)
    return [max(group, key=lambda curve: curve.rays_per_second) for group in groups.values()]


def builder_of(label: str) -> str:
    """The words of a label before the layout, without arguments; marked where the CPU built it."""
    words = [part.strip().partition("(")[0] for part in label.split(">")[:-1]]
    return " > ".join(words) + (f" {HOST_MARK}" if HOST_MARK in label else "")


def _fastest(curves: Sequence[Curve]) -> Curve | None:
    return max(curves, key=lambda curve: curve.rays_per_second, default=None)
