"""The parts of the benchmark of a GPU, and the tasks they are divided into: a run can end between two."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from treelet import cuda, scenes
from treelet.bench.gpu.builds import measure_builds
from treelet.bench.gpu.calls import measure_calls
from treelet.bench.gpu.cases import Case, Recipe, Settings, list_cases, warn
from treelet.bench.gpu.clock import Clock, Driver, find_driver, make_clock, time_copies
from treelet.bench.gpu.queries import measure_queries
from treelet.bench.gpu.rays import measure_rays
from treelet.bench.gpu.stream import measure_stream
from treelet.bench.gpu.versus import measure_versus
from treelet.bench.machine import source_commit
from treelet.bench.records import Measurement, read_measurements

Measure = Callable[[Case, Sequence[Recipe], Settings, Clock], Iterator[Measurement]]


@dataclass(frozen=True)
class Part:
    """What one part of the benchmark measures, by default over which scenes and sizes."""

    measure: Measure
    scenes: tuple[str, ...]
    triangles: tuple[int, ...]
    recipes: str = ""  # how those that it measures begin

    def choose(self, recipes: Iterable[Recipe]) -> list[Recipe]:
        """Of the recipes those that the part measures."""
        return [each for each in recipes if each.text.startswith(self.recipes)]


# The goals speak of these. Those that are not embedded come from the folder in TREELET_SCENES.
GOAL_SCENES = (
    *("crytek_sponza", "city", "conference", "dragon", "sibenik"),
    *("breakfast_room", "armadillo", "forest", "interior"),
)
_SIZES = (10_000, 1_000_000, 10_000_000, 30_000_000)
PARTS: dict[str, Part] = {
    "calls": Part(measure_calls, ("sphere",), (10_000,), "lbvh > "),
    "rays": Part(measure_rays, GOAL_SCENES, (1_000_000,)),
    "stream": Part(measure_stream, ("city",), (1_000_000,), "lbvh > treelet"),
    "queries": Part(measure_queries, ("city", "dragon"), (1_000_000,), "lbvh > treelet"),
    "builds": Part(measure_builds, ("city", "forest", "terrain", "sphere"), _SIZES),
    "versus": Part(measure_versus, GOAL_SCENES, (1_000_000,), "lbvh > "),
}
COPY = "copy"
PART_NAMES = (COPY, *PARTS)


@dataclass(frozen=True)
class Task:
    """A part over one scene: what is measured, and written, in one go."""

    part: str
    case: Case

    @property
    def key(self) -> str:
        """What its measurements are marked with."""
        return f"{self.part} {self.case.name}"


def list_tasks(parts: Iterable[str], names: Sequence[str], triangles: Sequence[int]) -> Iterator[Task]:
    """All that is asked for; scenes and sizes are the part's own where none are named."""
    for name in parts:
        if name == COPY:
            yield Task(name, Case("memory"))
            continue
        part = PARTS[name]
        for case in list_cases(names or _present(part.scenes), triangles or part.triangles):
            yield Task(name, case)


def _present(names: Sequence[str]) -> list[str]:
    """Of the default scenes those that are there."""
    known = {*scenes.names(), *scenes.external_names()}
    missing = [name for name in names if name not in known]
    if missing:
        warn(f"not in TREELET_SCENES, so left out: {', '.join(missing)}")
    return [name for name in names if name in known]


def measure(
    task: Task, recipes: Sequence[Recipe], settings: Settings, driver: Driver | None
) -> Iterator[Measurement]:
    """The measurements of a task, marked with its key and the device."""
    if task.part == COPY:
        measurements = _measure_copies(driver, settings.repeats)
    else:
        part = PARTS[task.part]
        measurements = part.measure(task.case, part.choose(recipes), settings, make_clock(driver))
    device = cuda.devices()[0]
    gpu = {"gpu": device.name, "multiprocessors": device.multiprocessors}
    for each in measurements:
        yield replace(each, details=each.details | {"task": task.key}, machine=each.machine | gpu)


def _measure_copies(driver: Driver | None, repeats: int) -> Iterator[Measurement]:
    if driver is None:
        warn("copies are left out: there is no driver to ask (libcuda)")
        return
    samples, count = time_copies(driver, repeats)
    fields = {"scene": "memory", "faces": 0, "label": "copy", "recipe": ""}
    yield Measurement(kind="copy", samples=samples, details={"bytes": count}, **fields)


def finished_tasks(output: Path | None) -> set[str]:
    """Keys of the tasks that a file holds, measured with these sources. Errors as `read_measurements`."""
    if output is None or not output.exists():
        return set()
    commit = source_commit()
    return {each.details.get("task", "") for each in read_measurements(output) if each.commit == commit}


def run(
    tasks: Sequence[Task],
    recipes: Sequence[Recipe],
    settings: Settings,
    seconds: float,
    write: Callable[[list[str]], None],
) -> list[Task]:
    """Measure tasks and write their lines; returns those that are left when time may not suffice for one."""
    driver, begin, longest = find_driver(), time.monotonic(), 0.0
    for index, task in enumerate(tasks):
        start = time.monotonic()
        if index > 0 and start - begin + longest > seconds:
            return list(tasks[index:])
        warn(f"{task.key} ...")
        measurements = measure(task, recipes, settings, driver)
        write([json.dumps(each.as_dict(), allow_nan=False) for each in measurements])
        longest = max(longest, time.monotonic() - start)
    return []
