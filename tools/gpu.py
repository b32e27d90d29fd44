"""Build, test and measure treelet on this machine's GPU, with what is installed; downloads nothing.

python tools/gpu.py [SLICE or STEP ...] [--budget SECONDS] [--out FOLDER] [--resume]

Needs nvcc, CMake, Ninja and a C++ compiler; for the Python half nanobind, NumPy and pytest in the Python
that runs this; for the C++ tests GoogleTest (installed, in /usr/src/googletest, or where TREELET_GTEST_ROOT
says); for the checks compute-sanitizer, for counters Nsight Compute. What is missing is skipped and named. A
failed step does not keep later ones from running.

Slices are groups of steps, each of ten minutes or less on a large machine, so that one with a limit can take
them one by one: with --budget 570 a slice stops in time, and a measuring one goes on where it was when it is
called again. Leaves in out/gpu, or where --out says: gpu.jsonl (measurements), steps.jsonl (what became of
the steps), report.md, kernels.jsonl, counters.csv and gpu.log.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from pathlib import Path

import gpu_steps
from gpu_steps import UNFINISHED, CannotRunError, Runner


def run_step(name: str, run: Runner) -> dict[str, object]:
    """What became of one step: passed, failed, skipped or unfinished, why, and the seconds it took."""
    begin, place = time.monotonic(), run.log.stat().st_size
    print(f"{name} ...", flush=True)
    outcome, detail = "passed", ""
    try:
        if begin > run.deadline:
            raise CannotRunError("no time left")
        gpu_steps.STEPS[name](run)
    except CannotRunError as reason:
        outcome, detail = "skipped", str(reason)
    except subprocess.CalledProcessError as error:
        is_unfinished = error.returncode == UNFINISHED and name.startswith("bench")
        outcome = "unfinished" if is_unfinished else "failed"
        detail = "run it again" if is_unfinished else f"exit code {error.returncode}"
    except subprocess.TimeoutExpired:
        outcome, detail = "failed", "out of time"
    except OSError as error:
        outcome, detail = "failed", f"{error.filename}: {error.strerror}"
    if outcome == "failed":
        print_tail(run.log, place)
    seconds = round(time.monotonic() - begin, 1)
    return {"step": name, "outcome": outcome, "detail": detail, "seconds": seconds}


def print_tail(log: Path, begin: int, lines: int = 40) -> None:
    """The last lines that came after `begin`, indented."""
    with log.open("rb") as file:
        file.seek(begin)
        text = file.read().decode(errors="replace")
    print("".join(f"    {line}\n" for line in text.splitlines()[-lines:]), end="", flush=True)


def steps_of(names: list[str]) -> list[str]:
    """Slices and steps as steps, all where none is named. Raises KeyError for an unknown one."""
    slices = gpu_steps.SLICES
    found = [name for each in names or slices for name in slices.get(each, [each])]
    if unknown := [name for name in found if name not in gpu_steps.STEPS]:
        raise KeyError(unknown[0])
    return found


def passed_steps(record: Path) -> set[str]:
    """Steps whose last outcome in a steps.jsonl is that they passed."""
    if not record.exists():
        return set()
    lines = [json.loads(line) for line in record.read_text(encoding="utf-8").splitlines()]
    last = {line["step"]: line["outcome"] for line in lines}
    return {step for step, outcome in last.items() if outcome == "passed"}


def parse(arguments: list[str]) -> argparse.Namespace:
    """Read the command line; makes the folder."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    slices = gpu_steps.SLICES
    names = "; ".join(f"{name} ({', '.join(steps)})" for name, steps in slices.items())
    parser.add_argument("names", nargs="*", metavar="SLICE or STEP", help=f"by default all: {names}")
    parser.add_argument("--budget", type=float, default=3600, help="seconds for all steps together")
    parser.add_argument("--resume", action="store_true", help="leave out steps that passed, by steps.jsonl")
    parser.add_argument(
        "--out",
        type=Path,
        metavar="FOLDER",
        default=os.environ.get("OUT") or gpu_steps.ROOT / "out" / "gpu",
        help="for the results; by default the variable OUT, if set, else out/gpu",
    )
    options = parser.parse_args(arguments)
    try:
        options.steps = steps_of(options.names)
    except KeyError as error:
        parser.error(f"no such step: {error.args[0]}; there are {', '.join([*slices, *gpu_steps.STEPS])}")
    options.out = options.out.absolute()  # steps run in the root of the sources
    try:
        options.out.mkdir(parents=True, exist_ok=True)
        (options.out / "gpu.log").open("ab").close()
    except OSError as error:
        parser.error(f"cannot write to {options.out}: {error.strerror}")
    return options


def main(arguments: list[str]) -> int:
    """Run the steps that are named, by default all; return 1 if one failed, 3 if one is to be run again."""
    options = parse(arguments)
    run = Runner(options.out / "gpu.log", time.monotonic() + options.budget)
    record = options.out / "steps.jsonl"
    done = passed_steps(record) if options.resume else set()
    results = []
    for name in options.steps:
        if name in done:
            continue
        results.append(run_step(name, run))
        with record.open("a", encoding="utf-8") as file:
            file.write(json.dumps(results[-1]) + "\n")
    print(f"\n{'step':14} {'outcome':10} {'seconds':>7}  (all output: {run.log})")
    for result in results:
        print(f"{result['step']:14} {result['outcome']:10} {result['seconds']:7}  {result['detail']}")
    outcomes = {result["outcome"] for result in results}
    return 1 if "failed" in outcomes else UNFINISHED if "unfinished" in outcomes else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
