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
import importlib.util
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
BUILD = ROOT / "build" / "gpu"
SITE = BUILD / "site"  # holds the Python package
TESTS = BUILD / "tests" / "treelet_gpu_tests"
CHECKS = ("memcheck", "racecheck", "synccheck", "initcheck")
# What runs under the sanitizers, each kernel once on little: they slow it down a hundredfold.
CHECKED_TESTS = (
    "*OfFew*",
    "DeviceBvhTest.AnswersLikeTheHost*",
    "DeviceSort.*",
    "DeviceRayOrder.*",
    "StreamRays.AnswersAsOneBatch*",
)
UNFINISHED = 3  # the benchmark's exit code where time ended before the measurements
MARGIN = 20.0  # seconds that the benchmark has to end in


class CannotRunError(Exception):
    """A step cannot run here; says why."""


@dataclass
class Runner:
    """Runs commands within a budget of seconds and keeps what they print."""

    log: Path
    deadline: float

    @property
    def folder(self) -> Path:
        """Where results go."""
        return self.log.parent

    def seconds_left(self) -> float:
        """Of the budget."""
        return max(1.0, self.deadline - time.monotonic())

    def __call__(self, *command: str | Path, save: str = "", **environment: str) -> None:
        """Run one command; what a successful one printed is also saved in a file of the folder, if named.

        Raises CalledProcessError, TimeoutExpired, or OSError where it is not found.
        """
        with self.log.open("ab") as log:
            log.write(f"\n$ {' '.join(map(str, command))}\n".encode())
            log.flush()
            begin = log.tell()
            process = subprocess.Popen(
                [str(part) for part in command],
                cwd=ROOT,
                env=os.environ | environment,
                stdout=log,
                stderr=subprocess.STDOUT,
                start_new_session=True,  # so that what it started ends with it
            )
            try:
                code = process.wait(self.seconds_left())
            except BaseException:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()
                raise
        if code != 0:
            raise subprocess.CalledProcessError(code, command)
        if save:
            (self.folder / save).write_bytes(self.log.read_bytes()[begin:])


def has_module(name: str) -> bool:
    """Whether the Python that runs this has a module."""
    return importlib.util.find_spec(name) is not None


def googletest_options() -> list[str] | None:
    """What tells CMake where GoogleTest is; None where it is not on this machine."""
    root = os.environ.get("TREELET_GTEST_ROOT")
    if root:
        has_sources = Path(root, "CMakeLists.txt").exists()
        return [f"-D{'FETCHCONTENT_SOURCE_DIR_GOOGLETEST' if has_sources else 'GTest_ROOT'}={root}"]
    if Path("/usr/src/googletest/CMakeLists.txt").exists():
        return []
    probe = subprocess.run(
        [os.environ.get("CXX", "c++"), "-E", "-x", "c++", "-"],
        input=b"#include <gtest/gtest.h>\n",
        capture_output=True,
        check=False,
    )
    return [] if probe.returncode == 0 else None


def describe_machine(run: Runner) -> None:
    """Record GPU, driver and compilers."""
    run("nvidia-smi")
    run("nvcc", "--version")
    run("cmake", "--version")


def configure(run: Runner) -> None:
    """Configure with the preset `gpu`, halves that cannot be built left out."""
    options = googletest_options()
    run(
        "cmake",
        "--preset=gpu",
        f"-DTREELET_BUILD_TESTS={'OFF' if options is None else 'ON'}",
        f"-DTREELET_BUILD_PYTHON={'ON' if has_module('nanobind') else 'OFF'}",
        f"-DPython_EXECUTABLE={sys.executable}",
        # As the preset `cuda`: what ptxas says of the kernels is kept beside their objects.
        f"-DCMAKE_CUDA_COMPILER_LAUNCHER={sys.executable};{ROOT / 'tools' / 'keep_output.py'}",
        "-DCMAKE_CUDA_FLAGS=-Xptxas=-v",
        *(options or []),
    )


def build_tests(run: Runner) -> None:
    """Compile tests/cuda/ for the GPU instead of the emulator."""
    if googletest_options() is None:
        raise CannotRunError("no GoogleTest; set TREELET_GTEST_ROOT to its sources")
    run("cmake", "--build", BUILD, "--target", "treelet_gpu_tests")


def run_tests(run: Runner) -> None:
    """Run them on the GPU."""
    _require_tests()
    run(TESTS, "--gtest_brief=1")


def _require_tests() -> None:
    if not TESTS.exists():
        raise CannotRunError("the C++ tests were not built")


def sanitize(tool: str) -> Callable[[Runner], None]:
    """Return the step that runs a few of them under a tool of compute-sanitizer."""

    def check(run: Runner) -> None:
        _require_tests()
        if not shutil.which("compute-sanitizer"):
            raise CannotRunError("no compute-sanitizer")
        run(
            "compute-sanitizer",
            f"--tool={tool}",
            "--error-exitcode=9",
            TESTS,
            "--gtest_brief=1",
            f"--gtest_filter={':'.join(CHECKED_TESTS)}-*Slow*",
        )

    return check


def build_package(run: Runner) -> None:
    """Put the Python package together in a folder of the build."""
    if not has_module("nanobind"):
        raise CannotRunError(f"{sys.executable} has no nanobind")
    run("cmake", "--build", BUILD, "--target", "_core", "_core_stub")
    shutil.rmtree(SITE, ignore_errors=True)
    shutil.copytree(ROOT / "python" / "treelet", SITE / "treelet")
    run("cmake", "--install", BUILD, "--component", "python", "--prefix", SITE)


def run_python(run: Runner, *arguments: str | Path, save: str = "") -> None:
    """Run this Python with that package."""
    if not (SITE / "treelet").exists():
        raise CannotRunError("the Python package was not built")
    path = os.pathsep.join([str(SITE), os.environ.get("PYTHONPATH", "")])
    run(sys.executable, *arguments, save=save, PYTHONPATH=path, TREELET_COMMIT=source_commit())


def source_commit() -> str:
    """What the package is made of, for measurements: TREELET_COMMIT, or what git says; empty if neither."""
    if named := os.environ.get("TREELET_COMMIT"):
        return named
    git = ["git", "-C", str(ROOT), "describe", "--always", "--dirty=+", "--exclude=*", "--abbrev=12"]
    try:
        return subprocess.run(git, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return ""


def use_package(run: Runner) -> None:
    """Import the package and see the GPU."""
    question = (
        "from treelet import cuda; print(cuda.devices()); assert cuda.is_available(), cuda.why_unavailable()"
    )
    run_python(run, "-c", question)


def test_package(run: Runner) -> None:
    """Run the Python tests that concern CUDA."""
    if not has_module("pytest"):
        raise CannotRunError(f"{sys.executable} has no pytest")
    run_python(run, "-m", "pytest", *sorted((ROOT / "tests" / "python").glob("*cuda*.py")))


def measure(*parts: str) -> Callable[[Runner], None]:
    """Return the step that measures parts of the benchmark which gpu.jsonl does not hold yet."""

    def bench(run: Runner) -> None:
        seconds = max(1, int(run.seconds_left() - MARGIN))
        command = ["-m", "treelet.bench.gpu", f"--parts={','.join(parts)}", f"--seconds={seconds}"]
        run_python(run, *command, f"--output={run.folder / 'gpu.jsonl'}")

    return bench


def list_resources(run: Runner) -> None:
    """Save what the compiler said of the kernels as kernels.jsonl."""
    if not list(BUILD.rglob("*.cu.o.log")):
        raise CannotRunError("nothing was compiled for CUDA")
    tool = ROOT / "tools" / "kernel_resources.py"
    run(sys.executable, tool, BUILD, "--json", "--allow-spill=*", save="kernels.jsonl")


def count(run: Runner) -> None:
    """Let Nsight Compute count what every kernel does, into counters.csv."""
    if not shutil.which("ncu"):
        raise CannotRunError("no Nsight Compute (ncu)")
    run_python(run, "-m", "treelet.bench.gpu.workload", f"--counters={run.folder / 'counters.csv'}")


def report(run: Runner) -> None:
    """Make report.md of what there is, and print the goals."""
    files = {"gpu.jsonl": "", "kernels.jsonl": "--resources=", "counters.csv": "--counters="}
    found = [f"{option}{run.folder / name}" for name, option in files.items() if (run.folder / name).exists()]
    run_python(run, "-m", "treelet.bench.gpu.report", *found, save="report.md")
    goals = (run.folder / "report.md").read_text(encoding="utf-8").partition("## Goals")[2]
    print(goals.partition("\n## ")[0].strip("\n"), flush=True)


# The quick and telling ones first, for a budget may end before the list does.
SLICES: dict[str, dict[str, Callable[[Runner], None]]] = {
    "prepare": {
        "machine": describe_machine,
        "configure": configure,
        "build-package": build_package,
        "import": use_package,
        "build-tests": build_tests,
    },
    "check": {"test": run_tests, "test-python": test_package} | {tool: sanitize(tool) for tool in CHECKS},
    "rays": {"bench-rays": measure("copy", "calls", "rays", "stream")},
    "builds": {"bench-builds": measure("copy", "builds")},
    "versus": {"bench-versus": measure("versus")},
    "profile": {"resources": list_resources, "counters": count},
    "report": {"write-report": report},
}
STEPS = {name: step for steps in SLICES.values() for name, step in steps.items()}


def run_step(name: str, run: Runner) -> dict[str, object]:
    """What became of one step: passed, failed, skipped or unfinished, why, and the seconds it took."""
    begin, place = time.monotonic(), run.log.stat().st_size
    print(f"{name} ...", flush=True)
    outcome, detail = "passed", ""
    try:
        if begin > run.deadline:
            raise CannotRunError("no time left")
        STEPS[name](run)
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
    found = [name for each in names or SLICES for name in SLICES.get(each, [each])]
    if unknown := [name for name in found if name not in STEPS]:
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
    names = "; ".join(f"{name} ({', '.join(steps)})" for name, steps in SLICES.items())
    parser.add_argument("names", nargs="*", metavar="SLICE or STEP", help=f"by default all: {names}")
    parser.add_argument("--budget", type=float, default=3600, help="seconds for all steps together")
    parser.add_argument("--resume", action="store_true", help="leave out steps that passed, by steps.jsonl")
    parser.add_argument(
        "--out",
        type=Path,
        metavar="FOLDER",
        default=os.environ.get("OUT") or ROOT / "out" / "gpu",
        help="for the results; by default the variable OUT, if set, else out/gpu",
    )
    options = parser.parse_args(arguments)
    try:
        options.steps = steps_of(options.names)
    except KeyError as error:
        parser.error(f"no such step: {error.args[0]}; there are {', '.join([*SLICES, *STEPS])}")
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
