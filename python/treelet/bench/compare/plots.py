"""Pictures of a comparison, drawn with matplotlib."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from treelet.bench.compare.payoff import mean_curves, mean_ranges
from treelet.bench.compare.results import KIND_NAMES, Results, means
from treelet.bench.compare.variant_tables import TALK_SHARES, size_families
from treelet.bench.effective import FEWEST_RAYS, MOST_RAYS
from treelet.plots.effective import ray_count_text
from treelet.plots.style import LIGHT, figure

_DASHES = ("solid", (0, (5, 2)), (0, (1.2, 1.6)), (0, (6, 1.5, 1.2, 1.5)))
_MARK_EVERY = 25  # points of a line
_MARKERS = "osD^vPX<>p"
_COLORS = ("#0067a8", "#e08a00", "#009e73", "#cc4c8a", "#56b4e9", "#7a7f8c", "#a5421f", "#6b4fa0")


class Style(NamedTuple):
    """How a recipe is drawn in every plot: colours repeat with another dash and marker."""

    color: str
    dash: Any
    marker: str


def styles(results: Results) -> dict[str, Style]:
    """By label. The reference is black."""
    others = [label for label in results.recipes if label != results.reference]
    found = {results.reference: Style(LIGHT.ink, "solid", "s")}
    for index, label in enumerate(others):
        turn = index // len(_COLORS)
        dash, marker = _DASHES[turn % len(_DASHES)], _MARKERS[index % len(_MARKERS)]
        found[label] = Style(_COLORS[index % len(_COLORS)], dash, marker)
    return found


def write_plots(results: Results, folder: Path) -> list[Path]:
    """Draw what there are measurements for. Raises ImportError without matplotlib."""
    kind = results.main_kind
    files = [_draw_shares(results, kind, folder / "shares.png")]
    if mean_curves(results, kind):
        files.append(_draw_payoff(results, kind, folder / "effective.png"))
    if any(scene.build(results.reference) for scene in results.scenes):
        files.append(_draw_cost(results, kind, folder / "build-and-rate.png"))
    if size_families(results):
        files.append(_draw_sizes(results, kind, folder / "treelet-sizes.png"))
    return files


def _draw_payoff(results: Results, kind: str, path: Path) -> Path:
    """Effective performance over scenes, the best recipe's name along the top."""
    curves, drawn = mean_curves(results, kind), styles(results)
    rays = np.geomspace(FEWEST_RAYS, MOST_RAYS, 200)
    with figure(path, LIGHT, 10.4, 5.8) as (_, axes):
        top, lowest = 0.0, 100.0
        for number, curve in enumerate(curves):
            values = [100.0 * curve.at(count) for count in rays]
            style = drawn[curve.label]
            axes.plot(
                rays,
                values,
                color=style.color,
                linestyle=style.dash,
                linewidth=1.9,
                marker=style.marker,
                markersize=5,
                markevery=(7 * number % _MARK_EVERY, _MARK_EVERY),  # apart, where lines are not
                label=curve.label,
            )
            top, lowest = max(top, *values), min(lowest, *values)
        axes.set_xscale("log")
        axes.set_xlim(FEWEST_RAYS, MOST_RAYS)
        bottom = max(0.0, 10.0 * (lowest // 10.0) - 5.0)
        axes.set_ylim(bottom, top + 0.14 * (top - bottom))
        ticks = 10.0 ** np.arange(6, 13)
        axes.set_xticks(ticks, [ray_count_text(tick) for tick in ticks])
        axes.tick_params(axis="x", which="minor", bottom=False)
        axes.set_xlabel("rays traced with one tree")
        axes.set_ylabel(f"effective rate, % of {results.reference}'s ray rate")
        _mark_best(axes, results, kind, drawn, top + 0.06 * (top - bottom))
        _title(axes, results, f"Which tree pays off? {KIND_NAMES[kind].capitalize()} rays, mean over scenes")
        _legend(axes)
    return path


def _mark_best(axes: Any, results: Results, kind: str, drawn: dict[str, Style], height: float) -> None:
    for best in mean_ranges(mean_curves(results, kind)):
        color = drawn[best.label].color
        axes.plot([best.start * 1.03, best.end / 1.03], [height, height], color=color, linewidth=4)
        if best.end / best.start > 6.0:
            middle = float(np.sqrt(best.start * best.end))
            axes.annotate(
                best.label,
                (middle, height),
                (0, 5),
                textcoords="offset points",
                color=color,
                ha="center",
                fontsize=9,
            )


def _draw_shares(results: Results, kind: str, path: Path) -> Path:
    """A line of marks a scene: every recipe's share of the reference's ray rate."""
    drawn = styles(results)
    names = results.scene_names()
    rows = np.arange(len(names))[::-1]
    with figure(path, LIGHT, 10.4, 2.2 + 0.32 * len(names)) as (_, axes):
        for label, style in drawn.items():
            if label == results.reference:
                continue
            shares = [scene.share(label, kind) for scene in results.scenes]
            axes.plot(
                [np.nan if share is None else 100.0 * share for share in shares],
                rows,
                style.marker,
                color=style.color,
                label=label,
                markersize=6,
                markeredgecolor=LIGHT.paper,
                markeredgewidth=0.5,
            )
        axes.axvline(100.0, color=LIGHT.ink, linewidth=1.2)
        axes.grid(axis="y")
        axes.set_yticks(rows, names)
        axes.set_ylim(-0.7, len(names) - 0.3)
        axes.set_xlabel(f"ray rate, % of {results.reference}'s")
        _title(axes, results, f"{KIND_NAMES[kind].capitalize()} rays, scene by scene")
        _legend(axes)
    return path


def _draw_cost(results: Results, kind: str, path: Path) -> Path:
    """Build time against ray rate, geometric means over scenes."""
    with figure(path, LIGHT, 10.4, 5.4) as (_, axes):
        for label, style in styles(results).items():
            build = means(scene.build_share(label) for scene in results.scenes)
            share = results.share_means(label, kind)
            if build and share:
                x, y = build.geometric, 100.0 * share.geometric
                axes.plot([x], [y], style.marker, color=style.color, markersize=9, label=label)
        axes.set_xscale("log")
        axes.margins(0.08)
        _count_plainly(axes.xaxis)
        axes.grid(axis="x")
        axes.set_xlabel(f"build time, × {results.reference}'s")
        axes.set_ylabel(f"{KIND_NAMES[kind]} rays, % of {results.reference}'s rate")
        _title(axes, results, "What a build buys: up and left is better")
        _legend(axes)
    return path


def _draw_sizes(results: Results, kind: str, path: Path) -> Path:
    """Ray rates by treelet size beside the talk's."""
    with figure(path, LIGHT, 8.4, 4.8) as (_, axes):
        sizes = list(TALK_SHARES)
        talk = [100.0 * share for share in TALK_SHARES.values()]
        axes.plot(sizes, talk, "--o", color=LIGHT.lines[2], label="talk, 2013: Soda Hall")
        for number, family in enumerate(size_families(results)):
            points = [
                (each.arguments["size"], 100.0 * share.geometric)
                for each in family.variants
                if (share := results.share_means(each.label, kind))
            ]
            x, y = zip(*points, strict=True) if points else ((), ())
            axes.plot(x, y, "-s", color=_COLORS[number % len(_COLORS)], label=family.pattern)
        axes.set_xticks(sizes)
        axes.set_xlabel("treelet size, leaves")
        axes.set_ylabel(f"{KIND_NAMES[kind]} rays, % of {results.reference}'s rate")
        _title(axes, results, "Treelet sizes")
        axes.legend(frameon=False, fontsize=9, loc="lower right")
    return path


def _title(axes: Any, results: Results, title: str) -> None:
    axes.set_title(title, loc="left", fontsize=13, fontweight="bold", pad=24)
    note = f"{results.title}: {results.size}. {'; '.join(results.machines)}"
    axes.text(
        0.0, 1.02, _shortened(note), transform=axes.transAxes, color=LIGHT.quiet, fontsize=8.5, va="bottom"
    )


def _shortened(note: str, most: int = 120) -> str:
    return note if len(note) <= most else note[: most - 1] + "…"


def _count_plainly(axis: Any) -> None:
    """1, 2, 5, 10 instead of powers of ten."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_locator(NullLocator())


def _legend(axes: Any) -> None:
    axes.legend(frameon=False, fontsize=9, loc="upper left", bbox_to_anchor=(1.01, 1.0), handlelength=2.6)


def dash_names(order: Sequence[Style]) -> list[str]:
    """The dashes as plotly calls them, so that pictures and page agree."""
    names = dict(zip(map(str, _DASHES), ("solid", "dash", "dot", "dashdot"), strict=True))
    return [names[str(style.dash)] for style in order]
