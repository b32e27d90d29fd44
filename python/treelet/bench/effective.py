"""Effective performance: rays over the time to build the tree and trace them [KarrasAila2013 s5].

A slow builder pays once many rays share its tree; which recipe is best is a question about the number of
rays.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from treelet.bench.records import Measurement

FEWEST_RAYS, MOST_RAYS = 1e6, 1e12


@dataclass(frozen=True)
class Curve:
    """What a recipe costs once and gives then."""

    label: str
    build_seconds: float
    rays_per_second: float

    def at(self, rays: float) -> float:
        """Effective rays a second for `rays` rays."""
        return effective_rate(rays, self.build_seconds, self.rays_per_second)


@dataclass(frozen=True)
class Range:
    """From `start` to `end` rays, `label` is the best recipe."""

    label: str
    start: float
    end: float


def effective_rate(rays: float, build_seconds: float, rays_per_second: float) -> float:
    """Rays a second with the time to build counted in."""
    return rays / (build_seconds + rays / rays_per_second)


def crossover(first: Curve, second: Curve) -> float | None:
    """The number of rays for which both take equally long; None where one is never behind."""
    building = second.build_seconds - first.build_seconds
    tracing = 1.0 / first.rays_per_second - 1.0 / second.rays_per_second
    return building / tracing if tracing != 0.0 and building / tracing > 0.0 else None


def best_ranges(curves: Sequence[Curve], fewest: float = FEWEST_RAYS, most: float = MOST_RAYS) -> list[Range]:
    """Which curve is the highest where, ranges from `fewest` to `most` without gaps."""
    pairs = [(first, second) for index, first in enumerate(curves) for second in curves[index + 1 :]]
    crossings = sorted(
        rays for pair in pairs if (rays := crossover(*pair)) is not None and fewest < rays < most
    )
    ranges: list[Range] = []
    borders = [fewest, *crossings, most]
    for start, end in itertools.pairwise(borders):
        middle = math.sqrt(start * end)
        label = max(curves, key=lambda curve: curve.at(middle)).label
        if ranges and ranges[-1].label == label:
            start = ranges.pop().start
        ranges.append(Range(label, start, end))
    return ranges


def curves_of(measurements: Iterable[Measurement], kind: str = "diffuse") -> list[Curve]:
    """One curve a label, in the order of appearance, from its "build" and its `kind` measurement.

    A label that was traced in another way only (as with sorted rays) has the build of its recipe.
    """
    seconds: dict[str, float] = {}
    by_recipe: dict[str, float] = {}
    rates: dict[str, tuple[str, float]] = {}
    for measurement in measurements:
        if measurement.kind == "build":
            seconds[measurement.label] = measurement.seconds
            by_recipe[measurement.recipe] = measurement.seconds
        elif measurement.kind == kind:
            rates[measurement.label] = (measurement.recipe, measurement.rays_per_second)
    labels = [
        *(label for label in seconds if label in rates),
        *(label for label in rates if label not in seconds),
    ]
    builds = {label: seconds.get(label, by_recipe.get(rates[label][0])) for label in labels}
    return [Curve(label, build, rates[label][1]) for label, build in builds.items() if build is not None]


def ranges_of(ranges: Iterable[Range], word: str) -> list[Range]:
    """Where a recipe with a word is best, neighbouring ranges joined."""
    joined: list[Range] = []
    for each in ranges:
        if word not in each.label:
            continue
        start = joined.pop().start if joined and joined[-1].end == each.start else each.start
        joined.append(Range(word, start, each.end))
    return joined
