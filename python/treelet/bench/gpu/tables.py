"""The tables that measurements of a GPU make: builds and their stages, rays, calls, other tracers."""

from __future__ import annotations

from collections.abc import Iterator

from treelet.bench.gpu.queries import KINDS as QUERIES
from treelet.bench.gpu.results import Results, Scene, table
from treelet.bench.records import Measurement

KINDS = ("primary", "diffuse", "ambient_occlusion")
# What a visit of a node and a test of a triangle read, and a ray and its hit read and write.
_READS = {"bvh2": (64, 40), "bvh8": (224, 40), "cwbvh": (80, 48)}
_RAY_BYTES = 24 + 16


def sections(results: Results) -> Iterator[tuple[str, list[str]]]:
    """A heading and a table each; the table is empty where nothing was measured for it."""
    yield "Builds", builds(results)
    yield "Stages of builds against copies", stages(results)
    yield "Updates, ms", updates(results)
    yield "Rays, Grays/s", rays(results)
    yield "Bytes of rays against copies", ray_limits(results)
    yield "Calls from Python, microseconds", calls(results)
    yield "Rays from the host", streams(results)
    yield "Other queries, millions a second", queries(results)
    yield "Other tracers, Grays/s", versus(results)


def builds(results: Results) -> list[str]:
    """Seconds of the device and of the call."""
    rows = []
    for scene, _ in results.measured("build"):
        for each in scene.of_kind("build", "builds") or scene.of_kind("build"):
            call = scene.find("build_call", each.label)
            cells = [
                f"{each.faces:,}",
                f"{each.seconds * 1e3:.2f}",
                f"{call.seconds * 1e3:.2f}" if call else "",
                f"{each.faces / each.seconds / 1e6:,.0f}",
                f"{each.details['bytes'] / 1e6:.1f}",
                f"{each.details['sah']:.1f}",
            ]
            rows.append([scene.name, each.label, *cells])
    return table(["scene", "recipe", "triangles", "ms", "ms, call", "Mtri/s", "MB", "SAH"], rows, left=2)


def stages(results: Results) -> list[str]:
    """Each stage against a copy of as many bytes: 1 is a stage at full bandwidth."""
    rate = results.copy_rate
    rows = []
    for scene, measurements in results.measured("build", "builds"):
        for each in measurements:
            for stage in each.details["stages"]:
                speed = stage.get("bytes_per_second")
                cells = [
                    f"{each.faces:,}",
                    f"{stage['seconds'] * 1e3:.3f}",
                    f"{speed / 1e9:,.0f}" if speed else "",
                    f"{rate / speed:.1f}" if speed and rate else "",
                ]
                rows.append([scene.name, each.label, stage["name"], *cells])
    headings = ["scene", "recipe", "stage", "triangles", "ms", "GB/s at least", "times a copy's"]
    return table(headings, rows, left=3)


def updates(results: Results) -> list[str]:
    """Refit and rebuild of trees whose vertices all moved."""
    rows = []
    for scene, refits in results.measured("refit"):
        for each in refits:
            rebuild = scene.find("rebuild", each.label)
            cells = [f"{each.seconds * 1e3:.3f}", f"{rebuild.seconds * 1e3:.3f}" if rebuild else ""]
            growth = each.details["layout_sah"] / each.details["layout_sah_at_build"]
            rows.append([scene.name, each.label, f"{each.faces:,}", *cells, f"{growth:.2f}"])
    return table(["scene", "recipe", "triangles", "refit", "rebuild", "SAH after the refit"], rows, left=2)


def rays(results: Results) -> list[str]:
    """Rates, and the work of a diffuse ray."""
    rows = []
    for scene in results.scenes:
        labels = dict.fromkeys(each.label for kind in KINDS for each in scene.of_kind(kind, "rays"))
        rows += [_ray_row(scene, label) for label in labels]
    headings = ["scene", "recipe", "primary", "diffuse", "occlusion", "nodes", "triangles", "as the CPU"]
    return table(headings, rows, left=2)


def _ray_row(scene: Scene, label: str) -> list[str]:
    found = [scene.find(kind, label) for kind in KINDS]
    work = found[1].details if found[1] else {}
    wrong = sum(each.details.get("disagreements", 0) for each in found if each)
    return [
        scene.name,
        label,
        *(f"{each.rays_per_second / 1e9:.3f}" if each else "" for each in found),
        *(f"{work[name]:.1f}" if name in work else "" for name in ("nodes_per_ray", "triangles_per_ray")),
        "yes" if wrong == 0 else f"no: {wrong} rays",
    ]


def ray_limits(results: Results) -> list[str]:
    """Bytes that tracing asks the caches for, against what a copy gets from memory."""
    rate = results.copy_rate
    rows = []
    for scene in results.scenes:
        for kind in KINDS[:2]:
            rows += [_limit_row(scene, each, rate) for each in scene.of_kind(kind, "rays") if _reads(each)]
    return table(["scene", "recipe", "rays", "bytes a ray", "GB/s asked for", "of a copy's"], rows, left=3)


def _limit_row(scene: Scene, each: Measurement, rate: float | None) -> list[str]:
    wanted = _reads(each)
    speed = wanted * each.rays_per_second
    share = f"{speed / rate:.2f}" if rate else ""
    return [scene.name, each.label, each.kind, f"{wanted:,.0f}", f"{speed / 1e9:,.0f}", share]


def _reads(each: Measurement) -> float:
    layout = each.recipe.rpartition(">")[2].strip().partition("(")[0]
    if layout not in _READS or "nodes_per_ray" not in each.details:
        return 0.0
    node, triangle = _READS[layout]
    work = node * each.details["nodes_per_ray"] + triangle * each.details["triangles_per_ray"]
    return work + _RAY_BYTES


def calls(results: Results) -> list[str]:
    """What a call from Python costs."""
    rows = []
    for scene, measurements in results.measured("call_kernel"):
        for each in measurements:
            others = [scene.find(kind, each.label) for kind in ("call_enqueue", "call_overhead")]
            cells = [f"{found.seconds * 1e6:.1f}" if found else "" for found in (each, *others)]
            rows.append([each.label, f"{each.rays:,}", *cells])
    return table(["call", "rays", "device", "until it returns", "beyond the device"], rows)


def streams(results: Results) -> list[str]:
    """Rates with the copies to the device and back."""
    rows = []
    for scene, measurements in results.measured("stream"):
        for each in measurements:
            speed = each.details["bytes"] / each.seconds
            cells = [f"{each.rays:,}", f"{each.rays_per_second / 1e9:.3f}", f"{speed / 1e9:.1f}"]
            rows.append([scene.name, each.label, *cells])
    return table(["scene", "recipe", "rays", "Grays/s", "GB/s copied"], rows, left=2)


def queries(results: Results) -> list[str]:
    """Rays or points whose answers are found, a column a query."""
    rows = []
    for scene, measurements in results.measured(QUERIES[0]):
        for label in dict.fromkeys(each.label for each in measurements):
            found = [scene.find(kind, label) for kind in QUERIES]
            rates = (f"{each.rays_per_second / 1e6:.1f}" if each else "" for each in found)
            rows.append([scene.name, label, *rates])
    return table(["scene", "recipe", *(kind.replace("_", " ") for kind in QUERIES)], rows, left=2)


def versus(results: Results) -> list[str]:
    """Other tracers and ours on the same rays, by the host's clock."""
    rows = []
    for scene in results.scenes:
        found = [each for kind in KINDS for each in scene.of_kind(f"{kind}_versus")]
        rows += [_versus_row(scene, label) for label in dict.fromkeys(each.label for each in found)]
    headings = ["scene", "tracer", "build ms", "primary", "diffuse", "occlusion", "same hit"]
    return table(headings, rows, left=2)


def _versus_row(scene: Scene, label: str) -> list[str]:
    build = scene.find("build_versus", label) or scene.find("build_call", label)
    found = [scene.find(f"{kind}_versus", label) for kind in KINDS]
    same = [each.details["same_hit"] for each in found if each and "same_hit" in each.details]
    return [
        scene.name,
        label,
        f"{build.seconds * 1e3:.2f}" if build else "",
        *(f"{each.rays_per_second / 1e9:.3f}" if each else "" for each in found),
        f"{min(same):.6f}" if same else "",
    ]
