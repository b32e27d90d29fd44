"""Effective performance against the number of rays a tree is used for [KarrasAila2013 s5]."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from treelet.bench.effective import FEWEST_RAYS, MOST_RAYS, Curve, Range, best_ranges
from treelet.plots.style import THEMES, Theme, figure

# Rays a frame, as the paper divides them.
_USES = (("interactive", 1e6, 1e8), ("design", 1e8, 1e10), ("film", 1e10, 1e12))
_HEADROOM = 1.22  # of the y axis above the highest line, for the names of the bands
_LABEL_DISTANCE = 0.10  # least vertical distance of two labels, share of the axis


class _Scale(NamedTuple):
    """What rates are counted in."""

    rays: float
    unit: str


_MEGA, _GIGA = _Scale(1e6, "Mrays/s"), _Scale(1e9, "Grays/s")


def plot_effective(
    curves: Sequence[Curve], path: str | Path, scene: str = "", note: str = "", theme: str = "light"
) -> Path:
    """Draw one line a curve, mark where the best recipe changes, and write `path` (.png, .svg or .pdf).

    `scene` completes the title, `note` is a small line below it (machine, kind of rays). Raises ValueError
    without curves or for an unknown theme, ImportError without matplotlib.
    """
    if not curves:
        raise ValueError("there are no curves to plot: a label needs a build and a ray measurement")
    if theme not in THEMES:
        raise ValueError(f"unknown theme '{theme}': choose one of {', '.join(THEMES)}")
    colors = THEMES[theme]
    with figure(path, colors) as (_, axes):
        highest = max(curve.at(MOST_RAYS) for curve in curves)
        scale = _GIGA if highest >= _GIGA.rays else _MEGA
        top = _HEADROOM * highest / scale.rays
        _prepare_axes(axes, top, scale)
        _shade_uses(axes, colors)
        _draw_curves(axes, curves, colors, scale)
        _mark_best(axes, curves, colors, top, scale)
        _label_ends(axes, curves, colors, top, scale)
        _write_title(axes, scene, note, colors)
    return Path(path)


def ray_count_text(rays: float) -> str:
    """1e6 -> 1M, 3.2e9 -> 3.2G: two digits and a unit."""
    for limit, unit in ((1e12, "T"), (1e9, "G"), (1e6, "M"), (1e3, "k")):
        if rays >= 0.9995 * limit:
            value = rays / limit
            return f"{value:.0f}{unit}" if value >= 9.95 else f"{value:.1f}".removesuffix(".0") + unit
    return f"{rays:.0f}"


def _prepare_axes(axes, top: float, scale: _Scale) -> None:
    axes.set_xscale("log")
    axes.set_xlim(FEWEST_RAYS, MOST_RAYS)
    axes.set_ylim(0.0, top)
    ticks = 10.0 ** np.arange(6, 13)
    axes.set_xticks(ticks, [ray_count_text(tick) for tick in ticks])
    axes.tick_params(axis="x", which="minor", bottom=False)
    axes.set_xlabel("rays traced with one tree")
    axes.set_ylabel(f"effective {scale.unit}, build included")


def _shade_uses(axes, colors: Theme) -> None:
    for index, (name, start, end) in enumerate(_USES):
        if index % 2 == 0:
            axes.axvspan(start, end, color=colors.band, zorder=0, linewidth=0)
        axes.text(
            np.sqrt(start * end),
            0.975,
            name,
            transform=axes.get_xaxis_transform(),
            ha="center",
            va="top",
            color=colors.quiet,
            fontsize=10,
        )


def _draw_curves(axes, curves: Sequence[Curve], colors: Theme, scale: _Scale) -> None:
    rays = np.geomspace(FEWEST_RAYS, MOST_RAYS, 400)
    for index, curve in enumerate(curves):
        rates = [curve.at(count) / scale.rays for count in rays]
        axes.plot(rays, rates, color=_line_color(colors, index), zorder=3)


def _mark_best(axes, curves: Sequence[Curve], colors: Theme, top: float, scale: _Scale) -> None:
    """A bar along the top of the data in the colour of the best recipe, and a dot at each change."""
    labels = [curve.label for curve in curves]
    height = 0.90 * top
    for best in best_ranges(curves):
        index = labels.index(best.label)
        color = _line_color(colors, index)
        axes.plot([best.start * 1.04, best.end / 1.04], [height, height], color=color, linewidth=4, zorder=3)
        if best.end / best.start > 8.0:
            axes.text(
                np.sqrt(best.start * best.end),
                height - 0.018 * top,
                f"{best.label} best",
                color=color,
                ha="center",
                va="top",
                fontsize=9.5,
            )
        if best.start > FEWEST_RAYS:
            value = curves[index].at(best.start) / scale.rays
            _mark_crossover(axes, value, best, colors, height)


def _mark_crossover(axes, value: float, best: Range, colors: Theme, height: float) -> None:
    axes.plot(
        [best.start, best.start],
        [value, height],
        color=colors.quiet,
        linewidth=0.8,
        linestyle=(0, (2, 3)),
        zorder=2,
    )
    axes.plot(
        [best.start], [value], "o", color=colors.ink, markersize=6, markeredgecolor=colors.paper, zorder=5
    )
    axes.annotate(
        f"{ray_count_text(best.start)} rays",
        (best.start, value),
        (8, -13),
        textcoords="offset points",
        color=colors.ink,
        fontsize=9.5,
        zorder=5,
    )


def _label_ends(axes, curves: Sequence[Curve], colors: Theme, top: float, scale: _Scale) -> None:
    """Names and figures at the right end of the lines."""
    heights = spread_apart([curve.at(MOST_RAYS) / scale.rays / top for curve in curves], _LABEL_DISTANCE)
    for index, (curve, height) in enumerate(zip(curves, heights, strict=True)):
        milliseconds = curve.build_seconds * 1e3
        build = f"{milliseconds:,.0f}" if milliseconds >= 10 else f"{milliseconds:.2f}"
        detail = f"build {build} ms, {curve.rays_per_second / scale.rays:.2f} {scale.unit}"
        common = {"xycoords": "axes fraction", "va": "center", "annotation_clip": False}
        axes.annotate(
            f"{curve.label}\n",
            (1.012, height),
            color=_line_color(colors, index),
            fontsize=11,
            fontweight="bold",
            **common,
        )
        axes.annotate(f"\n{detail}", (1.012, height), color=colors.quiet, fontsize=8.5, **common)


def spread_apart(heights: Sequence[float], distance: float) -> list[float]:
    """Move heights as little as needed until neighbours are `distance` apart, keeping their order."""
    order = np.argsort(heights, kind="stable")
    moved = np.asarray(heights, dtype=np.float64)[order]
    for _ in range(200):
        overlap = np.maximum(distance - np.diff(moved), 0.0)
        if not np.any(overlap > 1e-6):
            break
        moved[:-1] -= 0.5 * overlap
        moved[1:] += 0.5 * overlap
    result = np.empty_like(moved)
    result[order] = moved
    return result.tolist()


def _write_title(axes, scene: str, note: str, colors: Theme) -> None:
    title = "Which tree pays off?" + (f"  {scene}" if scene else "")
    axes.set_title(title, loc="left", fontsize=14, fontweight="bold", pad=26 if note else 12)
    if note:
        axes.text(0.0, 1.025, note, transform=axes.transAxes, color=colors.quiet, fontsize=9.5, va="bottom")


def _line_color(colors: Theme, index: int) -> str:
    return colors.lines[index % len(colors.lines)]
