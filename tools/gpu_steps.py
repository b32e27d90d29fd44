"""The steps of tools/gpu.py: what each runs, and what it cannot run without."""

from __future__ import annotations

import importlib.util
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
    "*DeviceAllHits.AreTheFirst*",
    "*DevicePoints.CountUpTo*",
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
    "queries": {"bench-queries": measure("queries")},
    "builds": {"bench-builds": measure("copy", "builds")},
    "versus": {"bench-versus": measure("versus")},
    "profile": {"resources": list_resources, "counters": count},
    "report": {"write-report": report},
}
STEPS = {name: step for steps in SLICES.values() for name, step in steps.items()}
