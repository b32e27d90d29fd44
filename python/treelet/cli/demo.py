"""`treelet demo`: the main job from mesh to verdict."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from treelet.cli.options import (
    JsonOption,
    OptionalMeshArgument,
    OutFolderOption,
    SeedOption,
    SizeOption,
    ThreadsOption,
    TrianglesOption,
    ViewOption,
)

_SCENE = "city"
_TRIANGLES = 500_000
_HEAT_SHARE = 0.75  # size of one heat map against the picture's: two lie side by side


def demo(
    mesh: OptionalMeshArgument = None,
    scene: Annotated[str, typer.Option(metavar="NAME", help="Scene where no MESH is given.")] = _SCENE,
    triangles: TrianglesOption = None,
    out: OutFolderOption = Path("out"),
    view: ViewOption = None,
    size: SizeOption = "960x600",
    samples: Annotated[int, typer.Option("--samples", "-s", metavar="N", min=1, help="Paths a pixel.")] = 12,
    repeats: Annotated[int, typer.Option(metavar="N", min=1, help="Times each set of rays is traced.")] = 3,
    seed: SeedOption = 0,
    threads: ThreadsOption = 0,
    json: JsonOption = False,
) -> None:
    """Build LBVH, treelet and sweep-SAH trees, compare them, and write pictures and a plot."""
    from treelet.bench import Plan, measure, write_measurements
    from treelet.bench.suite import STANDARD_CANDIDATES
    from treelet.cli.demo_table import demo_rows, print_demo_table
    from treelet.cli.inputs import choose_view, load_subject, parse_size, use_threads
    from treelet.cli.output import print_json, progress_bar

    use_threads(threads)
    width, height = parse_size(size)
    subject = load_subject(mesh or scene, _triangle_count(mesh, scene, triangles), seed)
    camera = choose_view(subject, view, width / height)
    plan = Plan(STANDARD_CANDIDATES, width=width, height=height, repeats=repeats, seed=seed)
    with progress_bar("measure", plan.steps) as bar:
        result = measure(subject, camera, plan, bar.begin)
    rows = demo_rows(result.measurements)
    if not json:
        print_demo_table(subject, rows)
    files = [write_measurements(out / "measurements.jsonl", result.measurements)]
    files += _write_pictures(result.bvhs, subject, camera, (width, height, samples, seed), out)
    files.append(_write_plot(result.measurements, subject, out))
    _report_files(files)
    if json:
        print_json(
            {
                "scene": subject.name,
                "faces": len(subject.faces),
                "rows": rows,
                "files": [str(file) for file in files],
            }
        )


def _triangle_count(mesh: str | None, scene: str, triangles: int | None) -> int | None:
    """The demo's own size for embedded scenes, and none for files, which have theirs."""
    from treelet import scenes

    return _TRIANGLES if triangles is None and (mesh or scene) in scenes.names() else triangles


def _write_pictures(
    bvhs: dict[str, Any], subject: Any, camera: Any, picture: tuple[int, int, int, int], out: Path
) -> list[Path]:
    from treelet.cli.output import progress_bar
    from treelet.render import RenderSettings, render, save_png
    from treelet.render.heat import render_heat_pair

    width, height, samples, seed = picture
    with progress_bar("picture") as bar:
        colors = render(
            bvhs["treelet"], subject, camera, "path", RenderSettings(width, height, samples, 3, seed), bar.at
        )
    small = RenderSettings(
        max(1, round(_HEAT_SHARE * width)), max(1, round(_HEAT_SHARE * height)), min(samples, 4), seed=seed
    )
    labels = ["LBVH", "treelet"]
    with progress_bar("heat map") as bar:
        heat = render_heat_pair([bvhs[label] for label in labels], labels, subject, camera, small, bar.at)
    return [save_png(out / "picture.png", colors), save_png(out / "heat.png", heat)]


def _write_plot(measurements: list, subject: Any, out: Path) -> Path:
    from treelet.bench import curves_of
    from treelet.plots import plot_effective

    first = measurements[0]
    note = f"diffuse rays, {first.threads} threads, {first.machine['cpu']}"
    return plot_effective(
        curves_of(measurements),
        out / "effective.png",
        f"{subject.name}, {len(subject.faces):,} triangles",
        note,
    )


def _report_files(files: list[Path]) -> None:
    from treelet.cli.output import note

    for file in files:
        note(f"wrote {file}")
