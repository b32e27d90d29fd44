"""One measurement, and files with one of them a line."""

from __future__ import annotations

import json
import statistics
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

import treelet
from treelet.bench.machine import describe_machine, source_commit


@dataclass(frozen=True)
class Measurement:
    """Repeated timings of one thing: building a tree (kind "build"), or tracing a fixed set of rays.

    Ray kinds are "primary", "diffuse" and "ambient_occlusion". All samples are kept, so that readers can
    judge noise.
    """

    kind: str
    scene: str
    faces: int
    label: str  # how tables and plots call the recipe
    recipe: str  # canonical text
    samples: list[float]  # seconds each
    rays: int = 0  # rays in the set; 0 for builds
    threads: int = 0
    details: dict[str, Any] = field(default_factory=dict)  # builds: the tree's report
    version: str = field(default_factory=lambda: treelet.__version__)
    commit: str | None = field(default_factory=source_commit)
    machine: dict[str, Any] = field(default_factory=describe_machine)
    timestamp: str = field(default_factory=lambda: datetime.now(timezone.utc).isoformat(timespec="seconds"))
    schema: int = 1

    @property
    def seconds(self) -> float:
        """Median of the samples."""
        return statistics.median(self.samples)

    @property
    def rays_per_second(self) -> float:
        """Rays over the median time; 0 for builds."""
        return self.rays / self.seconds if self.rays else 0.0

    def as_dict(self) -> dict[str, Any]:
        """Plain JSON-able values."""
        return asdict(self)


def write_measurements(path: str | Path, measurements: Iterable[Measurement], append: bool = False) -> Path:
    """Write one JSON object a line, making the folder; returns the path."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a" if append else "w", encoding="utf-8") as file:
        for measurement in measurements:
            file.write(json.dumps(measurement.as_dict(), allow_nan=False) + "\n")
    return path


def read_measurements(path: str | Path) -> list[Measurement]:
    """Read what `write_measurements` wrote. Raises ValueError naming the first line that is none."""
    measurements = []
    for number, line in enumerate(Path(path).read_text(encoding="utf-8").splitlines(), start=1):
        if not line.strip():
            continue
        try:
            measurements.append(Measurement(**json.loads(line)))
        except (json.JSONDecodeError, TypeError) as error:
            raise ValueError(f"{path}, line {number} is not a measurement: {error}") from error
    return measurements
