"""What a mesh is like: counts, bounds, and the flaws that real exports have."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

Array = np.ndarray


@dataclass(frozen=True)
class MeshFacts:
    """Counts over one mesh. For edges and duplicates, vertices at equal positions are one."""

    name: str
    faces: int
    vertices: int
    distinct_positions: int
    low: list[float]  # corner of the bounds of all finite vertices
    high: list[float]
    non_finite_faces: int  # with a NaN or infinite coordinate
    degenerate_faces: int  # with two corners at one position
    zero_area_faces: int  # other faces without area
    duplicate_faces: int  # over the corners of an earlier face, in whatever order
    open_edges: int  # of one face only
    shared_edges: int  # of exactly two faces
    crowded_edges: int  # of three faces or more

    @property
    def is_closed(self) -> bool:
        """Whether every edge has two faces."""
        return self.shared_edges > 0 and self.open_edges == 0 and self.crowded_edges == 0

    def as_dict(self) -> dict[str, Any]:
        """Plain JSON-able values."""
        return asdict(self) | {"closed": self.is_closed}


def gather_facts(mesh: Any) -> MeshFacts:
    """Look at every face and edge of `mesh` (vertices (V, 3), faces (F, 3)), rounded to float32."""
    with np.errstate(over="ignore"):  # what becomes infinite is not finite for a tree either
        vertices, faces = np.asarray(mesh.vertices, dtype=np.float32), np.asarray(mesh.faces)
    is_finite = np.isfinite(vertices).all(axis=1)
    low, high = _bounds(vertices[is_finite])
    welded, positions = weld(vertices)
    corners = welded[faces].reshape(-1, 3)
    finite_faces = is_finite[faces].all(axis=1)
    two_alike = (corners == np.roll(corners, 1, axis=1)).any(axis=1)
    sound = finite_faces & ~two_alike
    open_edges, shared_edges, crowded_edges = _edge_counts(corners[sound])
    return MeshFacts(
        name=mesh.name,
        faces=len(faces),
        vertices=len(vertices),
        distinct_positions=positions,
        low=low,
        high=high,
        non_finite_faces=int((~finite_faces).sum()),
        degenerate_faces=int((finite_faces & two_alike).sum()),
        zero_area_faces=int((_double_areas(vertices, faces[sound]) == 0.0).sum()),
        duplicate_faces=_duplicate_count(corners[finite_faces]),
        open_edges=open_edges,
        shared_edges=shared_edges,
        crowded_edges=crowded_edges,
    )


def weld(vertices: Array) -> tuple[Array, int]:
    """One id for each distinct position, (V,) int64, and how many there are."""
    if len(vertices) == 0:
        return np.zeros(0, dtype=np.int64), 0
    order = np.lexsort(vertices.T)
    ordered = vertices[order]
    begins = np.concatenate([[True], (ordered[1:] != ordered[:-1]).any(axis=1)])
    ids = np.empty(len(vertices), dtype=np.int64)
    ids[order] = np.cumsum(begins) - 1
    return ids, int(begins.sum())


def _bounds(vertices: Array) -> tuple[list[float], list[float]]:
    if len(vertices) == 0:
        return [0.0] * 3, [0.0] * 3
    return [float(value) for value in vertices.min(axis=0)], [float(value) for value in vertices.max(axis=0)]


def _double_areas(vertices: Array, faces: Array) -> Array:
    corners = vertices.astype(np.float64)[faces]
    return np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=-1)


def _duplicate_count(corners: Array) -> int:
    return len(corners) - len(_run_lengths(np.sort(corners, axis=1)))


def _edge_counts(corners: Array) -> tuple[int, int, int]:
    """How many edges have one, two, and more faces."""
    edges = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    faces_of_edge = _run_lengths(np.sort(edges, axis=1))
    return tuple(
        int(count)
        for count in ((faces_of_edge == 1).sum(), (faces_of_edge == 2).sum(), (faces_of_edge > 2).sum())
    )


def _run_lengths(rows: Array) -> Array:
    """How often each distinct row of (n, k) integers occurs."""
    if len(rows) == 0:
        return np.zeros(0, dtype=np.int64)
    ordered = rows[np.lexsort(rows.T)]
    begins = np.flatnonzero(np.concatenate([[True], (ordered[1:] != ordered[:-1]).any(axis=1)]))
    return np.diff(np.append(begins, len(ordered)))
