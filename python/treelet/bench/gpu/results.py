"""What files of measurements of a GPU say, by scene; of things measured twice the later."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from treelet.bench.effective import Curve, curves_of
from treelet.bench.records import Measurement, read_measurements

HOST_MARK = "(CPU)"  # in labels of trees that the CPU built


@dataclass
class Scene:
    """Measurements over one mesh, by kind, label and task."""

    name: str
    faces: int
    measurements: dict[tuple[str, str, str], Measurement] = field(default_factory=dict)

    def of_kind(self, kind: str, part: str = "") -> list[Measurement]:
        """In the order of measuring, by default of any part of the benchmark."""
        return [
            each
            for (measured, _, task), each in self.measurements.items()
            if measured == kind and task.startswith(part)
        ]

    def find(self, kind: str, label: str) -> Measurement | None:
        """The one of a kind and a label, of whichever part came last."""
        return next((each for each in reversed(self.of_kind(kind)) if each.label == label), None)

    def curves(self, kind: str) -> list[Curve]:
        """Build time and ray rate of every recipe, layout and order that traced such rays."""
        return curves_of([*self.of_kind("build", "rays"), *self.of_kind(kind, "rays")], kind)


@dataclass
class Results:
    """All scenes, in the order of measuring."""

    scenes: list[Scene]

    @property
    def copy_rate(self) -> float | None:
        """Bytes a second, read and written ones, of copies within the device's memory."""
        found = [each for scene in self.scenes for each in scene.of_kind("copy")]
        return found[-1].details["bytes"] / found[-1].seconds if found else None

    @property
    def machines(self) -> list[str]:
        """Devices, processors and commits that measured, each once."""
        measurements = [each for scene in self.scenes for each in scene.measurements.values()]
        return sorted({_describe(each) for each in measurements})

    def measured(self, kind: str, part: str = "") -> list[tuple[Scene, list[Measurement]]]:
        """Scenes that have measurements of a kind, and these."""
        pairs = ((scene, scene.of_kind(kind, part)) for scene in self.scenes)
        return [(scene, found) for scene, found in pairs if found]


def _describe(each: Measurement) -> str:
    device, processor = each.machine.get("gpu", "no GPU"), each.machine.get("cpu")
    return f"{device}, {processor}, commit {each.commit}, {each.timestamp[:10]}"


def group(measurements: Iterable[Measurement]) -> Results:
    """By scene and number of triangles."""
    scenes: dict[tuple[str, int], Scene] = {}
    for each in measurements:
        scene = scenes.setdefault((each.scene, each.faces), Scene(each.scene, each.faces))
        scene.measurements[each.kind, each.label, each.details.get("task", "")] = each
    return Results(list(scenes.values()))


def read_results(paths: Sequence[Path]) -> Results:
    """Raises ValueError for a line that is no measurement, OSError for a file that cannot be read."""
    return group(each for path in paths for each in read_measurements(path))


def table(headings: Sequence[str], rows: Iterable[Sequence[str]], left: int = 1) -> list[str]:
    """Markdown that reads well as text; nothing without rows. The first `left` columns hold words."""
    rows = list(rows)
    if not rows:
        return []
    widths = [max(map(len, column)) for column in zip(headings, *rows, strict=True)]

    def line(cells: Sequence[str]) -> str:
        pairs = enumerate(zip(cells, widths, strict=True))
        padded = [cell.ljust(width) if index < left else cell.rjust(width) for index, (cell, width) in pairs]
        return "| " + " | ".join(padded) + " |"

    rule = ["-" * (width + 1) + ("-" if index < left else ":") for index, width in enumerate(widths)]
    return [line(headings), "|" + "|".join(rule) + "|", *map(line, rows)]
