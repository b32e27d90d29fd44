"""Tables of effective performance: which recipe pays off for how many rays."""

from __future__ import annotations

from collections.abc import Sequence

from treelet.bench.compare.payoff import (
    RAY_COUNTS,
    mean_curves,
    mean_ranges,
    scene_curves,
    scene_ranges,
    treelet_ranges,
)
from treelet.bench.compare.results import KIND_NAMES, Results
from treelet.bench.compare.table import Cell, Column, Table, figure, percent, text
from treelet.bench.effective import Range
from treelet.plots.effective import ray_count_text


def payoff_tables(results: Results) -> list[Table]:
    """Two for each kind of rays: shares by number of rays, and who is best where."""
    tables = []
    for kind in results.kinds:
        tables += [_mean_table(results, kind), _range_table(results, kind)]
    return tables


def ranges_text(ranges: Sequence[Range], *, with_labels: bool = True) -> str:
    """'LBVH from 1M to 79M; treelet from 79M to 1T'"""
    parts = [
        (f"{each.label} from " if with_labels else "")
        + f"{ray_count_text(each.start)} to {ray_count_text(each.end)}"
        for each in ranges
    ]
    return "; ".join(parts) or "nowhere"


def _mean_table(results: Results, kind: str) -> Table:
    curves = mean_curves(results, kind)
    columns = [Column("recipe", is_text=True)]
    columns += [Column(ray_count_text(rays), better="high") for rays in RAY_COUNTS]
    rows = tuple(
        (text(curve.label), *(figure(curve.at(rays), percent) for rays in RAY_COUNTS)) for curve in curves
    )
    best = mean_ranges(curves)
    winning = ranges_text(treelet_ranges(results, best), with_labels=False)
    note = (
        f"Rays over the time to build and trace them, as a share of the ray rate of {results.reference}, %: "
        f"the mean over scenes, by rays that one tree serves. Best: {ranges_text(best)}. "
        f"Recipes with treelets are best for {winning} rays."
    )
    title = f"Effective performance, {KIND_NAMES[kind]} rays"
    return Table(f"payoff_{kind}", title, note, tuple(columns), rows)


def _range_table(results: Results, kind: str) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for name, scene in zip(results.scene_names(), results.scenes, strict=True):
        if scene_curves(results, scene, kind):
            ranges = scene_ranges(results, scene, kind)
            treelets = ranges_text(treelet_ranges(results, ranges), with_labels=False)
            rows.append((text(name), text(ranges_text(ranges)), text(treelets)))
    columns = (
        Column("scene", is_text=True),
        Column("best recipe, rays", is_text=True),
        Column("a treelet recipe is best", is_text=True),
    )
    title = f"Best recipe by number of {KIND_NAMES[kind]} rays, scene by scene"
    return Table(f"ranges_{kind}", title, "", columns, tuple(rows))
