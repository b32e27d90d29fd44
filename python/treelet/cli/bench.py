"""`treelet bench`: measure recipes over scenes into JSON lines."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from treelet.cli.options import JsonOption, SeedOption, SizeOption, ThreadsOption, TrianglesOption

_DEFAULT_TRIANGLES = 200_000


def bench(
    meshes: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="MESH...", help="Files or scenes; all embedded and external scenes where none is given."
        ),
    ] = None,
    recipes: Annotated[
        list[str] | None,
        typer.Option(
            "--recipe",
            "-r",
            metavar="TEXT",
            help="Recipe to measure, repeatable; LBVH, treelet and sweep if none.",
        ),
    ] = None,
    out: Annotated[
        Path, typer.Option("--out", metavar="FOLDER", help="Where the .jsonl files are written.")
    ] = Path("bench/results"),
    triangles: TrianglesOption = None,
    size: SizeOption = "1024x640",
    builds: Annotated[int, typer.Option(metavar="N", min=1, help="Builds of each tree.")] = 5,
    repeats: Annotated[int, typer.Option(metavar="N", min=1, help="Times each set of rays is traced.")] = 7,
    seed: SeedOption = 0,
    threads: ThreadsOption = 0,
    json: JsonOption = False,
) -> None:
    """Measure build times and ray rates of recipes, one file of JSON lines a scene."""
    from treelet.bench.measure import RAY_KINDS, Plan
    from treelet.bench.suite import run_suite, summary
    from treelet.cli.inputs import parse_size, use_threads
    from treelet.cli.output import note, print_json, progress_bar

    use_threads(threads)
    width, height = parse_size(size)
    plan = Plan(_candidates(recipes), RAY_KINDS, width, height, builds, repeats, seed=seed)
    names = meshes or _all_scenes()
    rows = []
    with progress_bar("bench", plan.steps * len(names)) as bar:
        for path, result in run_suite(_loaded(names, triangles, seed), plan, out, bar.begin):
            note(f"wrote {path}")
            rows += summary(result)
    if json:
        print_json(rows)
        return
    _print_rows(rows)


def _candidates(recipes: list[str] | None) -> tuple:
    import treelet
    from treelet.bench.measure import Candidate
    from treelet.bench.suite import STANDARD_CANDIDATES

    if not recipes:
        return STANDARD_CANDIDATES
    return tuple(Candidate(text, treelet.parse_recipe(text)) for text in recipes)


def _all_scenes() -> list[str]:
    from treelet import scenes

    return list(dict.fromkeys([*scenes.names(), *scenes.external_names()]))


def _loaded(names: list[str], triangles: int | None, seed: int):
    """Meshes one after the other, so that only one is in memory at a time."""
    from treelet import scenes
    from treelet.cli.inputs import load_subject

    for name in names:
        wanted = (triangles or _DEFAULT_TRIANGLES) if name in scenes.names() else None
        yield load_subject(name, wanted, seed)


def _print_rows(rows: list[dict[str, Any]]) -> None:
    from treelet.cli.output import print_table
    from treelet.cli.text import count, milliseconds

    kinds = list(rows[0]["mrays_per_second"]) if rows else []
    headings = ["scene", ("triangles", "right"), "recipe", ("build ms", "right"), ("SAH", "right")]
    headings += [(f"{kind.replace('_', ' ')}", "right") for kind in kinds]
    cells = [
        [
            row["scene"],
            count(row["faces"]),
            row["label"],
            milliseconds(row["build_ms"] / 1e3),
            f"{row['sah']:.1f}",
            *(f"{row['mrays_per_second'][kind]:.2f}" for kind in kinds),
        ]
        for row in rows
    ]
    print_table("Builds and Mrays/s", headings, cells)
