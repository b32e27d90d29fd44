"""One web page of a comparison that needs no network: plots to explore, tables to sort."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Iterable
from importlib import resources
from pathlib import Path
from typing import Any

from treelet.bench.compare.payoff import mean_curves, mean_ranges, scene_curves, scene_ranges, treelet_ranges
from treelet.bench.compare.plots import Style, dash_names, styles
from treelet.bench.compare.report import all_tables, facts
from treelet.bench.compare.results import KIND_NAMES, Results
from treelet.bench.compare.table import Cell, Table
from treelet.bench.compare.variant_tables import TALK_SHARES, size_families
from treelet.bench.effective import Range

_CODE = re.compile("`([^`]*)`")
_OPEN = ("overview", "rates", "sizes")  # tables shown without a click
# Markers as plotly calls them, by matplotlib's letters.
_MARKERS = {
    "o": "circle",
    "s": "square",
    "D": "diamond",
    "^": "triangle-up",
    "v": "triangle-down",
    "P": "cross",
    "X": "x",
    "<": "triangle-left",
    ">": "triangle-right",
    "p": "pentagon",
}


def write_page(results: Results, path: Path) -> Path:
    """Write the page, plotly's script within it; returns the path. Raises ImportError without plotly."""
    try:
        from plotly.offline import get_plotlyjs  # type: ignore[import-untyped]
    except ImportError as missing:
        raise ImportError("the page needs plotly: pip install 'treelet[compare]'") from missing
    parts = {
        "TITLE": html.escape(results.title),
        "STYLE": _asset("page.css"),
        "FACTS": "".join(f"<li>{html.escape(fact)}</li>" for fact in facts(results)),
        "TABLES": "\n".join(_table(table) for table in all_tables(results) if table.rows),
        "DATA": json.dumps(page_data(results), allow_nan=False).replace("<", "\\u003c"),
        "SCRIPT": _asset("page.js"),
        "PLOTLY": get_plotlyjs(),
    }
    page = _asset("page.html")
    for name, text in parts.items():  # plotly's last: it need not be searched for the others
        page = page.replace(f"<!--{name}-->", text)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(page, encoding="utf-8")
    return path


def page_data(results: Results) -> dict[str, Any]:
    """Every number that the page's plots show; matrices have a row a scene and a column a recipe."""
    labels, scenes = list(results.recipes), results.scenes
    return {
        "reference": results.reference,
        "kinds": [{"key": kind, "name": KIND_NAMES[kind]} for kind in results.kinds],
        "main": results.main_kind,
        "recipes": _recipes(results),
        "scenes": [
            {"name": name, "faces": scene.faces}
            for name, scene in zip(results.scene_names(), scenes, strict=True)
        ],
        "buildShares": [[scene.build_share(label) for label in labels] for scene in scenes],
        "shares": {
            kind: [[scene.share(label, kind) for label in labels] for scene in scenes]
            for kind in results.kinds
        },
        "curves": {kind: _curves(results, kind) for kind in results.kinds},
        "best": {kind: _best(results, kind) for kind in results.kinds},
        "talk": [[size, share] for size, share in TALK_SHARES.items()],
        "sizes": _sizes(results),
    }


def _recipes(results: Results) -> list[dict[str, str]]:
    drawn = styles(results)
    dashes = dash_names([drawn[label] for label in results.recipes])
    return [
        {"label": label, "recipe": text, "dash": dash, **_marks(drawn[label])}
        for (label, text), dash in zip(results.recipes.items(), dashes, strict=True)
    ]


def _marks(style: Style) -> dict[str, str]:
    return {"color": style.color, "marker": _MARKERS[style.marker]}


def _curves(results: Results, kind: str) -> dict[str, Any]:
    """Build seconds and rays a second, [label, seconds, rate] a scene, and who has a mean over scenes."""
    return {
        "mean": [curve.label for curve in mean_curves(results, kind)],
        "scenes": [
            [
                [curve.label, curve.build_seconds, curve.rays_per_second]
                for curve in scene_curves(results, scene, kind)
            ]
            for scene in results.scenes
        ],
    }


def _best(results: Results, kind: str) -> dict[str, Any]:
    """Ranges of the mean and of each scene: of the best recipe, and of any recipe with treelets."""
    mean = mean_ranges(mean_curves(results, kind))
    scenes = [scene_ranges(results, scene, kind) for scene in results.scenes]
    return {
        "mean": _as_lists(mean),
        "scenes": [_as_lists(ranges) for ranges in scenes],
        "treeletMean": _as_lists(treelet_ranges(results, mean)),
        "treeletScenes": [_as_lists(treelet_ranges(results, ranges)) for ranges in scenes],
    }


def _as_lists(ranges: Iterable[Range]) -> list[list[Any]]:
    return [[each.label, each.start, each.end] for each in ranges]


def _sizes(results: Results) -> list[dict[str, Any]]:
    """Families of recipes by treelet size, with geometric means of shares for each kind of rays."""
    return [
        {
            "name": family.pattern,
            "points": {
                kind: [
                    [variant.arguments["size"], share.geometric]
                    for variant in family.variants
                    if (share := results.share_means(variant.label, kind))
                ]
                for kind in results.kinds
            },
        }
        for family in size_families(results)
    ]


def _table(table: Table) -> str:
    """A table that sorts by its headings; means stay at the end."""
    best = table.best()
    headings = "".join(
        f'<th scope="col" class="{"text" if column.is_text else "figure"}">'
        f"<button type=button>{html.escape(column.heading)}</button></th>"
        for column in table.columns
    )
    rows = "\n".join(
        "<tr>"
        + "".join(_cell(table, cell, place, (number, place) in best) for place, cell in enumerate(row))
        + "</tr>"
        for number, row in enumerate(table.rows)
    )
    means = "\n".join(
        "<tr>" + "".join(_cell(table, cell, place, False) for place, cell in enumerate(row)) + "</tr>"
        for row in table.summary
    )
    return (
        f'<details id="{table.key}" {"open" if table.key in _OPEN else ""}>'
        f"<summary><h2>{html.escape(table.title)}</h2></summary>"
        f"<p>{_with_code(table.note)}</p><div class=scroll tabindex=0><table>"
        f"<thead><tr>{headings}</tr></thead><tbody>{rows}</tbody><tfoot>{means}</tfoot></table></div></details>"
    )


def _with_code(note: str) -> str:
    """HTML, with what stands in backquotes as code."""
    return _CODE.sub(r"<code>\1</code>", html.escape(note))


def _cell(table: Table, cell: Cell, place: int, is_best: bool) -> str:
    kind = "text" if table.columns[place].is_text else "figure"
    value = "" if cell.value is None else f' data-value="{cell.value!r}"'
    tag = 'th scope="row"' if place == 0 else "td"
    mark = " best" if is_best else ""
    return f'<{tag} class="{kind}{mark}"{value}>{html.escape(cell.text)}</{tag.split()[0]}>'


def _asset(name: str) -> str:
    return resources.files(__package__ or "").joinpath(name).read_text(encoding="utf-8")
