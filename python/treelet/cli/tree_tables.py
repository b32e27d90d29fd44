"""Tables about one tree."""

from __future__ import annotations

from typing import Any

from treelet.cli.output import print_table
from treelet.cli.text import bar, byte_count, count, milliseconds

_HIGHEST_BAR = 24  # columns


def tree_facts(bvh: Any, with_epo: bool = True) -> dict[str, Any]:
    """The report as JSON-able values; EPO is the only expensive one."""
    report = bvh.report
    facts = {
        "recipe": report.recipe,
        "build_seconds": float(report.build_seconds),
        "stages": [{"name": stage.name, "seconds": float(stage.seconds)} for stage in report.stages],
        "leaf_histogram": {str(size): int(number) for size, number in sorted(report.leaf_histogram.items())},
        "sah": float(report.sah),
    }
    for name in (
        "faces",
        "references",
        "left_out_non_finite",
        "left_out_degenerate",
        "nodes",
        "leaves",
        "depth",
        "bytes",
    ):
        facts[name] = int(getattr(report, name))
    return facts | ({"epo": float(report.epo)} if with_epo else {})


def print_stages(mesh_name: str, bvh: Any) -> None:
    """Milliseconds and shares of the build's stages, in order."""
    report = bvh.report
    total = report.build_seconds or 1.0
    rows = [
        [
            stage.name,
            milliseconds(stage.seconds),
            f"{100.0 * stage.seconds / total:.0f} %",
            bar(stage.seconds / total),
        ]
        for stage in report.stages
    ]
    rows.append([("all", "bold"), (milliseconds(report.build_seconds), "bold"), "", ""])
    title = f"{mesh_name}: {count(report.faces)} triangles"
    print_table(title, ["stage", ("ms", "right"), ("share", "right"), ""], rows)


def print_statistics(bvh: Any, with_epo: bool = True) -> None:
    """What the tree is like."""
    report = bvh.report
    rows = [
        ["recipe", report.recipe],
        ["SAH cost", f"{report.sah:.2f}"],
        *([["EPO", f"{report.epo:.3f}"]] if with_epo else []),
        ["nodes", count(report.nodes)],
        ["leaves", count(report.leaves)],
        ["triangles a leaf", f"{report.references / max(report.leaves, 1):.2f}"],
        ["depth", count(report.depth)],
        ["references", count(report.references)],
        [
            "memory",
            f"{byte_count(report.bytes)}, {report.bytes / max(report.references, 1):.1f} B a reference",
        ],
        ["left out, not finite", count(report.left_out_non_finite)],
        ["left out, degenerate", count(report.left_out_degenerate)],
    ]
    print_table("Tree", ["", ("", "right")], rows)


def print_leaf_histogram(bvh: Any) -> None:
    """How many leaves hold how many triangles."""
    histogram = sorted(bvh.report.leaf_histogram.items())
    most = max((number for _, number in histogram), default=1)
    rows = [
        [str(size), count(number), bar(number / most, _HIGHEST_BAR)] for size, number in histogram if number
    ]
    print_table("Leaves by size", [("triangles", "right"), ("leaves", "right"), ""], rows)
