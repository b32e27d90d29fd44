"""Check that what device code may call holds nothing that nvcc is known to compile wrongly in silence.

nvcc 13.0 with libstdc++ takes the builtin inside std::countl_zero of 64-bit values and inside
std::countr_zero for a constant: no error, no warning, a wrong tree. core/bits.h has what to call instead.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[1] / "src" / "treelet"
FORBIDDEN = re.compile(r"std::count[lr]_(zero|one)\b")
ALLOWED = {"core/bits.h"}


def may_run_on_device(path: Path, text: str) -> bool:
    """Device files, and headers with functions for both."""
    return path.suffix in (".cu", ".cuh") or (path.suffix == ".h" and "TREELET_HD" in text)


def violations() -> list[str]:
    """One line a place."""
    found = []
    for path in sorted(SOURCE.glob("*/*")):
        name = path.relative_to(SOURCE).as_posix()
        text = path.read_text(encoding="utf-8")
        if name in ALLOWED or not may_run_on_device(path, text):
            continue
        for number, line in enumerate(text.splitlines(), start=1):
            code = line.partition("//")[0]
            if match := FORBIDDEN.search(code):
                found.append(
                    f"src/treelet/{name}:{number}: {match[0]} is wrong on the device: see core/bits.h"
                )
    return found


if __name__ == "__main__":
    found = violations()
    print("\n".join(found) or "device code: clean")
    sys.exit(1 if found else 0)
