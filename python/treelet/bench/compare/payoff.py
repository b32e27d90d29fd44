"""Which recipe for how many rays, over many scenes [KarrasAila2013 s5].

For one scene the effective rate of a recipe is a curve with exact crossings (`treelet.bench.effective`). Over
scenes its effective rate is first taken as a share of the reference's ray rate there, so that each scene
counts alike, and then averaged; crossings of these means are found numerically.
"""

from __future__ import annotations

import itertools
import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass

from treelet.bench.compare.results import Results, SceneResult
from treelet.bench.compare.variants import has_word
from treelet.bench.effective import FEWEST_RAYS, MOST_RAYS, Curve, Range, best_ranges

RAY_COUNTS = tuple(10.0**power for power in range(6, 13))  # 1M to 1T
_POINTS = 50  # a decade: a recipe that wins between two of them only is not seen
_HALVINGS = 40


@dataclass(frozen=True)
class MeanCurve:
    """A recipe's effective rate over scenes, in shares of the reference's ray rate."""

    label: str
    _curves: tuple[Curve, ...]
    _rates: tuple[float, ...]  # of the reference, a scene each

    def at(self, rays: float) -> float:
        """The mean over scenes for trees that serve `rays` rays each."""
        pairs = zip(self._curves, self._rates, strict=True)
        return statistics.fmean(curve.at(rays) / rate for curve, rate in pairs)


def mean_curves(results: Results, kind: str) -> list[MeanCurve]:
    """Of all recipes that every scene has which has the reference; scenes without it are left out."""
    scenes = [scene for scene in results.scenes if scene.curve(results.reference, kind)]
    curves = []
    for label in results.recipes:
        found = [curve for scene in scenes if (curve := _comparable(scene, label, kind))]
        if found and len(found) == len(scenes):
            rates = tuple(scene.rate(results.reference, kind) or 1.0 for scene in scenes)
            curves.append(MeanCurve(label, tuple(found), rates))
    return curves


def _comparable(scene: SceneResult, label: str, kind: str) -> Curve | None:
    """The recipe's curve, by its shares of the reference, so that sessions may differ in speed."""
    reference = scene.curve(scene.reference, kind)
    build, rate = scene.build_share(label), scene.share(label, kind)
    if not reference or not build or not rate:
        return None
    return Curve(label, build * reference.build_seconds, rate * reference.rays_per_second)


def scene_curves(results: Results, scene: SceneResult, kind: str) -> list[Curve]:
    """Of one scene; those of recipes without a build or without such rays are left out."""
    found = (_comparable(scene, label, kind) for label in results.recipes)
    return [curve for curve in found if curve]


def scene_ranges(results: Results, scene: SceneResult, kind: str) -> list[Range]:
    """Which recipe is best where, on one scene."""
    curves = scene_curves(results, scene, kind)
    return best_ranges(curves) if curves else []


def mean_ranges(curves: Sequence[MeanCurve]) -> list[Range]:
    """Which recipe is best where, on the mean over scenes."""
    if not curves:
        return []
    count = round(_POINTS * math.log10(MOST_RAYS / FEWEST_RAYS))
    points = [FEWEST_RAYS * (MOST_RAYS / FEWEST_RAYS) ** (index / count) for index in range(count + 1)]
    ranges = [Range(_best(curves, points[0]).label, FEWEST_RAYS, MOST_RAYS)]
    for start, end in itertools.pairwise(points):
        winner = _best(curves, end)
        if winner.label != ranges[-1].label:
            border = _border(curves, ranges[-1].label, start, end)
            ranges[-1] = Range(ranges[-1].label, ranges[-1].start, border)
            ranges.append(Range(winner.label, border, MOST_RAYS))
    return ranges


def treelet_ranges(results: Results, ranges: Sequence[Range]) -> list[Range]:
    """Where a recipe with the word `treelet` is best, neighbouring ranges joined."""
    joined: list[Range] = []
    for each in ranges:
        if has_word(results.recipes[each.label], "treelet"):
            start = joined.pop().start if joined and joined[-1].end == each.start else each.start
            joined.append(Range("treelet", start, each.end))
    return joined


def _best(curves: Sequence[MeanCurve], rays: float) -> MeanCurve:
    return max(curves, key=lambda curve: curve.at(rays))


def _border(curves: Sequence[MeanCurve], label: str, start: float, end: float) -> float:
    """Up to where `label` is the best one, between two numbers of rays."""
    for _ in range(_HALVINGS):
        middle = math.sqrt(start * end)
        if _best(curves, middle).label == label:
            start = middle
        else:
            end = middle
    return math.sqrt(start * end)
