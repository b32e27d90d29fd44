"""Build, test and measure treelet on this machine's GPU, with what is installed; downloads nothing.

python tools/gpu.py [STEP ...] [--budget SECONDS] [--out FOLDER]

Needs nvcc, CMake, Ninja and a C++ compiler; for the Python half nanobind, NumPy and pytest in the Python
that runs this; for the C++ tests GoogleTest (installed, in /usr/src/googletest, or where TREELET_GTEST_ROOT
says); for the checks compute-sanitizer. What is missing is skipped and named. A failed step does not keep
later ones from running. Leaves gpu.log and gpu.jsonl in out/gpu, or where --out says.
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
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
BUILD = ROOT / "build" / "gpu"
SITE = BUILD / "site"  # holds the Python package
TESTS = BUILD / "tests" / "treelet_gpu_tests"
CHECKS = ("memcheck", "racecheck", "synccheck", "initcheck")


class CannotRunError(Exception):
    """A step cannot run here; says why."""


@dataclass
class Runner:
    """Runs commands within a budget of seconds and keeps what they print."""

    log: Path
    deadline: float
    json_lines: list[str] = field(default_factory=list)

    def __call__(self, *command: str | Path, **environment: str) -> None:
        """Run one command; raises CalledProcessError, TimeoutExpired, or OSError where it is not found."""
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
                code = process.wait(max(1.0, self.deadline - time.monotonic()))
            except BaseException:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()
                raise
            finally:
                self._collect_json(begin)
        if code != 0:
            raise subprocess.CalledProcessError(code, command)

    def _collect_json(self, begin: int) -> None:
        with self.log.open("rb") as log:
            log.seek(begin)
            lines = log.read().decode(errors="replace").splitlines()
        self.json_lines += [line for line in lines if line.startswith("{") and _is_json(line)]


def _is_json(line: str) -> bool:
    try:
        json.loads(line)
    except ValueError:
        return False
    return True


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
    """Return the step that runs them, without the slow ones, under a tool of compute-sanitizer."""

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
            "--gtest_filter=-*Slow*",
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


def run_python(run: Runner, *arguments: str | Path) -> None:
    """Run this Python with that package."""
    if not (SITE / "treelet").exists():
        raise CannotRunError("the Python package was not built")
    run(sys.executable, *arguments, PYTHONPATH=os.pathsep.join([str(SITE), os.environ.get("PYTHONPATH", "")]))


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


def measure(run: Runner) -> None:
    """Run the benchmark of the GPU, whose records go to gpu.jsonl."""
    if not (ROOT / "python" / "treelet" / "bench" / "gpu.py").exists():
        raise CannotRunError("there is no treelet.bench.gpu")
    run_python(run, "-m", "treelet.bench.gpu")


# The quick and telling ones first, for a budget may end before the list does.
STEPS: dict[str, Callable[[Runner], None]] = {
    "machine": describe_machine,
    "configure": configure,
    "build-package": build_package,
    "import": use_package,
    "build-tests": build_tests,
    "test": run_tests,
    "test-python": test_package,
    "bench": measure,
} | {tool: sanitize(tool) for tool in CHECKS}


def run_step(name: str, run: Runner) -> dict[str, object]:
    """What became of one step: passed, failed or skipped, why, and the seconds it took."""
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
        outcome, detail = "failed", f"exit code {error.returncode}"
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


def main(arguments: list[str]) -> int:
    """Run the steps that are named, by default all; return 1 if one failed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("steps", nargs="*", metavar="STEP", help=f"of: {', '.join(STEPS)}; by default all")
    parser.add_argument("--budget", type=float, default=3600, help="seconds for all steps together")
    parser.add_argument(
        "--out",
        type=Path,
        metavar="FOLDER",
        default=os.environ.get("OUT") or ROOT / "out" / "gpu",
        help="for gpu.log and gpu.jsonl; by default the variable OUT, if set, else out/gpu",
    )
    options = parser.parse_args(arguments)
    if unknown := set(options.steps) - set(STEPS):
        parser.error(f"no such step: {', '.join(sorted(unknown))}; there are {', '.join(STEPS)}")
    out = options.out.absolute()  # steps run in the root of the sources
    run = Runner(out / "gpu.log", time.monotonic() + options.budget)
    try:
        out.mkdir(parents=True, exist_ok=True)
        run.log.write_bytes(b"")
    except OSError as error:
        parser.error(f"cannot write to {out}: {error.strerror}")
    results = []
    for name in options.steps or STEPS:
        results.append(run_step(name, run))
        lines = [*run.json_lines, *map(json.dumps, results)]
        (out / "gpu.jsonl").write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(f"\n{'step':14} {'outcome':8} {'seconds':>7}  (all output: {run.log})")
    for result in results:
        print(f"{result['step']:14} {result['outcome']:8} {result['seconds']:7}  {result['detail']}")
    return 1 if any(result["outcome"] == "failed" for result in results) else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
