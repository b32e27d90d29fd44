"""Check that each folder of src/treelet includes only itself and the folders to its left.

The order of ``LAYERS`` is the architecture: a header of ``tree`` may include ``core`` or ``mesh``,
never ``build``. Files directly in src/treelet, such as the umbrella header, may include all.
"""

import re
import sys
from collections.abc import Iterator
from pathlib import Path

LAYERS = (
    "core",
    "mesh",
    "primitive",
    "tree",
    "build",
    "optimize",
    "layout",
    "traverse",
    "query",
    "pipeline",
    "file",
)
SUFFIXES = {".h", ".inl", ".cpp", ".cu", ".cuh"}
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')


def check_include(folder: str, delimiter: str, path: str) -> str | None:
    """Return what is wrong with one include line of a file in ``folder``, or None."""
    if not path.startswith("treelet/"):
        is_local = delimiter == '"'
        return f'include "{path}" as <treelet/folder/file.h>' if is_local else None
    parts = path.split("/")
    if len(parts) < 3:
        return f"<{path}> is for users; include what is needed"
    if parts[1] not in LAYERS:
        return f"<{path}> is in no known folder"
    if LAYERS.index(parts[1]) > LAYERS.index(folder):
        return f"{folder} may not include {parts[1]} (<{path}>)"
    return None


def check_file(file: Path, folder: str) -> Iterator[str]:
    """Yield ``file:line: message`` for each include that breaks the order."""
    for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), start=1):
        match = INCLUDE.match(line)
        violation = match and check_include(folder, match[1], match[2])
        if violation:
            yield f"{file}:{number}: {violation}"


def check_tree(root: Path) -> list[str]:
    """Return all violations below ``root``, the folder that holds the layers' folders."""
    violations = []
    for file in sorted(root.rglob("*")):
        if file.suffix not in SUFFIXES or file.parent == root:
            continue
        folder = file.relative_to(root).parts[0]
        if folder in LAYERS:
            violations += check_file(file, folder)
        else:
            violations.append(f"{file}: {folder} is not a layer; see LAYERS in {Path(__file__).name}")
    return violations


def main() -> int:
    """Check the folder given as argument, by default src/treelet; return the exit code."""
    violations = check_tree(Path(sys.argv[1] if len(sys.argv) > 1 else "src/treelet"))
    print("\n".join(violations) if violations else "layers: clean")
    return 1 if violations else 0


if __name__ == "__main__":
    sys.exit(main())
