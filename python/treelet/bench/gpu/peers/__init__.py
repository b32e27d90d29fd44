"""Other tracers on the same rays of the same device: one module a peer, each imports its own only in `load`.

Each has NAME, VARIANTS (names of its ways to build) and `load()`, which returns an object of class `Peer`, or
raises ImportError or OSError, with the reason, where the peer cannot run here.
"""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType
from typing import Protocol

import numpy as np

from treelet.bench.gpu.peers import mitsuba_optix, torch_bvh, warp_mesh
from treelet.render.rays import Rays

PEERS: tuple[ModuleType, ...] = (warp_mesh, torch_bvh, mitsuba_optix)


class Tracer(Protocol):
    """Rays of a peer on the device, and a tree to trace them with."""

    def __call__(self) -> object:
        """Enqueue the query."""

    def answers(self) -> tuple[np.ndarray, np.ndarray] | np.ndarray:
        """What the last call found, on the host: t (inf for a miss) and face (-1), or whether anything."""


class Peer(Protocol):
    """A tracer that is installed here and works."""

    version: str

    def synchronize(self) -> None:
        """Wait for all that was enqueued."""

    def upload(self, vertices: np.ndarray, faces: np.ndarray) -> Callable[[str], object]:
        """Copy a mesh to the device; returns what builds a tree of a variant over it."""

    def prepare(self, tree: object, rays: Rays) -> Tracer:
        """Copy rays to the device. Raises NotImplementedError for a kind that it has no query for."""
