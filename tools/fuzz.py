"""Try treelet with random files, arrays, recipes and calls, most of them wrong, until the time is over.

    python tools/fuzz.py [--minutes N] [--seed S] [--case KIND:NUMBER]

A worker process runs the cases (tools/fuzz_cases.py); if it dies or a case hangs, that is a finding, and
another worker goes on behind it. So are errors that are not documented, messages of the binding layer,
warnings other than treelet's own, and wrong answers. Prints counts of cases by kind and how they ended, and
each finding with the case that repeats it; the exit code is 1 if there is one. With --package FOLDER treelet
comes from there, such as a build with sanitizers (CONTRIBUTING.md).
"""

from __future__ import annotations

import argparse
import os
import select
import subprocess
import sys
import time
import traceback
import warnings
from collections import Counter
from pathlib import Path
from random import Random

HANG_SECONDS = 300  # cases take milliseconds, but machines are loaded and sanitizers slow
MOST_FINDINGS = 50


def work(seed: int, first: int, only: str | None) -> None:
    """The worker: says a case's name and number before it, and how it ended after."""
    import fuzz_cases

    names = [only] if only else list(fuzz_cases.CASES)
    number = first
    while True:
        name = names[number % len(names)]
        print(f"case {name}:{number}", flush=True)
        print(f"end {run_case(fuzz_cases.CASES[name], fuzz_cases.ALLOWED, seed, number)}", flush=True)
        number += 1
        if only:
            return


def run_case(case, allowed, seed: int, number: int) -> str:
    """How the case ended: well, with a documented error, or FOUND and what."""
    import treelet

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", treelet.PrecisionWarning)
            case(Random(f"{seed}:{number}"))
    except Exception as error:
        is_helpful = bool(str(error)) and "incompatible function arguments" not in str(error)
        if isinstance(error, allowed[case]) and (is_helpful or isinstance(error, MemoryError)):
            return type(error).__name__
        print(traceback.format_exc(), file=sys.stderr, flush=True)
        return f"FOUND {type(error).__name__}: {' '.join(str(error).split())[:300]}"
    return "well"


class Tally:
    """Counts of how cases ended, and what was found."""

    def __init__(self) -> None:
        self.ends: Counter[tuple[str, str]] = Counter()
        self.findings: list[str] = []

    def add(self, case: str, end: str) -> None:
        """One case, named KIND:NUMBER."""
        kind = case.partition(":")[0]
        if end.startswith("FOUND"):
            self.findings.append(f"{case} {end.removeprefix('FOUND ')}")
            print(f"finding: {self.findings[-1]}", flush=True)
            end = "FOUND"
        self.ends[kind, end] += 1

    def table(self) -> str:
        """A line for each kind of case."""
        kinds = dict.fromkeys(kind for kind, _ in self.ends)
        lines = []
        for kind in kinds:
            counts = {end: count for (other, end), count in sorted(self.ends.items()) if other == kind}
            told = ", ".join(f"{end} {count:,}" for end, count in counts.items())
            lines.append(f"  {kind}: {sum(counts.values()):,} cases: {told}")
        return "\n".join(lines)


def watch(seed: int, first: int, only: str | None, deadline: float, tally: Tally) -> int:
    """Run one worker until it dies, hangs or the time is over; the number of the next case."""
    command = [sys.executable, __file__, "--worker", "--seed", str(seed), "--first", str(first)]
    command += ["--kind", only] if only else []
    current, number = "", first
    with subprocess.Popen(command, stdout=subprocess.PIPE) as worker:
        for line in _lines(worker, deadline):
            word, _, rest = line.partition(" ")
            if word == "case":
                current, number = rest, int(rest.partition(":")[2])
            elif word == "end":
                tally.add(current, rest)
                current = ""
            elif word == "hang":
                tally.add(current or "start:0", f"FOUND hang of more than {HANG_SECONDS} s")
                current = ""
        is_over = time.monotonic() >= deadline
        worker.kill() if is_over else None
    if not is_over and worker.returncode != 0 and current:
        tally.add(current, f"FOUND death of the process, code {worker.returncode}")
    elif not is_over and worker.returncode != 0 and number == first and not tally.ends:
        sys.exit("the worker does not start: see above")
    return number + 1


def _lines(worker: subprocess.Popen[bytes], deadline: float):
    """Lines of the worker; "hang" where none comes, and nothing more then or after the deadline."""
    assert worker.stdout is not None
    pipe, rest = worker.stdout.fileno(), b""
    while time.monotonic() < deadline:
        if not select.select([pipe], [], [], HANG_SECONDS)[0]:
            worker.kill()
            yield "hang"
            return
        data = os.read(pipe, 1 << 16)
        if not data:
            return
        *lines, rest = (rest + data).split(b"\n")
        yield from (line.decode() for line in lines)


def fuzz(minutes: float, seed: int) -> Tally:
    """Cases for so many minutes."""
    begin, tally, number = time.monotonic(), Tally(), 0
    while time.monotonic() < begin + 60 * minutes and len(tally.findings) < MOST_FINDINGS:
        number = watch(seed, number, None, begin + 60 * minutes, tally)
    print(f"{sum(tally.ends.values()):,} cases in {(time.monotonic() - begin) / 60:.1f} minutes, seed {seed}")
    return tally


def parse() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--minutes", type=float, default=1)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--case", metavar="KIND:NUMBER", help="run this one alone")
    parser.add_argument("--package", type=Path, help="the folder that treelet is imported from")
    parser.add_argument("--worker", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--first", type=int, default=0, help=argparse.SUPPRESS)
    parser.add_argument("--kind", help=argparse.SUPPRESS)
    return parser.parse_args()


def main() -> int:
    """Fuzz, tell, and return the exit code."""
    arguments = parse()
    if arguments.worker:
        if folder := os.environ.get("TREELET_FUZZ_PACKAGE"):
            sys.meta_path = [each for each in sys.meta_path if "ScikitBuild" not in type(each).__name__]
            sys.path.insert(0, folder)
        work(arguments.seed, arguments.first, arguments.kind)
        return 0
    if arguments.package:
        os.environ["TREELET_FUZZ_PACKAGE"] = str(arguments.package.absolute())
    if arguments.case:
        kind, _, number = arguments.case.partition(":")
        tally = Tally()
        watch(arguments.seed, int(number), kind, time.monotonic() + HANG_SECONDS, tally)
    else:
        tally = fuzz(arguments.minutes, arguments.seed)
    print(tally.table())
    print("\n".join(f"finding: {each}" for each in tally.findings) or "nothing found")
    return 1 if tally.findings else 0


if __name__ == "__main__":
    sys.exit(main())
