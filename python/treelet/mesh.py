"""Triangle meshes and the files they come from."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._inputs import as_vertices
from ._offset import ORIGIN
from .ply import read_ply
from .polygon_text import read_obj, read_off
from .stl import read_stl
from .view import View

_KNOWN_EXTENSIONS = (".ply", ".obj", ".stl", ".off", ".glb", ".gltf", ".npz")

Arrays = tuple[NDArray[Any], NDArray[Any]]


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles with a name and views that show them well.

    vertices: (V, 3) float32 or float64, kept as given, so that an offset can be subtracted before rounding;
    other numbers become float64. faces: (F, 3) int32, each a vertex index; other integers are converted.
    Raises ValueError for another shape or an index outside [0, V), and names the first.
    """

    vertices: NDArray[np.float32] | NDArray[np.float64]
    faces: NDArray[np.int32]
    name: str = ""
    views: tuple[View, ...] = ()

    def __post_init__(self) -> None:
        vertices, faces = np.asarray(self.vertices), np.asarray(self.faces)
        for label, array in (("vertices", vertices), ("faces", faces)):
            if array.ndim != 2 or array.shape[1] != 3:
                raise ValueError(f"{label} must have shape (n, 3), not {array.shape}")
        _check_indices(faces, len(vertices))
        precision = np.float32 if vertices.dtype == np.float32 else np.float64
        object.__setattr__(self, "vertices", np.ascontiguousarray(vertices, dtype=precision))
        object.__setattr__(self, "faces", np.ascontiguousarray(faces, dtype=np.int32))
        object.__setattr__(self, "views", tuple(self.views))

    @property
    def bounds(self) -> NDArray[np.float32] | NDArray[np.float64]:
        """The lowest and highest coordinates, (2, 3) as precise as the vertices; zeros without vertices."""
        if len(self.vertices) == 0:
            return np.zeros((2, 3), dtype=self.vertices.dtype)
        return np.stack([self.vertices.min(axis=0), self.vertices.max(axis=0)])

    def rounded(self) -> Mesh:
        """This mesh, or one with its vertices rounded to float32 where they are.

        Issues a `treelet.PrecisionWarning` where that moves one visibly: `treelet.build`, given the mesh
        itself, would subtract an offset first.
        """
        vertices = as_vertices(self.vertices, ORIGIN).array
        return self if self.vertices.dtype == np.float32 else replace(self, vertices=vertices)

    def __repr__(self) -> str:
        sizes = f"{len(self.faces):,} triangles, {len(self.vertices):,} vertices, {len(self.views)} views"
        return f"Mesh({self.name!r}, {sizes})"


def load_mesh(path: str | os.PathLike[str], frame: int = 0) -> Mesh:
    """Reads a mesh file: .ply, .obj, .stl, .off, .glb, .gltf or .npz.

    Nothing is cleaned: triangles keep the order of the file and vertices their positions, float32 where that
    holds all of them exactly, else float64; nothing is merged or left out. Polygons become fans of triangles
    in place; the parts of a glTF scene are joined, each under its transform, in the order in which trimesh
    walks the scene. An .npz holds `faces` (F, 3) and `vertices` (V, 3), or (K, V, 3) for an animation, of
    which `frame` is taken.

    Raises FileNotFoundError; IsADirectoryError; ValueError for an extension nobody knows, a damaged file,
    one without triangles or without that frame; ImportError for .glb and .gltf where trimesh is not installed
    (`pip install treelet[mesh]`).
    """
    path = Path(path)
    extension = path.suffix.lower()
    if extension == ".treelet":
        raise ValueError(f"{path}: is a saved tree, not a mesh: treelet.load reads it")
    if extension not in _KNOWN_EXTENSIONS:
        raise ValueError(
            f"{path}: unknown mesh extension {extension!r}; known are {', '.join(_KNOWN_EXTENSIONS)}"
        )
    if path.is_dir():
        raise IsADirectoryError(f"{path}: is a directory, not a mesh file")
    if not path.is_file():
        raise FileNotFoundError(f"{path}: there is no such mesh file")
    read = _reader(extension)
    try:
        vertices, faces = read(path, frame)
        mesh = Mesh(_as_precise_as_needed(np.asarray(vertices)), faces, path.stem)
    except MemoryError:
        raise
    except Exception as error:  # a damaged file makes the readers fail in every way there is
        raise ValueError(f"{path}: cannot be read as {extension}: {_reason(error)}") from error
    if len(mesh.faces) == 0:
        raise ValueError(f"{path}: holds no triangles")
    return mesh


def with_views(mesh: Mesh, views: tuple[View, ...], name: str | None = None) -> Mesh:
    """The same triangles with other views and, where given, another name."""
    return replace(mesh, views=views, name=mesh.name if name is None else name)


def _reason(error: Exception) -> str:
    return str(error).strip().rstrip(".") or type(error).__name__


def _check_indices(faces: NDArray[Any], vertex_count: int) -> None:
    if not np.issubdtype(faces.dtype, np.integer):
        raise ValueError(f"faces must be integers, not {faces.dtype}")
    if faces.size == 0 or (faces.min() >= 0 and faces.max() < vertex_count):
        return
    face, corner = np.argwhere((faces < 0) | (faces >= vertex_count))[0]
    raise ValueError(f"face {face} names vertex {faces[face, corner]}, but there are {vertex_count} vertices")


def _as_precise_as_needed(vertices: NDArray[Any]) -> NDArray[Any]:
    """float32 where that changes nothing."""
    with np.errstate(over="ignore", invalid="ignore"):
        rounded = vertices.astype(np.float32, copy=False)
    is_number = vertices.dtype.kind in "fiu"
    return rounded if not is_number or np.array_equal(rounded, vertices, equal_nan=True) else vertices


def _reader(extension: str) -> Callable[[Path, int], Arrays]:
    if extension == ".npz":
        return _read_npz
    if extension in (".glb", ".gltf"):
        try:
            import trimesh
        except ImportError as error:
            raise ImportError(
                f"reading {extension} files needs trimesh: pip install treelet[mesh]"
            ) from error
        return _without_frames(lambda path: _read_with_trimesh(trimesh, path))
    if extension in (".obj", ".off"):
        parse = read_obj if extension == ".obj" else read_off
        return _without_frames(lambda path: parse(path.read_text(encoding="utf-8-sig", errors="replace")))
    read = read_ply if extension == ".ply" else read_stl
    return _without_frames(lambda path: read(path.read_bytes()))


def _without_frames(read: Callable[[Path], Arrays]) -> Callable[[Path, int], Arrays]:
    def reader(path: Path, frame: int) -> Arrays:
        _check_single_frame(frame)
        return read(path)

    return reader


def _check_single_frame(frame: int) -> None:
    if frame != 0:
        raise ValueError(f"it is no animation, so there is no frame {frame}")


def _read_npz(path: Path, frame: int) -> Arrays:
    with np.load(path, allow_pickle=False) as arrays:
        missing = [key for key in ("vertices", "faces") if key not in arrays]
        if missing:
            raise ValueError(f"it has no array {missing[0]!r}")
        vertices, faces = arrays["vertices"], arrays["faces"]
    if vertices.ndim != 3:
        _check_single_frame(frame)
        return vertices, faces
    if not -len(vertices) <= frame < len(vertices):
        raise ValueError(f"it has {len(vertices)} frames, so there is no frame {frame}")
    return vertices[frame], faces


def _read_with_trimesh(trimesh: Any, path: Path) -> Arrays:
    # fix_texture would split vertices and renumber faces.
    options = {"process": False, "validate": False, "skip_materials": True, "fix_texture": False}
    scene = trimesh.load_scene(str(path), **options)
    parts = [_placed_part(scene, node) for node in scene.graph.nodes_geometry]
    return _join([part for part in parts if part is not None])


def _placed_part(scene: Any, node: str) -> Arrays | None:
    """One geometry of a scene in world coordinates, or None for points and curves."""
    transform, geometry_name = scene.graph[node]
    geometry = scene.geometry[geometry_name]
    if not hasattr(geometry, "faces"):
        return None
    vertices, faces = np.asarray(geometry.vertices), np.asarray(geometry.faces)
    if not np.array_equal(transform, np.eye(4)):
        vertices = vertices @ transform[:3, :3].T + transform[:3, 3]
    if np.linalg.det(transform[:3, :3]) < 0.0:
        faces = faces[:, [0, 2, 1]]  # a mirror turns the winding round
    return vertices, faces


def _join(parts: list[Arrays]) -> Arrays:
    if not parts:
        return np.zeros((0, 3), dtype=np.float32), np.zeros((0, 3), dtype=np.int32)
    if len(parts) == 1:
        return parts[0]
    starts = np.cumsum([0] + [len(vertices) for vertices, _ in parts])
    faces = [part_faces + start for (_, part_faces), start in zip(parts, starts, strict=False)]
    return np.concatenate([vertices for vertices, _ in parts]), np.concatenate(faces)
