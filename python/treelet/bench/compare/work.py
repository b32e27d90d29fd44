"""What is left to measure of one scene."""

from __future__ import annotations

from dataclasses import dataclass, field

from treelet.bench.compare.journal import row_key
from treelet.bench.compare.suite import Suite
from treelet.bench.compare.survey import Survey
from treelet.bench.measure import Candidate

Part = tuple[str, str]  # view and kind of rays


@dataclass(frozen=True)
class SceneWork:
    """Labels of the trees to build, and which of them to time, for what; in the suite's order.

    Whatever is measured is measured beside the reference, so that shares are of one session.
    """

    builds: tuple[str, ...] = ()  # timed
    traces: dict[Part, tuple[str, ...]] = field(default_factory=dict)
    trees: tuple[str, ...] = ()  # all that anything is measured of

    def steps(self, suite: Suite) -> int:
        """How many times progress is told of."""
        built = len(self.builds) * (suite.builds + 1) + len(self.trees) - len(self.builds)
        traced = sum(len(labels) for labels in self.traces.values()) * (suite.repeats + 2)
        return built + traced


def find_work(suite: Suite, scene: Survey, rows: set[str]) -> SceneWork:
    """All rows of the scene that are not in `rows`."""
    builds = _missing(suite, [_key(suite, scene, each, "build") for each in suite.candidates], rows)
    traces = {}
    for view in scene.views:
        for kind in suite.kinds:
            keys = [_key(suite, scene, each, kind, view) for each in suite.candidates]
            if labels := _missing(suite, keys, rows):
                traces[view, kind] = labels
    wanted = {*builds, *(label for labels in traces.values() for label in labels)}
    return SceneWork(builds, traces, tuple(each.label for each in suite.candidates if each.label in wanted))


def _missing(suite: Suite, keys: list[str], rows: set[str]) -> tuple[str, ...]:
    """Labels whose key is not there, and the reference where there are any."""
    pairs = zip(suite.candidates, keys, strict=True)
    missing = {candidate.label for candidate, key in pairs if key not in rows}
    missing |= {suite.reference} if missing else set()
    return tuple(each.label for each in suite.candidates if each.label in missing)


def _key(suite: Suite, scene: Survey, candidate: Candidate, kind: str, view: str | None = None) -> str:
    return row_key(suite, scene.choice, candidate, kind, view)
