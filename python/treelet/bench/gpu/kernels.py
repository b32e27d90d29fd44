"""What kernels use, as the compiler said, and what they did, as Nsight Compute counted.

An SM of compute capability 9.0 has room for 64 warps, for 65 536 registers, which a warp takes in units of
256, and for 228 KiB of shared memory, of which a block takes one more than it asks for
[CUDA C++ Programming Guide].
"""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from treelet.bench.gpu.results import table

WARPS, REGISTERS, UNIT = 64, 65536, 256
SHARED, RESERVED, BLOCKS = 228 << 10, 1 << 10, 32
# What is asked of Nsight Compute, and our names. Few, so that it runs every kernel once or twice.
METRICS = {
    "gpu__time_duration.sum": "nanoseconds",
    "dram__bytes.sum": "bytes",
    "smsp__inst_executed.sum": "instructions",
    "smsp__issue_active.avg.pct_of_peak_sustained_active": "issue",
    "sm__warps_active.avg.pct_of_peak_sustained_active": "occupancy",
    "smsp__thread_inst_executed_per_inst_executed.ratio": "lanes",
}


@dataclass(frozen=True)
class Counters:
    """One launch of a kernel, by our names of the metrics."""

    kernel: str
    values: dict[str, float]


def warps_by_registers(registers: int, block_warps: int = 4) -> int:
    """Warps that an SM holds at most when registers alone decide, in whole blocks."""
    if registers == 0:
        return WARPS
    a_warp = -(-registers * 32 // UNIT) * UNIT
    return min(WARPS, REGISTERS // a_warp) // block_warps * block_warps


def blocks_by_shared(shared: int) -> int:
    """Blocks that an SM holds at most when shared memory alone decides."""
    return min(BLOCKS, SHARED // (shared + RESERVED))


def read_resources(path: Path) -> list[dict[str, Any]]:
    """Lines of tools/kernel_resources.py --json. Raises ValueError for one that is none."""
    lines = [line for line in path.read_text(encoding="utf-8").splitlines() if line.startswith("{")]
    return [json.loads(line) for line in lines]


def resource_table(functions: Iterable[dict[str, Any]]) -> list[str]:
    """A row a kernel of ours; CUB's are left out."""
    rows = []
    for each in functions:
        if each["is_kernel"] and "cub::" not in each["name"]:
            spills = each["spill_stores"] + each["spill_loads"]
            registers, shared = each["registers"], each["shared"]
            numbers = (registers, spills, shared, warps_by_registers(registers), blocks_by_shared(shared))
            rows.append([each["source"], short_name(each["name"]), *map(str, numbers)])
    headings = ["file", "kernel", "registers", "spilled bytes", "shared bytes", "warps of 64", "blocks of 32"]
    return table(headings, rows, left=2)


def read_counters(path: Path) -> list[Counters]:
    """What `ncu --csv` wrote: a column a metric (--page raw), or a row a metric (the default page)."""
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    begin = next((index for index, line in enumerate(lines) if '"Kernel Name"' in line), None)
    if begin is None:
        raise ValueError(f"{path} has no heading of Nsight Compute")
    rows = list(csv.DictReader(lines[begin:]))
    return _read_long(rows) if rows and "Metric Name" in rows[0] else _read_wide(rows)


def _read_wide(rows: Iterable[dict[str, str]]) -> list[Counters]:
    found = []
    for row in rows:
        numbers = {ours: _number(row.get(name)) for name, ours in METRICS.items()}
        values = {name: number for name, number in numbers.items() if number is not None}
        if row.get("Kernel Name") and values:  # the row of units has no name
            found.append(Counters(row["Kernel Name"], values))
    return found


def _read_long(rows: Iterable[dict[str, str]]) -> list[Counters]:
    launches: dict[str, Counters] = {}
    for row in rows:
        number = _number(row.get("Metric Value"))
        if row["Metric Name"] in METRICS and number is not None:
            launch = launches.setdefault(row["ID"], Counters(row["Kernel Name"], {}))
            launch.values[METRICS[row["Metric Name"]]] = number
    return list(launches.values())


def _number(text: str | None) -> float | None:
    try:
        return float((text or "").replace(",", ""))
    except ValueError:
        return None


def counter_table(counters: Sequence[Counters], copy_rate: float | None) -> list[str]:
    """A row a kernel, its launches summed, the longest first: memory and issue slots against their limits."""
    by_kernel: dict[str, list[Counters]] = {}
    for each in counters:
        by_kernel.setdefault(short_name(each.kernel), []).append(each)
    rows = sorted(by_kernel.items(), key=lambda item: -_sum(item[1], "nanoseconds"))
    headings = [
        "kernel",
        "launches",
        "us",
        "GB/s",
        "of a copy's",
        "instructions",
        "issue %",
        "lanes",
        "warps %",
    ]
    return table(headings, (_counter_row(name, found, copy_rate) for name, found in rows))


def _counter_row(name: str, launches: Sequence[Counters], copy_rate: float | None) -> list[str]:
    nanoseconds = _sum(launches, "nanoseconds")
    rate = _sum(launches, "bytes") / nanoseconds if nanoseconds else 0.0
    return [
        name,
        str(len(launches)),
        f"{nanoseconds / 1e3:,.1f}",
        f"{rate:,.0f}",
        f"{rate * 1e9 / copy_rate:.2f}" if copy_rate else "",
        f"{_sum(launches, 'instructions'):,.0f}",
        *(f"{_mean(launches, key):.1f}" for key in ("issue", "lanes", "occupancy")),
    ]


def _sum(launches: Iterable[Counters], key: str) -> float:
    return sum(each.values.get(key, 0.0) for each in launches)


def _mean(launches: Sequence[Counters], key: str) -> float:
    """By time: what the kernel is like while it runs."""
    weights = [each.values.get("nanoseconds", 1.0) for each in launches]
    total = sum(each.values.get(key, 0.0) * weight for each, weight in zip(launches, weights, strict=True))
    return total / (sum(weights) or 1.0)


def short_name(name: str) -> str:
    """Without namespaces, return type and parameters."""
    for part in ("(anonymous namespace)::", "<unnamed>::", "treelet::cuda::", "treelet::", "void "):
        name = name.replace(part, "")
    depth = 0
    for index, character in enumerate(name):
        depth += {"<": 1, ">": -1}.get(character, 0)
        if character == "(" and depth == 0:
            return name[:index]
    return name
