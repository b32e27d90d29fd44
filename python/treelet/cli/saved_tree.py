"""What commands that take a mesh do with a tree from a file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

EXTENSION = ".treelet"
_MAGIC = b"\x89treelet"
_SHOWN_VIOLATIONS = 10


def is_saved_tree(mesh: str) -> bool:
    """Whether a command line argument names a tree in place of a mesh."""
    path = Path(mesh)
    return path.suffix.lower() == EXTENSION or _begins_with_magic(path)


def _begins_with_magic(path: Path) -> bool:
    try:
        with path.open("rb") as file:
            return file.read(len(_MAGIC)) == _MAGIC
    except OSError:
        return False


def show_saved_tree(path: str, json: bool) -> None:
    """`treelet info`: what is in the file, every checksum compared."""
    import treelet
    from treelet.cli.output import print_json
    from treelet.cli.tree_tables import print_leaf_histogram, print_statistics, tree_facts

    bvh = treelet.load(path, verify=True)
    facts = _file_facts(path, bvh)
    if json:
        print_json({"file": facts, "bvh": tree_facts(bvh)})
        return
    _print_file_facts(Path(path).name, facts)
    print_statistics(bvh)
    print_leaf_histogram(bvh)


def check_saved_tree(path: str, json: bool) -> bool:
    """`treelet validate`: whether the tree is sound. A damaged file is an error before."""
    import treelet
    from treelet.cli.output import console, print_json
    from treelet.cli.text import count

    bvh = treelet.load(path, verify=True)
    violations = bvh.validate()
    if json:
        print_json({"passed": not violations, "file": _file_facts(path, bvh), "violations": violations})
        return not violations
    out = console()
    out.print("[green]ok     [/green]", "checksums")
    mark = "[red]FAILED [/red]" if violations else "[green]ok     [/green]"
    out.print(mark, f"violations in the tree: {count(len(violations))}")
    for violation in violations[:_SHOWN_VIOLATIONS]:
        out.print(f"    {violation}", markup=False)
    return not violations


def _file_facts(path: str, bvh: Any) -> dict[str, Any]:
    import numpy as np

    from treelet import _core

    info = _core.read_file_info(path)
    bounds = np.where(np.isfinite(bvh.bounds), bvh.bounds, 0.0)
    return {
        "format_version": int(info["version"]),
        "layout": str(info["layout"]),
        "bytes": int(info["bytes"]),
        "mesh_hash": bvh.mesh_hash,
        "offset": bvh.offset.tolist(),
        "low": bounds[0].tolist(),
        "high": bounds[1].tolist(),
    }


def _print_file_facts(name: str, facts: dict[str, Any]) -> None:
    from treelet.cli.output import print_table
    from treelet.cli.text import byte_count, coordinates

    rows = [
        ["format", f"version {facts['format_version']}, {facts['layout']}"],
        ["size", byte_count(facts["bytes"])],
        ["checksums", "right"],
        ["mesh", facts["mesh_hash"]],
        ["bounds, low", coordinates(facts["low"])],
        ["bounds, high", coordinates(facts["high"])],
        ["offset", coordinates(facts["offset"])],
    ]
    print_table(name, ["", ("", "right")], rows)
