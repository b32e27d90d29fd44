"""The tables about recipes and scenes: what a tree costs to build, and what its rays are worth."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from treelet.bench.compare.results import KIND_NAMES, Results, SceneResult
from treelet.bench.compare.table import (
    Cell,
    Column,
    Table,
    figure,
    geometric,
    hundredths,
    percent,
    tenths,
    text,
    whole,
)

Measure = Callable[[SceneResult, str], float | None]
_MEANS = ("arithmetic", "geometric")
_WORK = (("nodes_per_ray", "nodes"), ("triangles_per_ray", "triangles"))


def overview(results: Results) -> Table:
    """A row a recipe: what its trees cost and are like, geometric means over scenes."""
    columns = [Column("recipe", is_text=True), Column("scenes")]
    columns += [Column("build", better="low"), Column("Mtri/s", better="high")]
    columns += [Column(name, better="low") for name in ("SAH", "EPO", "nodes", "triangles", "bytes")]
    note = (
        f"Geometric means over scenes, each against {results.reference} (= 1), lower is better; but Mtri/s: "
        "triangles over build time. Nodes and triangles: what a "
        f"{KIND_NAMES[results.main_kind]} ray visits, comparable within one layout."
    )
    rows = tuple(tuple(_overview_row(results, label)) for label in results.recipes)
    return Table("overview", "Recipes", note, tuple(columns), rows)


def _overview_row(results: Results, label: str) -> Iterable[Cell]:
    builds = [(scene.faces, build.seconds) for scene in results.scenes if (build := scene.build(label))]
    yield text(label)
    yield figure(len(builds), whole)
    yield geometric(scene.build_share(label) for scene in results.scenes)
    yield figure(_build_rate(builds), hundredths)
    yield geometric(scene.fact_share(label, "sah") for scene in results.scenes)
    yield geometric(scene.fact_share(label, "epo") for scene in results.scenes)
    for name, _ in _WORK:
        yield geometric(_work_share(scene, label, results.main_kind, name) for scene in results.scenes)
    yield geometric(scene.fact_share(label, "bytes") for scene in results.scenes)


def rates(results: Results) -> Table:
    """A row a recipe: shares of the reference's ray rates, means and extremes over scenes."""
    columns = [Column("recipe", is_text=True)]
    for kind in results.kinds:
        columns += [Column(KIND_NAMES[kind], better="high"), Column("geo.", better="high")]
    columns += [Column("least", better="high"), Column("most", better="high")]
    note = (
        f"Rays/s as a share of {results.reference}'s, %: arithmetic mean over scenes, then geometric mean; "
        f"least and most of a scene, {KIND_NAMES[results.main_kind]} rays. The same rays in turns within one "
        "session, all views of a scene together."
    )
    rows = tuple(
        (
            text(label),
            *(cell for kind in results.kinds for cell in _rates_of(results, label, kind, _MEANS)),
            *_rates_of(results, label, results.main_kind, ("least", "most")),
        )
        for label in results.recipes
    )
    return Table("rates", "Ray rates", note, tuple(columns), rows)


def _rates_of(results: Results, label: str, kind: str, names: Sequence[str]) -> Iterable[Cell]:
    found = results.share_means(label, kind)
    for name in names:
        yield figure(getattr(found, name) if found else None, percent)


def _build_rate(builds: Sequence[tuple[int, float]]) -> float | None:
    """Millions of triangles a second over all scenes together."""
    seconds = sum(time for _, time in builds)
    return sum(faces for faces, _ in builds) / seconds / 1e6 if seconds else None


def _work_share(scene: SceneResult, label: str, kind: str, name: str) -> float | None:
    own, other = scene.work(label, kind, name), scene.work(scene.reference, kind, name)
    return own / other if own is not None and other else None


def scene_tables(results: Results) -> list[Table]:
    """A row a scene, a column a recipe: shares of rates, then what they come from."""
    tables = [_share_table(results, kind) for kind in results.kinds]
    tables += [_build_table(results), _fact_table(results, "sah", "SAH cost", tenths)]
    tables.append(_fact_table(results, "epo", "End-point overlap", hundredths))
    return tables + [_work_table(results, name, words) for name, words in _WORK]


def _fact_table(results: Results, name: str, title: str, show: Callable[[float], str]) -> Table:
    def measure(scene: SceneResult, label: str) -> float | None:
        return scene.fact(label, name)

    return _scene_table(results, name, title, "Lower is better, within one scene.", measure, show, "low")


def _work_table(results: Results, name: str, words: str) -> Table:
    def measure(scene: SceneResult, label: str) -> float | None:
        return scene.work(label, results.main_kind, name)

    title = f"{words.capitalize()} that a {KIND_NAMES[results.main_kind]} ray visits"
    note = "Counts, the same on every machine: lower is better, within one layout."
    return _scene_table(results, name, title, note, measure, tenths, "low")


def _share_table(results: Results, kind: str) -> Table:
    reference = results.reference
    base = _scene_table(
        results,
        f"share_{kind}",
        f"{KIND_NAMES[kind].capitalize()} rays: rate as a share of {reference}, %",
        f"The same rays in turns within one session, all views of a scene together; {reference} in Mrays/s.",
        lambda scene, label: scene.share(label, kind),
        percent,
        "high",
    )
    rates = [figure(_mega(scene.rate(reference, kind)), hundredths) for scene in results.scenes]
    rows = tuple((*row[:2], rate, *row[2:]) for row, rate in zip(base.rows, rates, strict=True))
    columns = (*base.columns[:2], Column(f"{reference}, Mrays/s"), *base.columns[2:])
    found = {label: results.share_means(label, kind) for label in results.recipes}
    summary = tuple(
        (
            text(f"{name} mean"),
            Cell(""),
            Cell(""),
            *(figure(getattr(each, name) if each else None, percent) for each in found.values()),
        )
        for name in _MEANS
    )
    return Table(base.key, base.title, base.note, columns, rows, summary, across=True)


def _build_table(results: Results) -> Table:
    def milliseconds(scene: SceneResult, label: str) -> float | None:
        build = scene.build(label)
        return build.seconds * 1e3 if build else None

    note = "From arrays to a tree that can be traced, medians, ms."
    return _scene_table(results, "build", "Build time, ms", note, milliseconds, tenths, "low")


def _scene_table(
    results: Results,
    key: str,
    title: str,
    note: str,
    measure: Measure,
    show: Callable[[float], str],
    better: str,
) -> Table:
    columns = [Column("scene", is_text=True), Column("triangles")]
    columns += [Column(label, better=better) for label in results.recipes]
    rows = tuple(
        (
            text(name),
            figure(scene.faces, whole),
            *(figure(measure(scene, label), show) for label in results.recipes),
        )
        for name, scene in zip(results.scene_names(), results.scenes, strict=True)
    )
    return Table(key, title, note, tuple(columns), rows, across=True)


def _mega(value: float | None) -> float | None:
    return None if value is None else value / 1e6
