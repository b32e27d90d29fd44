"""Tables of recipes that differ in one setting: sizes of treelets, rounds and gamma, budgets of splits."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from treelet.bench.compare.results import KIND_NAMES, Results
from treelet.bench.compare.table import Cell, Column, Table, figure, geometric, percent, text, whole
from treelet.bench.compare.variants import Family, families

# Rays/s as a share of SBVH's on Soda Hall, 2.2M triangles, by treelet size: the talk that T. Karras gave on
# [KarrasAila2013] at High-Performance Graphics 2013.
TALK_SHARES = {4: 0.78, 5: 0.85, 6: 0.88, 7: 0.97, 8: 0.98}
_SPLITTERS = ("presplit", "sbvh")


def size_families(results: Results) -> list[Family]:
    """Recipes alike but for the size of treelets and what gamma follows from it."""
    return families(results.recipes, "treelet", ("size", "gamma"), "size")


def round_families(results: Results) -> list[Family]:
    """Recipes alike but for rounds and gamma."""
    found = families(results.recipes, "treelet", ("rounds", "gamma"), "rounds")
    patterns = {family.pattern for family in found}
    by_gamma = families(results.recipes, "treelet", ("rounds", "gamma"), "gamma")
    return [*found, *(family for family in by_gamma if family.pattern not in patterns)]


def budget_families(results: Results) -> list[Family]:
    """Recipes alike but for the budget of a word that splits triangles."""
    return [
        family for word in _SPLITTERS for family in families(results.recipes, word, ("budget",), "budget")
    ]


def variant_tables(results: Results) -> list[Table]:
    """Those that the suite has recipes for."""
    tables = [_size_table(results, family) for family in size_families(results)]
    tables += [
        _table(
            results,
            family,
            f"rounds-{number}",
            "Rounds and gamma",
            "Gamma is how many triangles a subtree must have for its root to be a treelet's, in the first "
            "round; each later one doubles it. 0 stands for the treelet size.",
        )
        for number, family in enumerate(round_families(results))
    ]
    tables += [
        _table(
            results,
            family,
            f"budget-{number}",
            f"Split budgets of `{family.word}`",
            "References that splitting may add, in % of the triangles.",
        )
        for number, family in enumerate(budget_families(results))
    ]
    return tables


def _size_table(results: Results, family: Family) -> Table:
    """The talk's figures beside ours."""
    base = _table(
        results,
        family,
        "sizes",
        "Treelet sizes",
        "The talk's column: rays/s as a share of SBVH's on Soda Hall, 2.2 million triangles, on a GPU "
        "(T. Karras, High-Performance Graphics 2013). Other scenes, other machine: compare how the figures "
        "grow with the size, not the figures.",
    )
    talk = [TALK_SHARES.get(each.arguments["size"]) for each in family.variants]
    rows = tuple((*row, figure(share, percent)) for row, share in zip(base.rows, talk, strict=True))
    return Table(base.key, base.title, base.note, (*base.columns, Column("talk, Soda Hall %")), rows)


def _table(results: Results, family: Family, key: str, title: str, note: str) -> Table:
    names = list(family.variants[0].arguments)
    columns = [Column("recipe", is_text=True), *(Column(name) for name in names)]
    columns += [Column("build", better="low"), Column("SAH", better="low")]
    columns += [Column("EPO", better="low")]
    columns += [Column(f"{KIND_NAMES[kind]} %", better="high") for kind in results.kinds]
    if "budget" in names:
        columns.append(Column("references"))
    rows = tuple(
        (
            text(each.label),
            *(figure(each.arguments[name], whole) for name in names),
            *_measures(results, each.label, names),
        )
        for each in family.variants
    )
    words = (
        f"`{family.pattern}` against {results.reference} (= 1, 100 %), geometric means over scenes. {note}"
    )
    return Table(key, title, words, tuple(columns), rows)


def _measures(results: Results, label: str, names: Sequence[str]) -> Iterable[Cell]:
    yield geometric(scene.build_share(label) for scene in results.scenes)
    for fact in ("sah", "epo"):
        yield geometric(scene.fact_share(label, fact) for scene in results.scenes)
    for kind in results.kinds:
        found = results.share_means(label, kind)
        yield figure(found.geometric if found else None, percent)
    if "budget" in names:
        yield geometric(scene.fact_share(label, "references") for scene in results.scenes)
