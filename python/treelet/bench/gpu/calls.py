"""What a call from Python costs beyond the kernel, for rays that lie on the device already."""

from __future__ import annotations

import importlib.util
import statistics
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

import treelet
from treelet import cuda
from treelet.bench.gpu.cases import Case, Recipe, Settings, warn
from treelet.bench.gpu.clock import Clock
from treelet.bench.records import Measurement


def _to_torch(values: np.ndarray) -> Any:
    import torch

    return torch.from_numpy(values).cuda()


def _to_cupy(values: np.ndarray) -> Any:
    import cupy

    return cupy.asarray(values)


# Each answers in arrays of its own, made by its own allocator.
LIBRARIES: dict[str, Callable[[np.ndarray], Any]] = {
    "treelet": cuda.copy_to_device,
    "torch": _to_torch,
    "cupy": _to_cupy,
}


def measure_calls(
    case: Case, recipes: Sequence[Recipe], settings: Settings, clock: Clock
) -> Iterator[Measurement]:
    """Calls of `intersect` on the first recipe's tree, with arrays of each library that is here.

    Kinds: "call_kernel", the device's time; "call_enqueue", the host's until the call returns;
    "call_overhead", until the device is done, less the median of the device's time.
    """
    origins, directions = _rays_into(case, settings.call_rays)
    tree = treelet.build(case.mesh.vertices, case.mesh.faces, recipes[0].text).to("cuda")
    for name, to_device in LIBRARIES.items():
        if importlib.util.find_spec(name) is None:
            warn(f"calls with arrays of {name} are left out: it is not installed")
            continue
        try:
            arrays = to_device(origins), to_device(directions)
        except Exception as error:  # a library without CUDA raises what it likes
            warn(f"calls with arrays of {name} are left out: {error}")
            continue
        fields = {"scene": case.mesh.name, "faces": len(case.mesh.faces), "rays": settings.call_rays}
        fields |= {"label": f"{recipes[0].text}, arrays of {name}", "recipe": tree.report.recipe}
        details = {"clock": clock.name, "library": name}
        for kind, samples in _time_calls(tree, arrays, settings.calls, clock).items():
            yield Measurement(kind=kind, samples=samples, details=details, **fields)


def _time_calls(tree: Any, arrays: tuple[Any, Any], repeats: int, clock: Clock) -> dict[str, list[float]]:
    def call() -> object:
        return tree.intersect(*arrays)

    call()
    kernel = [clock.time(call) for _ in range(repeats)]
    enqueue, whole = [], []
    for _ in range(repeats):
        cuda.synchronize()
        start = time.perf_counter()
        answers = call()
        enqueued = time.perf_counter()
        cuda.synchronize()
        whole.append(time.perf_counter() - start)
        enqueue.append(enqueued - start)
        del answers  # freeing belongs to no call's time
    median = statistics.median(kernel)
    overhead = [max(0.0, seconds - median) for seconds in whole]
    return {"call_kernel": kernel, "call_enqueue": enqueue, "call_overhead": overhead}


def _rays_into(case: Case, count: int) -> tuple[np.ndarray, np.ndarray]:
    """From around the mesh to points in its box."""
    low, high = case.mesh.vertices.min(axis=0), case.mesh.vertices.max(axis=0)
    random = np.random.default_rng(0)
    origins = random.uniform(2 * low - high, 2 * high - low, (count, 3)).astype(np.float32)
    targets = random.uniform(low, high, (count, 3)).astype(np.float32)
    return origins, targets - origins
