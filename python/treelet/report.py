"""What a build did."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from functools import cached_property
from typing import Any, NamedTuple

from . import _core

_EPO_TRIANGLES = 200_000  # a sampling error of well below a percent


class Stage(NamedTuple):
    """Wall-clock time of one part of a build."""

    name: str
    seconds: float


class Report:
    """Times, costs and counts of a build, or of a rebuild, and of the refits since.

    Costs are in triangle tests, times in seconds. It does not change with the tree: after an update,
    `Bvh.report` is another one.
    """

    recipe: str
    """The recipe with every argument written out."""
    stages: list[Stage]
    """In order of time; their sum is a little below build_seconds."""
    build_seconds: float
    """Wall clock from arrays to a tree that can be traced."""
    faces: int
    """Faces given."""
    references: int
    """What the builder sorted: faces less those left out, plus splits."""
    left_out_non_finite: int
    """Faces with a NaN or infinite vertex."""
    left_out_degenerate: int
    """Faces with two equal vertices."""
    nodes: int
    leaves: int
    depth: int
    """Nodes on the longest way from the root to a leaf."""
    leaf_histogram: dict[int, int]
    """Leaves by their number of triangles."""
    bytes: int
    """Memory of the tree, its triangles included."""
    sah: float
    """Surface area heuristic: expected cost of a random ray (1.2 a node, 1 a triangle)."""
    layout_sah: float
    """The same of the layout as it is now, where a wide node counts once: compare within one layout."""
    layout_sah_at_build: float
    """What layout_sah was before any refit. Both are relative to the mesh's own box, which may have grown."""
    refits: int
    """Refits since the build or the last rebuild."""
    refit_seconds: float
    """Wall clock of the last refit; 0 where there was none."""
    hidden: int
    """Triangles in leaves that no ray hits since the last refit: not finite, or two equal vertices."""
    held_bytes: int
    """Memory of a tree that can be updated, with all that its updates keep; 0 for other trees."""
    vertex_rounding: float
    """How far the conversion to float32 moved a vertex, at most."""

    def __init__(
        self,
        core: _core.Bvh,
        vertex_rounding: float,
        reading: Callable[[], AbstractContextManager[None]] = nullcontext,
    ) -> None:
        self._core, self._reading = core, reading
        self.vertex_rounding = vertex_rounding
        for name, value in core.report.items():
            setattr(self, name, value)
        self.stages = [Stage(*stage) for stage in self.stages]

    @cached_property
    def epo(self) -> float:
        """End-point overlap (Aila, Karras and Laine 2013): the cost of foreign nodes where rays end.

        Computed at first use, in about the time of a few builds; beyond 200 000 faces it is estimated from
        so many of them. A wide node counts once, like a binary one: compare within one layout. Of a tree
        that was updated before, it is the EPO of the tree as it is by then.
        """
        with self._reading():
            return self._core.epo(_EPO_TRIANGLES)

    def as_dict(self) -> dict[str, Any]:
        """Everything as plain numbers, strings, lists and dictionaries; computes the EPO."""
        plain = {name: value for name, value in vars(self).items() if not name.startswith("_")}
        plain["stages"] = [stage._asdict() for stage in self.stages]
        plain["epo"] = self.epo
        return plain

    def __repr__(self) -> str:
        times = f"build_seconds={self.build_seconds:.4g}, sah={self.sah:.4g}"
        return f"Report(recipe={self.recipe!r}, {times}, ...)"
