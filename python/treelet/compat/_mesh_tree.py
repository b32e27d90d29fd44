"""The tree of a mesh object, built when first asked for and again when the mesh has changed."""

from __future__ import annotations

import weakref
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from ..bvh import Bvh, build

Float64Array = np.ndarray[tuple[int, ...], np.dtype[np.float64]]
IndexArray = np.ndarray[tuple[int, ...], np.dtype[np.int64]]


class MeshLike(Protocol):
    """Any object with the arrays of a mesh; they may change between queries."""

    @property
    def vertices(self) -> ArrayLike:
        """(V, 3) float."""

    @property
    def faces(self) -> ArrayLike:
        """(F, 3) integer."""


class MeshTree(NamedTuple):
    """A tree, and the mesh that it was built of, as it was then."""

    bvh: Bvh
    vertices: Float64Array
    faces: IndexArray
    state: int | None
    """The mesh's own hash of its content, where it keeps one."""

    def corners(self, face: IndexArray) -> Float64Array:
        """(n, 3, 3) float64: the corners of each of these faces."""
        return self.vertices[self.faces[face]]


class KeptTree:
    """The tree that an object asked for last, for meshes that trees cannot be shared of."""

    def __init__(self) -> None:
        self._tree: MeshTree | None = None

    def of(self, mesh: MeshLike) -> MeshTree:
        """The tree of the mesh as it is now."""
        self._tree = tree = tree_of(mesh, self._tree)
        return tree

    def __reduce__(self) -> tuple[type[KeptTree], tuple[()]]:
        return KeptTree, ()  # empty: the copy builds its own when asked


_trees: dict[int, tuple[weakref.ref[Any], MeshTree]] = {}


def tree_of(mesh: MeshLike, known: MeshTree | None = None) -> MeshTree:
    """The tree of the mesh as it is now: `known` if it is that, or one that all who ask share.

    A shared tree goes with its mesh. Changes are seen by the hash that meshes of trimesh keep, and else by
    comparing the arrays with copies.
    """
    reference, shared = _trees.get(id(mesh), (None, None))
    if reference is not None and reference() is mesh:
        known = shared
    if known is not None and _is_current(known, mesh):
        return known
    tree = _build(mesh)
    _keep(mesh, tree)
    return tree


def _build(mesh: MeshLike) -> MeshTree:
    state = _content_hash(mesh)
    vertices = np.array(mesh.vertices, dtype=np.float64, subok=False)
    faces = np.array(mesh.faces, dtype=np.int64, subok=False)
    return MeshTree(build(vertices, faces), vertices.reshape(-1, 3), faces.reshape(-1, 3), state)


def _is_current(tree: MeshTree, mesh: MeshLike) -> bool:
    state = _content_hash(mesh)
    if state is not None:
        return state == tree.state
    # A NaN is not equal to itself, but a mesh that has one must not be built anew each time.
    vertices = np.asarray(mesh.vertices, dtype=np.float64).reshape(-1, 3)
    return np.array_equal(tree.vertices, vertices, equal_nan=True) and np.array_equal(
        tree.faces, np.asarray(mesh.faces).reshape(-1, 3)
    )


def _content_hash(mesh: MeshLike) -> int | None:
    # Other classes may hash by identity or by name.
    is_tracked = any(base.__module__.partition(".")[0] == "trimesh" for base in type(mesh).__mro__)
    return hash(mesh) if is_tracked else None


def _keep(mesh: MeshLike, tree: MeshTree) -> None:
    # By id: a mesh that hashes by content would not be found again after a change.
    key = id(mesh)

    def forget(dead: weakref.ref[Any]) -> None:
        kept = _trees.get(key)
        if kept is not None and kept[0] is dead:
            del _trees[key]

    try:
        _trees[key] = (weakref.ref(mesh, forget), tree)
    except TypeError:
        return  # such as a SimpleNamespace: who asks again must bring the tree along
