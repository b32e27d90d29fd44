"""What lines of measurements say: by scene, as shares of the reference, as means over scenes.

A share compares what one session measured: rows that a later session added were measured beside the
reference again.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from treelet.bench.compare.journal import read_lines, read_sessions
from treelet.bench.effective import Curve
from treelet.bench.records import Measurement

KIND_ORDER = ("primary", "diffuse", "ambient_occlusion")
_FEW_RAYS = 10_000
KIND_NAMES = {"primary": "primary", "diffuse": "diffuse", "ambient_occlusion": "occlusion"}


@dataclass(frozen=True)
class Means:
    """Of shares over scenes."""

    arithmetic: float
    geometric: float
    least: float
    most: float
    scenes: int


@dataclass(frozen=True)
class Noise:
    """By how much the samples of a line of rays differ, shares of their median."""

    typical: float  # the median over lines
    bad: float  # a tenth of the lines has more

    @property
    def sentence(self) -> str:
        """For the facts of a report."""
        return (
            f"noise: slowest and fastest trace of the same rays differ by {100 * self.typical:.0f} % "
            f"(median), in a tenth of the measurements by more than {100 * self.bad:.0f} %"
        )


@dataclass
class SceneResult:
    """All that was measured over one mesh; of rows measured twice the later."""

    name: str
    faces: int
    reference: str
    _lines: dict[tuple[str, str, str], dict[str, Measurement]] = field(default_factory=dict)

    def add(self, line: Measurement) -> None:
        """Take a line in; those of one session overwrite each other."""
        sessions = self._lines.setdefault((line.kind, line.details.get("view", ""), line.label), {})
        session = line.details.get("session", "")
        sessions.pop(session, None)
        sessions[session] = line

    def build(self, label: str) -> Measurement | None:
        """The latest build of a recipe."""
        return _latest(self._lines.get(("build", "", label)))

    def fact(self, label: str, name: str) -> float | None:
        """A number about a recipe's tree: "sah", "epo", "bytes" and so on."""
        build = self.build(label)
        return build.details.get(name) if build else None

    def views(self, kind: str) -> list[str]:
        """Views whose rays of this kind anything was measured with."""
        return list(dict.fromkeys(view for each, view, _ in self._lines if each == kind))

    def rate(self, label: str, kind: str) -> float | None:
        """Rays a second over all views together."""
        found = self._traces(label, kind)
        return sum(each.rays for each in found) / sum(each.seconds for each in found) if found else None

    def work(self, label: str, kind: str, name: str) -> float | None:
        """Mean "nodes_per_ray" or "triangles_per_ray", weighted by rays."""
        found = [each for each in self._traces(label, kind) if name in each.details]
        rays = sum(each.rays for each in found)
        return sum(each.rays * each.details[name] for each in found) / rays if rays else None

    def share(self, label: str, kind: str) -> float | None:
        """The recipe's rate over the reference's, with the same rays in the same session."""
        pairs = [pair for view in self.views(kind) if (pair := self._pair(label, kind, view))]
        if not pairs:
            return None
        own = sum(mine.rays for mine, _ in pairs) / sum(mine.seconds for mine, _ in pairs)
        return own / (sum(other.rays for _, other in pairs) / sum(other.seconds for _, other in pairs))

    def build_share(self, label: str) -> float | None:
        """The recipe's build time over the reference's in the same session."""
        pair = self._pair(label, "build", "")
        return pair[0].seconds / pair[1].seconds if pair else None

    def fact_share(self, label: str, name: str) -> float | None:
        """A number about the recipe's tree over the reference's; None where that is 0."""
        own, other = self.fact(label, name), self.fact(self.reference, name)
        return own / other if own is not None and other else None

    def curve(self, label: str, kind: str) -> Curve | None:
        """What the recipe costs and gives here."""
        build, rate = self.build(label), self.rate(label, kind)
        return Curve(label, build.seconds, rate) if build and rate else None

    def _traces(self, label: str, kind: str) -> list[Measurement]:
        found = (_latest(self._lines.get((kind, view, label))) for view in self.views(kind))
        return [each for each in found if each]

    def _pair(self, label: str, kind: str, view: str) -> tuple[Measurement, Measurement] | None:
        own = self._lines.get((kind, view, label))
        others = self._lines.get((kind, view, self.reference), {})
        for session in reversed(own or {}):
            if own and session in others:
                return own[session], others[session]
        return None


@dataclass
class Results:
    """A whole comparison."""

    title: str
    reference: str
    recipes: dict[str, str]  # canonical text by label, in the suite's order
    kinds: list[str]
    scenes: list[SceneResult]
    skipped: list[dict[str, str]] = field(default_factory=list)
    failed: list[dict[str, str]] = field(default_factory=list)
    machines: list[str] = field(default_factory=list)
    noise: Noise | None = None
    effort: str = ""  # how often and with how many rays, for the facts of a report

    @property
    def main_kind(self) -> str:
        """Diffuse rays, by which the paper judges trees; else the first kind."""
        return "diffuse" if "diffuse" in self.kinds else self.kinds[0]

    def share_means(self, label: str, kind: str, scenes: Sequence[SceneResult] | None = None) -> Means | None:
        """Of the recipe's share of the reference's rate."""
        return means(scene.share(label, kind) for scene in (self.scenes if scenes is None else scenes))

    @property
    def size(self) -> str:
        """'2 scenes, 5,000 triangles'"""
        count, faces = len(self.scenes), sum(scene.faces for scene in self.scenes)
        return f"{count} scene{'s' if count != 1 else ''}, {faces:,} triangles"

    def scene_names(self) -> list[str]:
        """Names, with the size where one name is there in several."""
        names = [scene.name for scene in self.scenes]
        return [
            f"{scene.name} {scene.faces:,}" if names.count(scene.name) > 1 else scene.name
            for scene in self.scenes
        ]


def means(values: Iterable[float | None]) -> Means | None:
    """Of the positive numbers among `values`; None without any."""
    found = [value for value in values if value is not None and value > 0.0]
    if not found:
        return None
    geometric = math.exp(statistics.fmean(math.log(value) for value in found))
    return Means(statistics.fmean(found), geometric, min(found), max(found), len(found))


def read_results(folder: Path) -> Results:
    """What the files of a folder say. Raises OSError or ValueError for missing or damaged ones."""
    return gather(read_lines(folder), read_sessions(folder))


def gather(lines: Sequence[Measurement], sessions: Sequence[dict[str, Any]]) -> Results:
    """Join lines of the last session's commit, whichever session wrote them.

    Raises ValueError without lines, or where no session names the reference.
    """
    begins = [each for each in sessions if each["event"] == "begin"]
    if not lines or not begins:
        raise ValueError("there is nothing to report: no line of a measurement, or of the begin of a session")
    last = begins[-1]
    kept = [line for line in lines if line.commit == last["commit"]] or list(lines)
    recipes = {label: text for each in begins for label, text in each["recipes"].items()}
    measured = {line.label for line in kept}
    scenes: dict[tuple[str, int], SceneResult] = {}
    for line in kept:
        key = line.scene, line.faces
        scenes.setdefault(key, SceneResult(*key, last["reference"])).add(line)
    kinds = {line.kind for line in kept}
    return Results(
        last["title"],
        last["reference"],
        {label: text for label, text in recipes.items() if label in measured},
        [kind for kind in KIND_ORDER if kind in kinds],
        list(scenes.values()),
        list(_events(sessions, last["session"], "skipped")),
        list(_events(sessions, last["session"], "failed")),
        sorted({_describe(line) for line in kept}),
        _noise(kept),
        _effort(kept),
    )


def _events(sessions: Iterable[dict[str, Any]], session: str, event: str) -> Iterator[dict[str, str]]:
    for each in sessions:
        if each["session"] == session and each["event"] == event:
            yield {key: str(each[key]) for key in ("scene", "view", "label", "reason") if each.get(key)}


def _effort(lines: Iterable[Measurement]) -> str:
    of_builds = [line for line in lines if line.rays == 0]
    of_rays = [line for line in lines if line.rays > 0]
    parts = [f"{_span(len(line.samples) for line in of_builds)} builds"] if of_builds else []
    if of_rays:
        traces, rays = _span(len(line.samples) for line in of_rays), _span(line.rays for line in of_rays)
        parts.append(f"{traces} traces of {rays} rays")
    few = of_rays and min(line.rays for line in of_rays) < _FEW_RAYS
    return f"samples of each: {', '.join(parts)}" + ("; so few rays tell nothing about rates" if few else "")


def _span(values: Iterable[int]) -> str:
    found = list(values)
    return f"{min(found):,}" + (f" to {max(found):,}" if min(found) != max(found) else "")


def _noise(lines: Iterable[Measurement]) -> Noise | None:
    spreads = sorted(
        (max(line.samples) - min(line.samples)) / line.seconds
        for line in lines
        if line.rays and len(line.samples) > 1
    )
    return Noise(statistics.median(spreads), spreads[9 * len(spreads) // 10]) if spreads else None


def _describe(line: Measurement) -> str:
    commit = f"commit {line.commit}" if line.commit else f"version {line.version}"
    return f"{line.machine.get('cpu')}, {line.threads} threads, {commit}, {line.timestamp[:10]}"


def _latest(sessions: dict[str, Measurement] | None) -> Measurement | None:
    return next(reversed(sessions.values())) if sessions else None
