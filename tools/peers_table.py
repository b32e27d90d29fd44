"""Print what bench/peers measured, as Markdown: the goals scene by scene, and every contender's means.

python tools/peers_table.py out/peers [--fast LABEL] [--balanced LABEL] [--ours LABEL] [--theirs LABEL]

Rates over Embree's and build times over Embree's are of medians; compare only lines of one run. Where a tree
of ours and one by Embree's builder went through the same traversal, they get a table of their own.
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

LOW, HIGH, HIGH_PACKETS = "Embree LOW", "Embree HIGH", "Embree HIGH packets"
REFERENCES = {"LOW": LOW, "HIGH": HIGH, "packets": HIGH_PACKETS}  # in headings
KINDS = {"any hit": "ambient_occlusion"}  # whose heading is another word
OUR_TREE, THEIR_TREE = "sbvh > bvh8", "Embree HIGH's tree, budget 100"  # with as many splits
LONG_THIN = ("hospital_mep", "clinic")  # building models that need spatial splits: in means of their own


class Scene:
    """The measurements of one file."""

    def __init__(self, records: Iterable[dict[str, Any]]) -> None:
        self.records = {(record["label"], record["kind"]): record for record in records}
        first = next(iter(self.records.values()))
        self.name: str = first["scene"]
        self.faces: int = first["faces"]

    @property
    def labels(self) -> list[str]:
        """Of all that built a tree."""
        return [label for label, kind in self.records if kind == "build"]

    def seconds(self, label: str, kind: str) -> float | None:
        """The median; None where it was not measured."""
        record = self.records.get((label, kind))
        return None if record is None else statistics.median(record["samples"])

    def speed(self, label: str, reference: str, kind: str) -> float | None:
        """How many times as fast as the reference."""
        return divided(self.seconds(reference, kind), self.seconds(label, kind))

    def detail(self, label: str, kind: str, name: str) -> float | None:
        """What the line says besides times; None where it does not."""
        record = self.records.get((label, kind))
        return None if record is None else record["details"].get(name)

    def work(self, label: str, detail: str) -> float | None:
        """What a diffuse ray takes, "nodes_per_ray" or "triangles_per_ray"; Embree does not count."""
        return self.detail(label, "diffuse", detail)

    def bytes_per_face(self, label: str, detail: str = "bytes") -> float | None:
        """Of the tree, or with "peak_bytes" while it is built."""
        record = self.records.get((label, "build"))
        size = None if record is None else record["details"].get(detail)
        return divided(size, self.faces)


def divided(above: float | None, below: float | None) -> float | None:
    """None where one is missing or there is nothing to divide by."""
    return None if above is None or not below else above / below


class Column(NamedTuple):
    """A figure of a scene."""

    heading: str
    of: Callable[[Scene], float | None]


def speed_columns(label: str, *headings: str, prefix: str = "") -> list[Column]:
    """Speed over another's, above 1 is faster; headings are of the form "any hit / HIGH"."""

    def column(heading: str) -> Column:
        kind, reference = heading.split(" / ")
        return Column(
            prefix + heading, lambda scene: scene.speed(label, REFERENCES[reference], KINDS.get(kind, kind))
        )

    return [column(heading) for heading in headings]


def goal_columns(fast: str, balanced: str) -> list[Column]:
    """What is held against Embree's, and bytes."""
    against_high = ("diffuse / HIGH", "any hit / HIGH", "primary / HIGH", "primary / packets")
    return [
        *speed_columns(fast, "build / LOW", "diffuse / LOW", prefix="fast: "),
        *speed_columns(balanced, "build / LOW", *against_high),
        Column("B/triangle", lambda scene: scene.bytes_per_face(balanced)),
        Column("of HIGH", lambda scene: scene.bytes_per_face(HIGH)),
    ]


def contender_columns(label: str) -> list[Column]:
    """A contender's figures, the same for ours and Embree's."""
    diffuse = ("diffuse / LOW", "diffuse / HIGH")
    return [
        *speed_columns(label, "build / LOW", "primary / HIGH", *diffuse, "any hit / HIGH"),
        Column("nodes/ray", lambda scene: scene.work(label, "nodes_per_ray")),
        Column("triangles/ray", lambda scene: scene.work(label, "triangles_per_ray")),
        Column("B/triangle", lambda scene: scene.bytes_per_face(label)),
        Column("peak B/triangle", lambda scene: scene.bytes_per_face(label, "peak_bytes")),
    ]


def tree_columns(ours: str, theirs: str) -> list[Column]:
    """Their tree's figures over ours, above 1 is worse, and how many rays hit something else in any bit."""

    def over(heading: str, kind: str, name: str) -> Column:
        return Column(
            heading, lambda scene: divided(scene.detail(theirs, kind, name), scene.detail(ours, kind, name))
        )

    def unequal(scene: Scene) -> float | None:
        shares = {kind: scene.detail(theirs, kind, "unequal") for kind in kinds.values()}
        known = {kind: share for kind, share in shares.items() if share is not None}
        return sum(share * scene.records[theirs, kind]["rays"] for kind, share in known.items())

    def rate(heading: str, kind: str) -> Column:
        return Column(heading, lambda scene: scene.speed(ours, theirs, kind))

    kinds = {"primary": "primary", "diffuse": "diffuse", "occlusion": "ambient_occlusion"}
    work = [
        over(f"{heading} {what}", kind, f"{what}_per_ray")
        for heading, kind in kinds.items()
        for what in ("nodes", "triangles")
    ]
    return [
        over("SAH", "build", "sah"),
        over("layout SAH", "build", "layout_sah"),
        *work,
        over("references", "build", "references"),
        over("peak bytes", "build", "peak_bytes"),
        *(rate(f"{heading} time", kind) for heading, kind in kinds.items()),
        rate("build time", "build"),
        Column("unequal rays", unequal),
    ]


def geometric_mean(values: Iterable[float | None]) -> float | None:
    """Of those that are there."""
    known = [value for value in values if value is not None]
    return math.exp(statistics.fmean(map(math.log, known))) if known else None


def means(scenes: Sequence[Scene], columns: Sequence[Column]) -> list[float | None]:
    """The geometric mean of each column over the scenes."""
    return [geometric_mean(column.of(scene) for scene in scenes) for column in columns]


def goal_table(scenes: Sequence[Scene], fast: str, balanced: str) -> list[list[str]]:
    """A row a scene and two of means."""
    columns = goal_columns(fast, balanced)
    rows = [["scene", "triangles", *(column.heading for column in columns)]]
    for scene in scenes:
        rows.append([scene.name, f"{scene.faces:,}", *(_cell(column.of(scene)) for column in columns)])
    others = [scene for scene in scenes if scene.name not in LONG_THIN]
    rows.append(["**geometric mean**", "", *map(_cell, means(scenes, columns))])
    if 0 < len(others) < len(scenes):
        rows.append([f"**without {' and '.join(LONG_THIN)}**", "", *map(_cell, means(others, columns))])
    return rows


def tree_table(scenes: Sequence[Scene], ours: str, theirs: str) -> list[list[str]]:
    """A row a scene and one of means, of the scenes where both trees were built."""
    columns = tree_columns(ours, theirs)
    ratios = columns[:-1]
    rows = [["scene", *(column.heading for column in columns)]]
    for scene in scenes:
        rows.append([scene.name, *(_cell(column.of(scene)) for column in columns)])
    return [*rows, ["**geometric mean**", *map(_cell, means(scenes, ratios)), ""]]


def contender_table(scenes: Sequence[Scene]) -> list[list[str]]:
    """A row a contender with its means over all scenes."""
    labels = dict.fromkeys(label for scene in scenes for label in scene.labels)
    rows = [["contender", *(column.heading for column in contender_columns(""))]]
    for label in labels:
        rows.append([label, *map(_cell, means(scenes, contender_columns(label)))])
    return rows


def read_scenes(folder: Path, labels: set[str]) -> list[Scene]:
    """One of each file in the folder in which all with these labels built a tree."""
    scenes = []
    for path in sorted(folder.glob("*.jsonl")):
        lines = path.read_text(encoding="utf-8").splitlines()
        if lines and labels <= set((scene := Scene(map(json.loads, lines))).labels):
            scenes.append(scene)
    return scenes


def _cell(value: float | None) -> str:
    if value is None:
        return "–"
    return f"{value:.0f}" if value >= 20 else f"{value:.2f}"


def _print_markdown(rows: Sequence[Sequence[str]]) -> None:
    print("| " + " | ".join(rows[0]) + " |")
    print("|---|" + "--:|" * (len(rows[0]) - 1))
    for row in rows[1:]:
        print("| " + " | ".join(row) + " |")


def main(words: Sequence[str] | None = None) -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--fast", default="fast", metavar="LABEL", help="whose build is held against LOW's")
    parser.add_argument("--balanced", default="balanced", metavar="LABEL", help="who is held against HIGH")
    parser.add_argument("--ours", default=OUR_TREE, metavar="LABEL", help="whose tree is held against theirs")
    parser.add_argument("--theirs", default=THEIR_TREE, metavar="LABEL", help="a tree by Embree's builder")
    options = parser.parse_args(words)
    scenes = read_scenes(options.folder, {LOW, HIGH})
    trees = read_scenes(options.folder, {options.ours, options.theirs})
    if not scenes and not trees:
        parser.error(
            f"no measurements of {LOW} and {HIGH}, or of {options.ours} and {options.theirs}, "
            f"in {options.folder}"
        )
    if scenes:
        _print_races(scenes, options)
    if trees:
        print(f"\n{options.theirs} over {options.ours} (above 1: ours is better), in one traversal.\n")
        _print_markdown(tree_table(trees, options.ours, options.theirs))


def _print_races(scenes: Sequence[Scene], options: argparse.Namespace) -> None:
    print("Speed over Embree's (above 1: faster) and bytes.\n")
    _print_markdown(goal_table(scenes, options.fast, options.balanced))
    print("\nGeometric means over all scenes; work is that of diffuse rays.\n")
    _print_markdown(contender_table(scenes))


if __name__ == "__main__":
    main()
