"""Print the tables of docs/benchmarks.md from committed measurements.

python tools/bench_table.py bench/results
"""

from __future__ import annotations

import json
import math
import statistics
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

REFERENCE = "sweep SAH"
LABELS = ("LBVH", "treelet")
HEADINGS = ["scene", "triangles", "SAH", "", "build", "", "primary", "", "diffuse", "", "occlusion", ""]


def read_scenes(folder: Path) -> list[dict[tuple[str, str], dict[str, Any]]]:
    """One dictionary a file, from (label, kind) to the measurement."""
    scenes = []
    for path in sorted(folder.glob("*.jsonl")):
        records = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
        scene = {(record["label"], record["kind"]): record for record in records}
        if (REFERENCE, "ambient_occlusion") in scene:
            scenes.append(scene)
    return scenes


def ratios(scene: dict[tuple[str, str], dict[str, Any]], label: str) -> list[float]:
    """SAH, build time and ray rates over the sweep's."""
    build, reference = scene[label, "build"], scene[REFERENCE, "build"]
    values = [build["details"]["sah"] / reference["details"]["sah"], median(build) / median(reference)]
    for kind in ("primary", "diffuse", "ambient_occlusion"):
        values.append(median(scene[REFERENCE, kind]) / median(scene[label, kind]))
    return values


def median(record: dict[str, Any]) -> float:
    """Seconds."""
    return statistics.median(record["samples"])


def rows(scenes: Iterable[dict[tuple[str, str], dict[str, Any]]]) -> list[list[str]]:
    """A row a scene and one of geometric means; two columns a figure, LBVH and treelet."""
    columns: list[list[float]] = []
    result = []
    for scene in scenes:
        first = scene[REFERENCE, "build"]
        values = [
            value for pair in zip(*(ratios(scene, label) for label in LABELS), strict=True) for value in pair
        ]
        columns.append(values)
        result.append([first["scene"], f"{first['faces']:,}", *(f"{value:.2f}" for value in values)])
    means = [
        math.exp(statistics.fmean(math.log(value) for value in column))
        for column in zip(*columns, strict=True)
    ]
    return [*result, ["**geometric mean**", "", *(f"**{mean:.2f}**" for mean in means)]]


def main(arguments: list[str]) -> None:
    """Read the folder that is named and print Markdown."""
    table = rows(read_scenes(Path(arguments[0])))
    print("| " + " | ".join(HEADINGS) + " |")
    print("|---|--:|" + "--:|" * (len(HEADINGS) - 2))
    print("| | |" + " LBVH | treelet |" * ((len(HEADINGS) - 2) // 2))
    for row in table:
        print("| " + " | ".join(row) + " |")


if __name__ == "__main__":
    main(sys.argv[1:])
