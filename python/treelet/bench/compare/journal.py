"""The two files of a comparison: lines of measurements, and of what happened in each session.

Everything a report says comes from them. Sessions in one folder complete each other: a row that is there, by
its key, is not measured again.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from dataclasses import dataclass, field
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

import treelet
from treelet.bench.compare.suite import SceneChoice, Suite
from treelet.bench.machine import describe_machine, source_commit
from treelet.bench.measure import Candidate
from treelet.bench.records import Measurement, read_measurements, write_measurements

_MEASUREMENTS, _SESSIONS = "measurements.jsonl", "sessions.jsonl"


@dataclass
class Journal:
    """A folder's files, and the session that writes to them now."""

    folder: Path
    session: str
    rows: set[str] = field(default_factory=set)  # keys of all measurements that are there

    def add(self, measurements: Iterable[Measurement]) -> None:
        """Append lines, and remember their keys."""
        kept = list(measurements)
        write_measurements(self.folder / _MEASUREMENTS, kept, append=True)
        self.rows.update(each.details["row"] for each in kept)

    def log(self, event: str, **facts: Any) -> None:
        """Append what happened: "begin", "skipped", "failed" or "end"."""
        line = {"event": event, "session": self.session, "timestamp": _now(), **facts}
        self.folder.mkdir(parents=True, exist_ok=True)
        with (self.folder / _SESSIONS).open("a", encoding="utf-8") as file:
            file.write(json.dumps(line, allow_nan=False) + "\n")


def open_journal(folder: Path) -> Journal:
    """Go on in a folder, which may not be there yet. Raises ValueError for lines that no comparison wrote."""
    path = folder / _MEASUREMENTS
    _mend_last_line(path)
    rows = {each.details.get("row", "") for each in read_measurements(path)} if path.exists() else set()
    number = sum(line["event"] == "begin" for line in read_sessions(folder)) + 1
    return Journal(folder, f"{number}-{_now()}", rows)


def read_lines(folder: Path) -> list[Measurement]:
    """All measurements of a folder. Raises FileNotFoundError where there are none."""
    path = folder / _MEASUREMENTS
    if not path.exists():
        raise FileNotFoundError(f"{folder} holds no {_MEASUREMENTS}: run `treelet compare SUITE.toml` first")
    return read_measurements(path)


def read_sessions(folder: Path) -> list[dict[str, Any]]:
    """What happened, in order; nothing where nobody wrote it down. Raises ValueError for a damaged line."""
    path = folder / _SESSIONS
    if not path.exists():
        return []
    lines = []
    for number, text in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1):
        try:
            line = json.loads(text)
            lines.append(line | {"event": str(line["event"])})
        except (json.JSONDecodeError, KeyError, TypeError) as error:
            raise ValueError(f"{path}, line {number} is not of a session: {error}") from error
    return lines


def row_key(
    suite: Suite, scene: SceneChoice, candidate: Candidate, kind: str, view: str | None = None
) -> str:
    """What makes a measurement the same one: scene, recipe, rays, repeats, commit, machine, threads."""
    facts: list[Any] = [scene.mesh, scene.triangles, suite.seed, candidate.label, candidate.recipe, kind]
    facts += [suite.builds, suite.epo] if view is None else [view, suite.rays, suite.repeats]
    if kind not in ("build", "primary"):
        facts += [suite.bounces, suite.samples]
    machine = describe_machine()
    facts += [source_commit(), machine["cpu"], machine["cores"], treelet.thread_count()]
    return hashlib.sha256(json.dumps(facts).encode()).hexdigest()[:16]


def _mend_last_line(path: Path) -> None:
    """Drop a line that was cut off while it was written: all whole lines stay."""
    if path.exists():
        data = path.read_bytes()
        if data and not data.endswith(b"\n"):
            path.write_bytes(data[: data.rfind(b"\n") + 1])


def _now() -> str:
    return datetime.now(timezone.utc).isoformat(timespec="seconds")
