"""Count what splitting triangles is worth: never, always, by trial (`trysplit`) and on the way down (`sbvh`).

TREELET_SCENES=FOLDER python bench/split_gate.py --out out/split_gate [--scenes city kitchen ...]

Prints a line a scene: work of diffuse rays (nodes + 0.2 triangles) and SAH of every recipe over those of the
unsplit one, what the trial found, and what it took. Scenes that are not there are skipped. Work is counted,
so it is the same on every machine; build times are those of all threads together.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

import treelet
from treelet import scenes
from treelet.bench import Measurement, write_measurements
from treelet.bench.measure import Candidate, Plan, make_ray_sets, tree_details
from treelet.mesh import Mesh
from treelet.render.rays import Rays
from treelet.view import automatic_view

TRIANGLE_WORK = 0.2  # in visits of a node: three triangles a block, 0.6 a block
EMBEDDED_TRIANGLES = 200_000
ROTATED = "-rotated"  # by 25 degrees about x, then 30 about z
SCENES = [
    "kitchen",
    "conference",
    "crytek_sponza",
    "crytek_sponza-rotated",
    "clinic",
    "hospital_mep",
    "dragon",
    "sibenik",
    "san_miguel",
    "vegetation",
    "bmw_m6",
    "city",
    "interior",
    "interior-rotated",
    "terrain",
    "menger",
    "forest",
    "soup",
]
_TREELET = "lbvh > treelet(rounds=2, gamma=14)"
CANDIDATES = (
    Candidate("unsplit", f"{_TREELET} > bvh8"),
    Candidate("always", f"presplit(budget=30) > {_TREELET} > bvh8"),
    Candidate("by trial", f"trysplit(budget=30) > {_TREELET} > bvh8"),
    Candidate("unsplit, reinsert", f"{_TREELET} > reinsert > bvh8"),
    Candidate("always, reinsert", f"presplit(budget=30) > {_TREELET} > reinsert > bvh8"),
    Candidate("by trial, reinsert", f"trysplit(budget=30) > {_TREELET} > reinsert > bvh8"),
    Candidate("sbvh", f"sbvh(budget=50) > {_TREELET.removeprefix('lbvh > ')} > reinsert > bvh8"),
)
WORK_LABELS = [candidate.label for candidate in CANDIDATES[1:]]
SAH_LABELS = ("always", "sbvh")
TIME_LABELS = ("unsplit", "by trial", "by trial, reinsert", "sbvh")  # processor time a triangle


def load(name: str) -> Mesh | None:
    """A scene by its name, in float32; None where it is not there."""
    plain = name.removesuffix(ROTATED)
    is_embedded = plain in scenes.names()
    if not is_embedded and plain not in scenes.external_names():
        return None
    mesh = scenes.load(plain, triangles=EMBEDDED_TRIANGLES if is_embedded else None).rounded()
    if plain == name:
        return mesh
    return replace(mesh, vertices=rotate(mesh.vertices), name=name, views=())


def rotate(vertices: np.ndarray) -> np.ndarray:
    """(V, 3) float32 turned by 25 degrees about x, then by 30 about z."""
    about_x, about_z = np.radians(25.0), np.radians(30.0)
    x_turn = [[1, 0, 0], [0, np.cos(about_x), -np.sin(about_x)], [0, np.sin(about_x), np.cos(about_x)]]
    z_turn = [[np.cos(about_z), -np.sin(about_z), 0], [np.sin(about_z), np.cos(about_z), 0], [0, 0, 1]]
    return (vertices.astype(np.float64) @ np.array(x_turn).T @ np.array(z_turn).T).astype(np.float32)


def make_rays(mesh: Mesh, bvh: treelet.Bvh) -> list[Rays]:
    """Diffuse rays of three bounces from three of the mesh's views."""
    plan = Plan(CANDIDATES, kinds=("diffuse",), width=256, height=160, bounces=3)
    views = mesh.views[:3] or (automatic_view(mesh.vertices, mesh.faces),)
    return [rays for view in views for rays in make_ray_sets(bvh, mesh, view, plan)]


def count_work(bvh: treelet.Bvh, ray_sets: list[Rays]) -> float:
    """Mean work of a ray, in visits of a node."""
    nodes = triangles = 0
    for rays in ray_sets:
        work = bvh.traversal_cost(rays.origins, rays.directions)
        nodes += int(work.nodes.sum())
        triangles += int(work.triangles.sum())
    return (nodes + TRIANGLE_WORK * triangles) / sum(len(rays) for rays in ray_sets)


def measure(mesh: Mesh, builds: int) -> list[Measurement]:
    """A line for each candidate: processor seconds of its builds, and what its tree is like."""
    seconds: dict[str, list[float]] = {candidate.label: [] for candidate in CANDIDATES}
    trees: dict[str, treelet.Bvh] = {}
    for _ in range(builds):
        for candidate in CANDIDATES:
            start = time.process_time()
            trees[candidate.label] = treelet.build(mesh.vertices, mesh.faces, candidate.recipe)
            seconds[candidate.label].append(time.process_time() - start)
    ray_sets = make_rays(mesh, trees["unsplit"])
    lines = []
    for label, samples in seconds.items():
        report = trees[label].report
        details = tree_details(report, with_epo=False) | {
            "clock": "processor time of all threads",
            "diffuse_rays": sum(len(rays) for rays in ray_sets),
            "diffuse_work": count_work(trees[label], ray_sets),
        }
        lines.append(
            Measurement(
                "build",
                mesh.name,
                len(mesh.faces),
                label,
                report.recipe,
                samples,
                threads=treelet.thread_count(),
                details=details,
            )
        )
    return lines


def describe(lines: list[Measurement]) -> str:
    """The scene's row of the table."""
    by_label = {line.label: line for line in lines}
    plain = by_label["unsplit"]
    cells = [plain.scene, f"{plain.faces:,}".replace(",", " ")]
    for part, labels in (("diffuse_work", WORK_LABELS), ("sah", SAH_LABELS)):
        cells.append(f"{plain.details[part]:.1f}")
        cells += [f"{by_label[label].details[part] / plain.details[part]:.2f}" for label in labels]
    for label in ("by trial", "by trial, reinsert"):
        note = next(stage["name"] for stage in by_label[label].details["stages"] if ":" in stage["name"])
        cells.append(note.removeprefix("count work: ").replace(" with splits", ""))
    cells += [f"{1e9 * by_label[label].seconds / plain.faces:.0f}" for label in TIME_LABELS]
    return "| " + " | ".join(cells) + " |"


def header() -> str:
    """The table's head; other numbers of work and SAH are relative to the unsplit one."""
    cells = ["scene", "triangles", "work, unsplit", *WORK_LABELS, "SAH, unsplit", *SAH_LABELS]
    cells += ["trial", "trial, reinsert", *(f"ns, {label}" for label in TIME_LABELS)]
    return "| " + " | ".join(cells) + " |\n|" + "---|" * len(cells)


def main() -> None:
    """Measure the scenes, print a row for each and write their lines."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("out/split_gate"))
    parser.add_argument("--scenes", nargs="+", default=SCENES)
    parser.add_argument("--builds", type=int, default=3)
    arguments = parser.parse_args()
    print(header())
    for name in arguments.scenes:
        mesh = load(name)
        if mesh is None:
            continue
        lines = measure(mesh, arguments.builds)
        print(describe(lines), flush=True)
        write_measurements(arguments.out / f"{name}.jsonl", lines)


if __name__ == "__main__":
    main()
