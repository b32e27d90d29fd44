"""`treelet compare`: a suite of scenes and recipes measured, compared and reported."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from treelet.cli.errors import CHECK_FAILED
from treelet.cli.options import JsonOption, ThreadsOption


def compare(
    suite: Annotated[
        Path | None,
        typer.Argument(metavar="SUITE.toml", help="What to measure, such as bench/suites/quick.toml."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="FOLDER", help="Lines and report; out/compare/SUITE if not given."),
    ] = None,
    report_only: Annotated[
        Path | None,
        typer.Option(
            "--report-only", metavar="FOLDER", help="Measure nothing: report a folder's lines again."
        ),
    ] = None,
    scenes: Annotated[
        str | None,
        typer.Option("--scenes", metavar="NAMES", help="These scenes of the suite alone, commas between."),
    ] = None,
    rays: Annotated[
        int | None, typer.Option("--rays", metavar="N", min=1, help="Camera rays a view, not the suite's.")
    ] = None,
    repeats: Annotated[
        int | None, typer.Option("--repeats", metavar="N", min=1, help="Timed traces, not the suite's.")
    ] = None,
    builds: Annotated[
        int | None, typer.Option("--builds", metavar="N", min=1, help="Timed builds, not the suite's.")
    ] = None,
    estimate: Annotated[
        bool, typer.Option("--estimate", help="Say what there is to measure and how long it takes, and stop.")
    ] = False,
    threads: ThreadsOption = 0,
    json: JsonOption = False,
) -> None:
    """Measure a suite of recipes over scenes, or go on where a run stopped; write tables, plots, a page."""
    from treelet.cli.inputs import use_threads

    if report_only is not None:
        if suite is not None or out is not None:
            raise ValueError("--report-only FOLDER measures nothing: leave SUITE.toml and --out away")
        _report(report_only, 0, is_json=json)
        return
    use_threads(threads)
    chosen = _chosen_suite(suite, scenes, {"rays": rays, "repeats": repeats, "builds": builds})
    folder = out or Path("out/compare") / (suite or Path()).stem
    failures = _measure(chosen, folder, is_estimate=estimate)
    if not estimate:
        _report(folder, failures, is_json=json)
    if failures:
        raise typer.Exit(CHECK_FAILED)


def _chosen_suite(path: Path | None, scenes: str | None, overrides: dict[str, Any]) -> Any:
    from dataclasses import replace

    from treelet.bench.compare import load_suite

    if path is None:
        raise ValueError(
            "give a suite, such as `treelet compare bench/suites/quick.toml`, or --report-only FOLDER"
        )
    suite = replace(load_suite(path), **{key: value for key, value in overrides.items() if value is not None})
    names = [name.strip() for name in (scenes or "").split(",") if name.strip()]
    return suite.chosen(names) if names else suite


def _measure(suite: Any, folder: Path, *, is_estimate: bool) -> int:
    """Say what there is to do, and do it unless only that was wanted; returns the number of failures."""
    from treelet.bench.compare import Forecast, find_work, open_journal, run_session
    from treelet.cli.output import note, progress_bar

    journal = open_journal(folder)
    surveyed = _survey(suite)
    work = {scene: find_work(suite, scene, journal.rows) for scene in surveyed if scene.is_there}
    forecast = Forecast(_expected_seconds(suite, work))
    if is_estimate:
        return 0
    with progress_bar("compare", sum(each.steps(suite) for each in work.values())) as bar:
        failures = run_session(
            suite, surveyed, journal, bar.begin, lambda scene: _note_finished(scene, forecast)
        )
    for failure in failures:
        note(f"treelet: failed: {failure.sentence}")
    if not journal.rows and not failures:
        raise ValueError(f"nothing to compare: none of the scenes of {suite.title!r} is there")
    return len(failures)


def _survey(suite: Any) -> list[Any]:
    """Every scene looked at; a note names those that are not there."""
    from treelet.bench.compare import survey
    from treelet.cli.output import note, progress_bar

    with progress_bar("look at scenes", len(suite.scenes)) as bar:
        surveyed = survey(suite, bar.begin)
    for reason in dict.fromkeys(scene.absent for scene in surveyed if scene.absent):
        names = ", ".join(scene.choice.mesh for scene in surveyed if scene.absent == reason)
        note(f"skipped, {reason}: {names}")
    return surveyed


def _expected_seconds(suite: Any, work: dict[Any, Any]) -> dict[Any, float]:
    """By scene, of those with something left to measure; a note tells the sum."""
    from treelet.bench.compare import describe_seconds, scene_seconds, try_recipes
    from treelet.cli.output import note, progress_bar

    left = {scene: each for scene, each in work.items() if each.trees}
    if not left:
        note(f"{suite.title}: nothing is left to measure")
        return {}
    with progress_bar("try recipes") as bar:
        trials = try_recipes(suite, bar.begin)
    expected = {scene.choice: scene_seconds(suite, scene, each, trials) for scene, each in left.items()}
    done = f" ({len(work) - len(left)} done before)" if len(left) < len(work) else ""
    duration = describe_seconds(sum(expected.values()))
    note(f"{suite.title}: scenes: {len(left)}{done}, recipes: {len(suite.candidates)}, about {duration}")
    return expected


def _note_finished(scene: Any, forecast: Any) -> None:
    from treelet.bench.compare import describe_seconds
    from treelet.cli.output import note

    left = forecast.finish(scene.choice)
    if left is not None:
        note(f"measured {scene.choice.mesh}" + (f", about {describe_seconds(left)} left" if left else ""))


def _report(folder: Path, failures: int, *, is_json: bool) -> None:
    """Write the report of a folder's lines, and print the short tables or the summary."""
    from treelet.bench.compare import open_journal, read_results, short_tables, summary
    from treelet.cli.output import note, print_json

    if failures and not open_journal(folder).rows:
        return
    results = read_results(folder)
    files = _write_report(results, folder)
    if is_json:
        print_json(summary(results) | {"files": [str(file) for file in files], "failures": failures})
    else:
        for table in short_tables(results):
            _print(table)
    for file in files:
        note(f"wrote {file}")


def _write_report(results: Any, folder: Path) -> list[Path]:
    """Tables, plots and the page; what lacks a package is left out, and a note says which."""
    from treelet.bench.compare import write_markdown, write_page, write_plots
    from treelet.cli.output import note

    files = [write_markdown(results, folder / "report.md")]
    try:
        files += write_plots(results, folder)
    except ImportError as missing:
        note(f"treelet: no plots: {missing}")
    try:
        files.append(write_page(results, folder / "report.html"))
    except ImportError as missing:
        note(f"treelet: no report.html: {missing}")
    return files


def _print(table: Any) -> None:
    from treelet.cli.output import print_table

    best = table.best()
    columns = [column.heading if column.is_text else (column.heading, "right") for column in table.columns]
    rows: list[list[Any]] = [
        [
            (cell.text, "bold green") if (number, place) in best else cell.text
            for place, cell in enumerate(row)
        ]
        for number, row in enumerate(table.rows)
    ]
    rows += [[(cell.text, "bold") for cell in row] for row in table.summary]
    if rows:
        print_table(table.title, columns, rows, caption=table.note)
