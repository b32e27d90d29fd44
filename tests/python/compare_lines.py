"""Lines of a comparison with round numbers, so that what a report must say can be worked out by hand."""

from __future__ import annotations

from typing import Any

from treelet.bench import Measurement

REFERENCE = "SBVH"
RAYS = 1_000_000
# Label: recipe, build seconds, seconds for RAYS diffuse rays; the second scene takes twice as long for both.
RECIPES = {
    "SBVH": ("sbvh(budget=100) > bvh8(leaf=8)", 10.0, 1.0),
    "LBVH": ("lbvh > bvh8(leaf=8)", 0.1, 2.0),
    "treelets of 6": ("lbvh > treelet(size=6, rounds=3, gamma=0) > bvh8(leaf=8)", 0.2, 1.25),
    "treelets of 7": ("lbvh > treelet(size=7, rounds=3, gamma=0) > bvh8(leaf=8)", 0.4, 1.0 / 0.9),
    "presplit 10 %": ("presplit(budget=10) > lbvh > bvh8(leaf=8)", 0.2, 1.6),
    "presplit 30 %": ("presplit(budget=30) > lbvh > bvh8(leaf=8)", 0.3, 1.5),
}
SCENES = {"small": (1000, 1.0), "large": (4000, 2.0)}
MACHINE = {"cpu": "a processor", "cores": 2, "system": "Linux", "python": "3.12"}


def line(scene: str, label: str, kind: str, seconds: float, **more: Any) -> Measurement:
    """One measurement, its three samples around `seconds`."""
    details = {"session": "1", "row": f"{scene} {label} {kind} {more.get('view')}", **more}
    return Measurement(
        kind=kind,
        scene=scene,
        faces=SCENES[scene][0],
        label=label,
        recipe=RECIPES[label][0],
        samples=[seconds, 0.5 * seconds, 2.0 * seconds],
        rays=0 if kind == "build" else RAYS,
        threads=2,
        details=details,
        version="1.0",
        commit="0123456789ab",
        machine=MACHINE,
        timestamp="2030-01-01T00:00:00+00:00",
    )


def golden_lines() -> list[Measurement]:
    """Every recipe on both scenes, from two views."""
    lines = []
    for scene, (faces, slowness) in SCENES.items():
        for number, (label, (_, build, trace)) in enumerate(RECIPES.items()):
            facts = {"sah": 50.0 + number, "epo": 1.0 + number, "references": faces, "bytes": 70 * faces}
            lines.append(line(scene, label, "build", slowness * build, **facts))
            for view in ("near", "far"):
                work = {"view": view, "nodes_per_ray": 10.0 + number, "triangles_per_ray": 5.0}
                lines.append(line(scene, label, "diffuse", slowness * trace, **work))
    return lines


def begin(**more: Any) -> dict[str, Any]:
    """The line that a session starts with."""
    facts = {
        "event": "begin",
        "session": "1",
        "title": "Golden",
        "reference": REFERENCE,
        "recipes": {label: recipe for label, (recipe, _, _) in RECIPES.items()},
        "kinds": ["diffuse"],
        "commit": "0123456789ab",
    }
    return facts | more
