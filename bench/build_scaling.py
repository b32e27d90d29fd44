"""Time builds of the terrain in two sizes: what a triangle costs among many against among few.

python bench/build_scaling.py --out out/scaling [--sizes 1000000 50000000] [--builds 3]
"""

from __future__ import annotations

import argparse
from pathlib import Path

import treelet
from treelet import scenes
from treelet.bench import Measurement, write_measurements

RECIPES = ("fast", "balanced")


def measure(size: int, builds: int) -> list[Measurement]:
    """Builds of all recipes over one terrain, in turn, each in fresh memory."""
    mesh = scenes.make("terrain", size, 0)
    reports: dict[str, list[treelet.Report]] = {recipe: [] for recipe in RECIPES}
    for _ in range(builds):
        for recipe in RECIPES:
            reports[recipe].append(treelet.build(mesh.vertices, mesh.faces, recipe).report)
    return [
        Measurement(
            "build",
            "terrain",
            len(mesh.faces),
            recipe,
            found[0].recipe,
            [report.build_seconds for report in found],
            threads=treelet.thread_count(),
        )
        for recipe, found in reports.items()
    ]


def main() -> None:
    """Measure all sizes, print a line for each and write them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("out/scaling"))
    parser.add_argument("--sizes", type=int, nargs="+", default=[1_000_000, 50_000_000])
    parser.add_argument("--builds", type=int, default=3)
    arguments = parser.parse_args()
    lines = [line for size in arguments.sizes for line in measure(size, arguments.builds)]
    for line in lines:
        print(
            f"{line.label:9} {line.faces:>11,}  {1e9 * line.seconds / line.faces:6.1f} ms a million triangles"
        )
    write_measurements(arguments.out / "terrain.jsonl", lines)


if __name__ == "__main__":
    main()
