"""List what the CUDA kernels of a build use, as ptxas said, and fail when one spills registers.

python tools/kernel_resources.py build/cuda [--json] [--allow-spill NAME ...]

Reads the logs that tools/keep_output.py leaves in the build folder. A kernel that spills keeps values in
memory that were meant for registers: give it a smaller block, bound its launch, or allow it by name.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass, replace
from fnmatch import fnmatchcase
from functools import partial
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]

ENTRY = re.compile(r"ptxas info\s*: Compiling entry function '(\w+)' for '(\w+)'")
PROPERTIES = re.compile(r"ptxas info\s*: Function properties for '?(\w+)'?")
STACK = re.compile(r"\s*(\d+) bytes stack frame, (\d+) bytes spill stores, (\d+) bytes spill loads")
USED = re.compile(r"ptxas info\s*: Used (\d+) registers")
SHARED = re.compile(r"(\d+) bytes smem")


@dataclass
class Resources:
    """What one kernel, or a device function that was not inlined, uses; sizes are bytes a thread."""

    source: str
    name: str
    architecture: str
    is_kernel: bool
    registers: int = 0
    spill_stores: int = 0
    spill_loads: int = 0
    stack: int = 0
    shared: int = 0  # a block

    @property
    def spills(self) -> bool:
        """Whether registers did not suffice."""
        return self.spill_stores + self.spill_loads > 0


def parse_log(text: str, source: str) -> Iterator[Resources]:
    """Yield every function of one compilation, names as the linker sees them."""
    functions: dict[tuple[str, str], Resources] = {}
    kernel, architecture, name = "", "", ""
    for line in text.splitlines():
        if match := ENTRY.match(line):
            kernel, architecture = match.groups()
            functions[kernel, architecture] = Resources(source, kernel, architecture, is_kernel=True)
        elif match := PROPERTIES.match(line):
            name = match[1]
            other = Resources(source, name, architecture, is_kernel=False)
            functions.setdefault((name, architecture), other)
        elif match := STACK.match(line):
            function = functions[name, architecture]
            function.stack, function.spill_stores, function.spill_loads = map(int, match.groups())
        elif match := USED.match(line):
            functions[kernel, architecture].registers = int(match[1])
            shared = SHARED.search(line)
            functions[kernel, architecture].shared = int(shared[1]) if shared else 0
    yield from functions.values()


def read_build(folder: Path) -> list[Resources]:
    """All functions of a build's CUDA files, by file and name; files that are no more are left out."""
    found: list[Resources] = []
    for log in sorted(folder.rglob("*.cu.o.log")):
        source = log.as_posix().rpartition(".dir/")[2].removesuffix(".o.log")
        if (ROOT / source).exists():
            found += parse_log(log.read_text(encoding="utf-8"), source.removeprefix("src/treelet/"))
    names = demangle([each.name for each in found])
    found = [replace(each, name=name) for each, name in zip(found, names, strict=True)]
    return sorted(found, key=lambda each: (each.source, each.name, each.architecture))


def demangle(names: list[str]) -> list[str]:
    """C++ names, where the compiler's c++filt is there to tell."""
    try:
        answer = subprocess.run(
            ["c++filt"], input="\n".join(names), capture_output=True, text=True, check=True
        )
    except (OSError, subprocess.CalledProcessError):
        return names
    return answer.stdout.splitlines()


def short_name(name: str) -> str:
    """A demangled name without parameters, return type and namespaces; template arguments if short."""
    for namespace in ("(anonymous namespace)::", "treelet::cuda::", "treelet::"):
        name = name.replace(namespace, "")
    head = re.split("[<(]", name, maxsplit=1)[0]
    arguments = template_arguments(name[len(head) :])
    path = head.split()[-1].split("::")
    shown = path[0] if len(path) == 1 else f"{path[0]} {path[-1]}"
    return shown + (arguments if len(arguments) <= 30 else "<...>")


def template_arguments(text: str) -> str:
    """The template arguments that `text` begins with, in their brackets; empty if it does not."""
    depth = 0
    for position, character in enumerate(text):
        depth += {"<": 1, ">": -1}.get(character, 0)
        if depth == 0:
            return text[: position + 1] if position > 0 else ""
    return ""


HEADINGS = ["file", "kernel", "sm", "registers", "spills", "stack", "shared"]


def table(rows: Iterable[Resources]) -> list[str]:
    """A table in Markdown that reads well as text; spills are bytes stored + loaded."""
    cells = [
        [
            each.source,
            short_name(each.name) + ("" if each.is_kernel else " (function)"),
            each.architecture.removeprefix("sm_"),
            str(each.registers) if each.is_kernel else "",
            str(each.spill_stores + each.spill_loads),
            str(each.stack),
            str(each.shared),
        ]
        for each in rows
    ]
    widths = [max(map(len, column)) for column in zip(HEADINGS, *cells, strict=True)]
    lines = [_line(HEADINGS, widths), "|" + "|".join("-" * (width + 1) + ":" for width in widths) + "|"]
    lines[1] = lines[1].replace("-:", "--", 2)
    return lines + [_line(row, widths) for row in cells]


def _line(row: list[str], widths: list[int]) -> str:
    padded = [
        cell.ljust(width) if column < 2 else cell.rjust(width)
        for column, (cell, width) in enumerate(zip(row, widths, strict=True))
    ]
    return "| " + " | ".join(padded) + " |"


def main(arguments: list[str]) -> int:
    """Print the table; return 1 when a kernel spills, 2 when there is none."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="build folder, such as build/cuda")
    parser.add_argument("--json", action="store_true", help="one JSON line a kernel, full names")
    parser.add_argument(
        "--allow-spill",
        nargs="+",
        default=[],
        metavar="NAME",
        help="kernels as named in the table; * for any characters",
    )
    options = parser.parse_args(arguments)
    found = read_build(options.folder)
    if options.json:
        print("\n".join(json.dumps(asdict(each)) for each in found))
    else:
        print("\n".join(table(found)))
    if not any(each.is_kernel for each in found):
        print(f"no kernel in {options.folder}: run `make cuda`", file=sys.stderr)
        return 2
    spilling = {short_name(each.name) for each in found if each.spills}
    spilling = {name for name in spilling if not any(map(partial(fnmatchcase, name), options.allow_spill))}
    if spilling:
        print(f"registers are spilled by: {', '.join(sorted(spilling))}", file=sys.stderr)
    return 1 if spilling else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
