"""Other tracers and ours on the same rays of the same device, in turn, all timed by the host's clock.

Peers work in streams of their own, which events of ours do not see. So time runs from the call until the peer
says that the device is done, for ours as for theirs.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

import treelet
from treelet import cuda
from treelet.bench.gpu.builds import build_all
from treelet.bench.gpu.cases import Case, Recipe, Settings, order_arguments, warn
from treelet.bench.gpu.clock import Clock
from treelet.bench.gpu.peers import PEERS
from treelet.bench.gpu.rays import DeviceRays
from treelet.bench.records import Measurement
from treelet.render.rays import Rays


@dataclass
class Opponent:
    """A peer's tree, built in one of its ways."""

    peer: Any
    label: str
    tree: Any
    builds: list[float]


@dataclass
class Entry:
    """Somebody's query of a set of rays."""

    label: str
    recipe: str  # a recipe of ours, or the peer's version
    call: Callable[[], object]
    synchronize: Callable[[], object]
    details: dict[str, Any]
    samples: list[float] = field(default_factory=list)


def measure_versus(
    case: Case, recipes: Sequence[Recipe], settings: Settings, _: Clock
) -> Iterator[Measurement]:
    """Builds and rays of the peers that are here, and rays of our recipes: kinds end in "_versus"."""
    opponents = _find_opponents(case, settings.repeats)
    if not opponents:
        return
    common = {"scene": case.mesh.name, "faces": len(case.mesh.faces)}
    for each in opponents:
        names = {"label": each.label, "recipe": each.peer.version, "details": {"peer": True}}
        yield Measurement(kind="build_versus", samples=each.builds, **common, **names)
    subjects = build_all(case, recipes, 0)
    for rays in case.make_rays(settings.width):
        truth = rays.trace(case.reference)
        entries = [entry for each in opponents for entry in _enter_peer(each, rays, truth)]
        entries += [entry for each in subjects for entry in _enter_ours(each.recipe, each.bvh, rays)]
        _time_in_turn(entries, settings.repeats)
        for entry in entries:
            names = {"label": entry.label, "recipe": entry.recipe, "details": entry.details}
            kind = f"{rays.kind}_versus"
            yield Measurement(kind=kind, samples=entry.samples, rays=len(rays), **common, **names)


def _find_opponents(case: Case, repeats: int) -> list[Opponent]:
    """Trees of every peer that works here; why others do not is said."""
    opponents = []
    for module in PEERS:
        try:
            peer = module.load()
            build = peer.upload(case.mesh.vertices, case.mesh.faces)
            for variant in module.VARIANTS:
                label = f"{module.NAME} {variant}"
                opponents.append(_build(peer, label, partial(build, variant), repeats))
        except Exception as error:  # whatever it is, it must not end the benchmark
            warn(f"{case.name}: {module.NAME} is left out: {type(error).__name__}: {error}")
    return opponents


def _build(peer: Any, label: str, build: Callable[[], object], repeats: int) -> Opponent:
    samples, tree = [], None
    for repeat in range(repeats + 1):
        peer.synchronize()
        start = time.perf_counter()
        tree = build()
        peer.synchronize()
        if repeat > 0:  # the first compiles kernels and maps memory
            samples.append(time.perf_counter() - start)
    return Opponent(peer, label, tree, samples)


def _enter_peer(opponent: Opponent, rays: Rays, truth: Any) -> Iterator[Entry]:
    """Nothing where the peer has no such query; else its tracer, and how far it agrees with the CPU."""
    peer = opponent.peer
    try:
        tracer = peer.prepare(opponent.tree, rays)
        tracer()
        peer.synchronize()
        details = {"peer": True} | _agreement(tracer.answers(), truth)
    except Exception as error:  # as above
        warn(f"{opponent.label}: no {rays.kind} rays: {type(error).__name__}: {error}")
        return
    yield Entry(opponent.label, peer.version, tracer, peer.synchronize, details)


def _enter_ours(recipe: Recipe, bvh: Any, rays: Rays) -> Iterator[Entry]:
    batch = DeviceRays(rays)
    text = treelet.parse_recipe(recipe.text)
    for suffix, order in order_arguments():
        call = partial(batch.trace, bvh, **order)
        yield Entry(recipe.label + suffix, text, call, cuda.synchronize, {"peer": False})


def _time_in_turn(entries: Sequence[Entry], repeats: int) -> None:
    for repeat in range(repeats + 1):
        for entry in entries:
            entry.synchronize()
            start = time.perf_counter()
            entry.call()
            entry.synchronize()
            if repeat > 0:  # the first touches the tree's memory
                entry.samples.append(time.perf_counter() - start)


def _agreement(answers: Any, truth: Any) -> dict[str, float]:
    """Shares of the rays for which a peer finds our face (ties may differ), and hits or misses as we do."""
    if not isinstance(answers, tuple):
        return {"same_hit": float(np.mean(np.asarray(answers) == truth))}
    face = np.asarray(answers[1])
    return {
        "same_face": float(np.mean(face == truth.face)),
        "same_hit": float(np.mean((face >= 0) == (truth.face >= 0))),
    }
