"""Tables and plots of what `python -m treelet.bench.gpu` measured, from its lines alone.

python -m treelet.bench.gpu.report gpu.jsonl [--goals] [--plots FOLDER] [--resources FILE] [--counters FILE]
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from treelet.bench.gpu.effective import choose_curves, effective_tables, share_table
from treelet.bench.gpu.goals import goal_table
from treelet.bench.gpu.kernels import counter_table, read_counters, read_resources, resource_table
from treelet.bench.gpu.results import Results, Scene, read_results
from treelet.bench.gpu.tables import sections


def report(results: Results) -> Iterator[str]:
    """Markdown, a line each: goals first, then what was measured."""
    yield from section("Measured on", [f"* {machine}" for machine in results.machines])
    yield from section("Goals", goal_table(results))
    if results.copy_rate:
        yield from section("Copies", [f"{results.copy_rate / 1e12:.2f} TB/s, read and written bytes."])
    for heading, lines in sections(results):
        yield from section(heading, lines)
    yield from section(
        "Share of the best effective rate, diffuse rays, mean over scenes, %", share_table(results)
    )
    for kind in ("diffuse", "primary"):
        yield from section(f"Effective performance, {kind} rays", effective_tables(results, kind))


def section(heading: str, lines: Sequence[str]) -> Iterator[str]:
    """Nothing without lines."""
    if lines:
        yield from (f"## {heading}", "", *lines, "")


def draw_plots(results: Results, folder: Path, kind: str = "diffuse") -> Iterator[Path]:
    """Effective performance of every scene that has builds and rays, as effective-SCENE-TRIANGLES.png."""
    from treelet.plots import plot_effective

    for scene in results.scenes:
        curves = choose_curves(scene.curves(kind))
        if curves:
            path = folder / f"effective-{scene.name}-{scene.faces}.png"
            yield plot_effective(curves, path, scene.name, _note(scene, kind))


def _note(scene: Scene, kind: str) -> str:
    each = scene.of_kind(kind, "rays")[-1]
    note = f"{each.machine.get('gpu', '')}, {scene.faces:,} triangles, {each.rays:,} {kind} rays"
    return note + "; (CPU): built on the processor"


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the report; 2 for files that cannot be read."""
    parser = argparse.ArgumentParser(
        prog="python -m treelet.bench.gpu.report", description=(__doc__ or "").splitlines()[0]
    )
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--goals", action="store_true", help="the table of goals alone")
    parser.add_argument("--plots", type=Path, metavar="FOLDER", help="draw effective performance into it")
    parser.add_argument("--resources", type=Path, help="what tools/kernel_resources.py --json printed")
    parser.add_argument("--counters", type=Path, help="what Nsight Compute wrote (tools/gpu.py profile)")
    options = parser.parse_args(arguments)
    try:
        results = read_results(options.files)
        lines = goal_table(results) if options.goals else list(report(results))
        if options.resources:
            lines += section("Registers", resource_table(read_resources(options.resources)))
        if options.counters:
            counters = read_counters(options.counters)
            lines += section("Kernels", counter_table(counters, results.copy_rate))
        if options.plots:
            lines += section("Plots", [f"* {path}" for path in draw_plots(results, options.plots)])
    except (ImportError, OSError, ValueError) as error:
        parser.error(str(error))
    print("\n".join(lines))  # noqa: T201
    return 0


if __name__ == "__main__":
    sys.exit(main())
