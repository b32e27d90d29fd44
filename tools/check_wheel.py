"""Check a built wheel as a user would meet it: its size, its files, its binary, and a first query.

    python tools/check_wheel.py dist/treelet-*.whl [--python PYTHON ...]

Every PYTHON gets a fresh virtual environment that holds the wheel and what it asks for, nothing else. A wheel
for the stable ABI must pass with all versions from its tag's on; by default only the running one is asked.
"""

import argparse
import json
import re
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

MOST_BYTES = 10_000_000
RUN_TIME_PACKAGES = {"treelet", "numpy", "nanobind-backend"}
WANTED_FILES = (
    r"treelet/py\.typed",
    r"treelet/_core\.pyi",
    r"treelet/_core[^/]*\.(so|pyd)",
    *(
        rf"treelet-[^/]*\.dist-info/licenses/{name}"
        for name in ("LICENSE", "NOTICE", r"LICENSES/nanobind\.txt")
    ),
)

# Runs in the fresh environment. The time of an import is told, not judged: it is mostly numpy's.
PROBE = """
import importlib.metadata, json, time
start = time.perf_counter()
import numpy as np
after_numpy = time.perf_counter()
import treelet
after_treelet = time.perf_counter()
tree = treelet.build(np.eye(3, dtype=np.float32), [[0, 1, 2]])
hits = tree.intersect([[0, 0, 0], [9, 9, 9]], [[1, 1, 1], [1, 1, 1]])
assert hits.face.tolist() == [0, -1], hits
assert abs(hits.t[0] - 1 / 3) < 1e-6, hits
assert tree.validate() == []
packages = [each.metadata["Name"].lower().replace("_", "-") for each in importlib.metadata.distributions()]
times = [1e3 * (after_numpy - start), 1e3 * (after_treelet - after_numpy)]
print(json.dumps({"version": treelet.__version__, "packages": packages, "import_ms": times}))
"""


def check_files(wheel: Path) -> list[str]:
    """What is wrong with the size and the contents."""
    size = wheel.stat().st_size
    print(f"{wheel.name}: {size / 1e6:.2f} MB")
    problems = [f"{size:,} bytes, more than {MOST_BYTES:,}"] if size > MOST_BYTES else []
    names = zipfile.ZipFile(wheel).namelist()
    problems += [f"no file {each}" for each in WANTED_FILES if not any(re.fullmatch(each, n) for n in names)]
    return problems + [
        f"unexpected {name}" for name in names if not re.match(r"treelet(/|-[^/]+\.dist-info/)", name)
    ]


def check_binary(wheel: Path) -> list[str]:
    """Whether the extension keeps to the stable ABI; on Linux it also tells the oldest glibc that will do."""
    problems = []
    if "-abi3-" in wheel.name and _run([sys.executable, "-m", "abi3audit", "--strict", str(wheel)]) is None:
        problems.append("breaks the stable ABI (see above)")
    if sys.platform == "linux":
        told = _run([sys.executable, "-m", "auditwheel", "show", str(wheel)]) or ""
        tag = re.search(r'platform tag: "(\w+)"', " ".join(told.split()))
        print(f"  could be tagged {tag[1]}" if tag else "  auditwheel names no platform tag")
    return problems


def check_install(wheel: Path, python: str) -> list[str]:
    """Install into a fresh environment without extras, import, query."""
    with tempfile.TemporaryDirectory(prefix="treelet-wheel-") as folder:
        if _run([python, "-m", "venv", folder]) is None:
            return [f"{python}: no virtual environment"]
        inside = Path(folder) / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")
        install = [str(inside), "-m", "pip", "--disable-pip-version-check", "--quiet", "install", str(wheel)]
        answer = _run(install) is not None and _run([str(inside), "-I", "-c", PROBE], cwd=folder)
    if not answer:
        return [f"{python}: see above"]
    told = json.loads(answer)
    numpy_ms, own_ms = told["import_ms"]
    print(f"  {python}: {told['version']}, import {own_ms:.0f} ms on top of numpy's {numpy_ms:.0f} ms")
    extra = set(told["packages"]) - RUN_TIME_PACKAGES - {"pip", "setuptools"}
    return [f"{python}: also brings {', '.join(sorted(extra))}"] if extra else []


def _run(command: list[str], cwd: str | None = None) -> str | None:
    """The standard output, or None after telling what failed."""
    result = subprocess.run(command, capture_output=True, text=True, cwd=cwd)
    if result.returncode == 0:
        return result.stdout
    print(f"{' '.join(command)} failed:\n{result.stdout}{result.stderr}", file=sys.stderr)
    return None


def main() -> int:
    """Check, tell, and return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("wheel", type=Path)
    parser.add_argument("--python", nargs="*", default=[sys.executable], help="interpreters to install it in")
    arguments = parser.parse_args()
    wheel = arguments.wheel.resolve()
    problems = check_files(wheel) + check_binary(wheel)
    for python in arguments.python:
        problems += check_install(wheel, python)
    print("\n".join(f"  {each}" for each in problems) or "  all well")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
