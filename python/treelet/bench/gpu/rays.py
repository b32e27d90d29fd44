"""Traces one set of rays through many trees on a CUDA device, in turn, and holds the answers to the CPU's."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from treelet import cuda
from treelet.bench.gpu.builds import Subject, build_all, common_fields, describe_builds
from treelet.bench.gpu.cases import Case, Recipe, Settings, order_arguments, warn
from treelet.bench.gpu.clock import Clock
from treelet.bench.records import Measurement
from treelet.render.rays import Rays

_CHECKED = 100_000  # rays of a set whose answers are compared with the CPU's, evenly spread


@dataclass(frozen=True)
class DeviceRays:
    """A set of rays that lies on the device."""

    rays: Rays

    @cached_property
    def arrays(self) -> tuple[Any, Any]:
        """Origins and directions."""
        return (
            cuda.copy_to_device(self.rays.origins, "float32"),
            cuda.copy_to_device(self.rays.directions, "float32"),
        )

    def trace(self, bvh: Any, **order: Any) -> Any:
        """Enqueue the query that the kind of rays asks for."""
        query = bvh.occluded if self.rays.any_hit else bvh.intersect
        return query(*self.arrays, t_max=self.rays.t_max, **order)

    @cached_property
    def sample(self) -> np.ndarray:
        """Which rays are compared."""
        return np.unique(np.linspace(0, len(self.rays) - 1, min(_CHECKED, len(self.rays))).astype(np.int64))

    def expected(self, reference: Any) -> list[np.ndarray]:
        """The CPU's answers to the sample."""
        query = reference.occluded if self.rays.any_hit else reference.intersect
        part = self.rays.origins[self.sample], self.rays.directions[self.sample]
        return as_bits(query(*part, t_max=self.rays.t_max))

    def disagreements(self, answers: Any, expected: Sequence[np.ndarray]) -> int:
        """Rays of the sample whose answers are not the CPU's, to the bit."""
        wrong = np.zeros(len(self.sample), dtype=bool)
        for ours, theirs in zip(as_bits(answers), expected, strict=True):
            wrong |= ours[self.sample] != theirs
        return int(wrong.sum())


@dataclass
class _Entry:
    """A tree and an order of the rays."""

    subject: Subject
    suffix: str  # of the label
    order: dict[str, Any]
    wrong: int = 0
    samples: list[float] = field(default_factory=list)


def as_bits(answers: Any) -> list[np.ndarray]:
    """Answers on the host, floats as the integers of their bits."""
    arrays = answers if isinstance(answers, tuple) else [answers]
    host = [np.ravel(array.numpy() if hasattr(array, "numpy") else array) for array in arrays]
    return [array.view(np.uint32) if array.dtype == np.float32 else array for array in host]


def measure_rays(
    case: Case, recipes: Sequence[Recipe], settings: Settings, clock: Clock
) -> Iterator[Measurement]:
    """Builds of every recipe in turn, then every set of rays through every tree in turn.

    Details hold the work a ray, which does not depend on the machine, and how many rays of a sample were
    answered otherwise than by the CPU, which must be none.
    """
    subjects = build_all(case, recipes, settings.repeats)
    for subject in subjects:
        yield from describe_builds(case, subject)
    for rays in case.make_rays(settings.width):
        yield from _measure_set(case, subjects, DeviceRays(rays), settings.repeats, clock)


def _measure_set(
    case: Case, subjects: Sequence[Subject], rays: DeviceRays, repeats: int, clock: Clock
) -> Iterator[Measurement]:
    """All orders of the rays through all trees: checked once, then timed in turn."""
    expected = rays.expected(case.reference)
    entries = [_Entry(subject, *order) for subject in subjects for order in order_arguments()]
    for entry in entries:
        answers = rays.trace(entry.subject.bvh, **entry.order)
        entry.wrong = rays.disagreements(answers, expected)
        if entry.wrong:
            label = entry.subject.recipe.label + entry.suffix
            warn(f"{case.name}: {entry.wrong} {rays.rays.kind} rays of {label} are not the CPU's")
    for _ in range(repeats):
        for entry in entries:
            seconds = clock.time(lambda entry=entry: rays.trace(entry.subject.bvh, **entry.order))
            entry.samples.append(seconds)
    for entry in entries:
        fields = common_fields(case, entry.subject.recipe)
        fields["label"] += entry.suffix
        details = _details(entry, rays) | {"clock": clock.name}
        fields |= {"rays": len(rays.rays), "samples": entry.samples, "details": details}
        yield Measurement(kind=rays.rays.kind, **fields)


def _details(entry: _Entry, rays: DeviceRays) -> dict[str, Any]:
    """With nodes and triangles that a ray visits; of closest hits alone, for which they are counted."""
    details = {
        "checked": len(rays.sample),
        "disagreements": entry.wrong,
        "built_on": "cpu" if entry.subject.recipe.host else "device",
        "order": entry.order,
    }
    if rays.rays.any_hit:
        return details
    work = entry.subject.bvh.traversal_cost(*rays.arrays, t_max=rays.rays.t_max)
    means = {"nodes_per_ray": work.nodes.numpy().mean(), "triangles_per_ray": work.triangles.numpy().mean()}
    return details | {name: float(mean) for name, mean in means.items()}
