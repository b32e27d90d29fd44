"""The one table of `treelet demo`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from treelet.bench.effective import Curve, best_ranges
from treelet.bench.records import Measurement
from treelet.bench.suite import REFERENCE_LABEL
from treelet.cli.output import print_table
from treelet.cli.text import count, mega, milliseconds
from treelet.plots.effective import ray_count_text

RAY_COUNTS = tuple(10**power for power in range(6, 13))  # 1M to 1T


def demo_rows(measurements: Sequence[Measurement]) -> list[dict[str, Any]]:
    """One JSON-able row a recipe."""
    of_label: dict[str, dict[str, Measurement]] = {}
    for measurement in measurements:
        of_label.setdefault(measurement.label, {})[measurement.kind] = measurement
    reference = of_label[REFERENCE_LABEL]["diffuse"].rays_per_second
    return [_row(label, kinds, reference) for label, kinds in of_label.items()]


def _row(label: str, kinds: dict[str, Measurement], reference: float) -> dict[str, Any]:
    build, diffuse = kinds["build"], kinds["diffuse"].rays_per_second
    curve = Curve(label, build.seconds, diffuse)
    return {
        "label": label,
        "recipe": build.recipe,
        "build_seconds": build.seconds,
        "sah": build.details["sah"],
        "epo": build.details["epo"],
        "primary_rays_per_second": kinds["primary"].rays_per_second,
        "diffuse_rays_per_second": diffuse,
        "share_of_sweep": diffuse / reference,
        "effective_rays_per_second": {ray_count_text(rays): curve.at(rays) for rays in RAY_COUNTS},
    }


def print_demo_table(subject: Any, rows: Sequence[dict[str, Any]]) -> None:
    """Print it, the best figure of each column in bold green."""
    headings = [
        "tree",
        "build ms",
        "SAH",
        "EPO",
        "primary",
        "diffuse",
        "of sweep",
        *rows[0]["effective_rays_per_second"],
    ]
    figures = [_figures(row) for row in rows]
    best = [min, min, min, max, max, max, *[max] * len(RAY_COUNTS)]
    winners = [
        choose(column)
        for choose, column in zip(best, zip(*(values for values, _ in figures), strict=True), strict=True)
    ]
    cells = [
        [
            row["label"],
            *(
                _marked(text, value == winner)
                for value, text, winner in zip(values, texts, winners, strict=True)
            ),
        ]
        for row, (values, texts) in zip(rows, figures, strict=True)
    ]
    size = f"{subject.name}: {count(len(subject.faces))} triangles"
    title = f"{size}. Rates in Mrays/s, the last ones with the build, by rays traced"
    columns = [headings[0], *((heading, "right") for heading in headings[1:])]
    print_table(title, columns, cells, caption=_verdict(rows))


def _figures(row: dict[str, Any]) -> tuple[list[float], list[str]]:
    rates = [row["primary_rays_per_second"], row["diffuse_rays_per_second"]]
    effective = list(row["effective_rays_per_second"].values())
    values = [row["build_seconds"], row["sah"], row["epo"], *rates, row["share_of_sweep"], *effective]
    texts = [
        milliseconds(row["build_seconds"]),
        f"{row['sah']:.1f}",
        f"{row['epo']:.2f}",
        *map(mega, rates),
        f"{100.0 * row['share_of_sweep']:.0f} %",
        *map(mega, effective),
    ]
    return values, texts


def _marked(text: str, is_best: bool) -> str | tuple[str, str]:
    return (text, "bold green") if is_best else text


def _verdict(rows: Sequence[dict[str, Any]]) -> str:
    """'Best from 1M to 79M rays: treelet; ...'"""
    curves = [Curve(row["label"], row["build_seconds"], row["diffuse_rays_per_second"]) for row in rows]
    ranges = [
        f"{each.label} from {ray_count_text(each.start)} to {ray_count_text(each.end)} rays"
        for each in best_ranges(curves)
    ]
    return f"Best for diffuse rays: {', '.join(ranges)}."
