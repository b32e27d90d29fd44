"""Compares treelet with Embree ray by ray, and judges every difference exactly."""

from __future__ import annotations

from collections import Counter

import numpy as np
from exact_oracle import exact_hits, fault, kind_of_difference
from sample_rays import Rays

import treelet

_AGREEING_CHECKS = 100  # rays on which the tracers agree that are judged all the same
_FULL_CHECKS = 20  # rays of either kind for which every face that the line may meet is tried


class Agreement:
    """What became of the rays: counts by kind, and sentences where treelet is wrong."""

    def __init__(self) -> None:
        self.counts: Counter[str] = Counter()
        self.faults: list[str] = []

    def summary(self, rays: int) -> dict[str, int]:
        kinds = ("tie", "edge miss", "wrong face")
        return {"rays": rays, **{kind: self.counts[kind] for kind in kinds}, "faults": len(self.faults)}


def trace_with_embree(mesh: treelet.Mesh, rays: Rays, robust: bool = False) -> np.ndarray:
    """The face that each ray hits, -1 for none; as its users call it, or in its robust mode."""
    from embreex import mesh_construction, rtcore_scene

    scene = rtcore_scene.EmbreeScene(robust=robust)
    mesh_construction.TriangleMesh(scene, mesh.vertices, mesh.faces)
    return scene.run(rays.origins, rays.directions)


def compare(mesh: treelet.Mesh, rays: Rays, hits: treelet.Hits, embree_faces: np.ndarray) -> Agreement:
    """Judges each ray on which the faces differ, and a few on which they agree."""
    neighbours = Neighbours(mesh)
    differing = np.flatnonzero(hits.face != embree_faces)
    agreeing = np.flatnonzero(hits.face == embree_faces)[:: max(1, len(hits.face) // _AGREEING_CHECKS)]
    judged = np.concatenate([differing, agreeing])
    fully_checked = set(judged[:: max(1, len(judged) // _FULL_CHECKS)].tolist())
    agreement = Agreement()
    for ray in judged.tolist():
        origin, direction = rays.origins[ray], rays.directions[ray]
        ours, theirs = int(hits.face[ray]), int(embree_faces[ray])
        candidates = neighbours.around({ours, theirs} - {-1})
        if ray in fully_checked:
            candidates |= neighbours.along(origin, direction)
        exact = exact_hits(origin, direction, neighbours.corners, candidates)
        what = fault(hits.t[ray], ours, exact)
        if what is not None:
            agreement.faults.append(f"ray {ray}, {origin} {direction}: {what}")
        elif ours != theirs:
            agreement.counts[kind_of_difference(ours, theirs, exact)] += 1
    return agreement


class Neighbours:
    """Finds the faces that a ray might have hit instead."""

    def __init__(self, mesh: treelet.Mesh) -> None:
        self.corners = mesh.vertices[mesh.faces]
        _, points = np.unique(_as_keys(self.corners.reshape(-1, 3)), return_inverse=True)
        self._points = points.reshape(-1, 3)
        self._faces = (np.argsort(points, kind="stable") // 3).astype(np.int64)
        self._ends = np.cumsum(np.bincount(points.ravel()))

    def around(self, faces: set[int]) -> set[int]:
        """These faces and all that touch a vertex of theirs."""
        found = set(faces)
        for point in {int(point) for face in faces for point in self._points[face]}:
            begin = self._ends[point - 1] if point > 0 else 0
            found.update(self._faces[begin : self._ends[point]].tolist())
        return found

    def along(self, origin: np.ndarray, direction: np.ndarray) -> set[int]:
        """All faces whose box the ray's line may meet."""
        lower, upper = self.corners.min(axis=1) - origin, self.corners.max(axis=1) - origin
        slack = 1e-6 * max(np.nanmax(np.abs(lower)), np.nanmax(np.abs(upper)))
        inverse = np.where(
            direction == 0, np.inf, 1 / np.where(direction == 0, 1, direction.astype(np.float64))
        )
        with np.errstate(invalid="ignore"):
            planes = np.stack([(lower - slack) * inverse, (upper + slack) * inverse])
        enter, leave = planes.min(axis=0).max(axis=1), planes.max(axis=0).min(axis=1)
        return set(np.flatnonzero(~(enter > leave)).tolist())


def _as_keys(points: np.ndarray) -> np.ndarray:
    """One sortable value a point, the same for equal points."""
    return np.ascontiguousarray(points + np.float32(0)).view("V12").ravel()
