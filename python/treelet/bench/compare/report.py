"""The whole report: all tables as Markdown, the short ones for terminals, the numbers as JSON."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

from treelet.bench.compare.payoff import mean_curves, mean_ranges, scene_ranges, treelet_ranges
from treelet.bench.compare.payoff_tables import payoff_tables
from treelet.bench.compare.results import Results
from treelet.bench.compare.table import Table, to_markdown
from treelet.bench.compare.tables import overview, rates, scene_tables
from treelet.bench.compare.variant_tables import variant_tables
from treelet.bench.effective import Range


def all_tables(results: Results) -> list[Table]:
    """In the order of the report."""
    first = [overview(results), rates(results)]
    return [*first, *variant_tables(results), *payoff_tables(results), *scene_tables(results)]


def short_tables(results: Results) -> list[Table]:
    """Those with a row a recipe, which fit into a terminal."""
    payoff = [table for table in payoff_tables(results) if table.key == f"payoff_{results.main_kind}"]
    return [overview(results), rates(results), *variant_tables(results), *payoff]


def write_markdown(results: Results, path: Path) -> Path:
    """Write every table; returns the path."""
    lines = [f"# {results.title}", "", *(f"* {fact}" for fact in facts(results)), ""]
    for table in all_tables(results):
        lines += to_markdown(table)
    lines += ["## Recipes in full", ""]
    lines += [f"* {label}: `{text}`" for label, text in results.recipes.items()]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def facts(results: Results) -> Iterator[str]:
    """What was measured on what, and what was not, a line each."""
    yield f"{results.size}; reference: {results.reference}"
    yield from results.machines
    yield results.effort
    if results.noise:
        yield results.noise.sentence
    for name, found in (("skipped", results.skipped), ("failed", results.failed)):
        for each in found:
            place = ", ".join(each[key] for key in ("scene", "view", "label") if key in each)
            yield f"{name}: {place}: {each['reason']}"


def summary(results: Results) -> dict[str, Any]:
    """Means and ranges as JSON-able values."""
    return {
        "title": results.title,
        "reference": results.reference,
        "machines": results.machines,
        "scenes": [{"name": scene.name, "faces": scene.faces} for scene in results.scenes],
        "skipped": results.skipped,
        "failed": results.failed,
        "recipes": [_recipe(results, label) for label in results.recipes],
        "best": {kind: _best(results, kind) for kind in results.kinds},
    }


def _recipe(results: Results, label: str) -> dict[str, Any]:
    shares = {kind: results.share_means(label, kind) for kind in results.kinds}
    return {
        "label": label,
        "recipe": results.recipes[label],
        "share_of_reference": {kind: asdict(found) if found else None for kind, found in shares.items()},
        "build_of_reference": [scene.build_share(label) for scene in results.scenes],
        "sah": [scene.fact(label, "sah") for scene in results.scenes],
        "epo": [scene.fact(label, "epo") for scene in results.scenes],
    }


def _best(results: Results, kind: str) -> dict[str, Any]:
    ranges = mean_ranges(mean_curves(results, kind))
    per_scene = zip(results.scene_names(), results.scenes, strict=True)
    return {
        "all_scenes": _as_lists(ranges),
        "treelet": _as_lists(treelet_ranges(results, ranges)),
        "scenes": {name: _as_lists(scene_ranges(results, scene, kind)) for name, scene in per_scene},
    }


def _as_lists(ranges: list[Range]) -> list[dict[str, Any]]:
    return [{"label": each.label, "from": each.start, "to": each.end} for each in ranges]
