"""Triangle meshes and the files they come from."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .polygon_text import read_obj, read_off, triangulate_fans
from .view import View

_KNOWN_EXTENSIONS = (".ply", ".obj", ".stl", ".off", ".glb", ".gltf", ".npz")

Arrays = tuple[NDArray[Any], NDArray[Any]]


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles with a name and views that show them well.

    vertices: (V, 3) float32; faces: (F, 3) int32, each a vertex index. Other dtypes are converted; float64 is
    rounded to the nearest float32. Raises ValueError for another shape or an index outside [0, V), and names
    the first.
    """

    vertices: NDArray[np.float32]
    faces: NDArray[np.int32]
    name: str = ""
    views: tuple[View, ...] = ()

    def __post_init__(self) -> None:
        vertices, faces = np.asarray(self.vertices), np.asarray(self.faces)
        for label, array in (("vertices", vertices), ("faces", faces)):
            if array.ndim != 2 or array.shape[1] != 3:
                raise ValueError(f"{label} must have shape (n, 3), not {array.shape}")
        _check_indices(faces, len(vertices))
        with np.errstate(over="ignore"):  # beyond float32 is infinite, and build() counts such triangles
            object.__setattr__(self, "vertices", np.ascontiguousarray(vertices, dtype=np.float32))
        object.__setattr__(self, "faces", np.ascontiguousarray(faces, dtype=np.int32))
        object.__setattr__(self, "views", tuple(self.views))

    @property
    def bounds(self) -> NDArray[np.float32]:
        """The lowest and highest coordinates, (2, 3) float32; zeros without vertices."""
        if len(self.vertices) == 0:
            return np.zeros((2, 3), dtype=np.float32)
        return np.stack([self.vertices.min(axis=0), self.vertices.max(axis=0)])

    def __repr__(self) -> str:
        sizes = f"{len(self.faces):,} triangles, {len(self.vertices):,} vertices, {len(self.views)} views"
        return f"Mesh({self.name!r}, {sizes})"


def load_mesh(path: str | os.PathLike[str], frame: int = 0) -> Mesh:
    """Reads a mesh file: .ply, .obj, .stl, .off, .glb, .gltf or .npz.

    Nothing is cleaned: triangles keep the order of the file and vertices their positions (rounded to
    float32); nothing is merged or left out. Polygons become fans of triangles in place; the parts of a glTF
    scene are joined, each under its transform, in the order in which trimesh walks the scene. An .npz holds
    `faces` (F, 3) and `vertices` (V, 3), or (K, V, 3) for an animation, of which `frame` is taken.

    Raises FileNotFoundError; ValueError for an extension nobody knows, a damaged file or one without
    triangles; ImportError for .ply, .stl, .glb and .gltf where trimesh is not installed (`pip install
    treelet[mesh]`).
    """
    path = Path(path)
    extension = path.suffix.lower()
    if extension not in _KNOWN_EXTENSIONS:
        raise ValueError(
            f"{path}: unknown mesh extension {extension!r}; known are {', '.join(_KNOWN_EXTENSIONS)}"
        )
    if not path.is_file():
        raise FileNotFoundError(f"{path}: there is no such mesh file")
    read = _reader(extension)
    try:
        mesh = Mesh(*read(path, frame), path.stem)
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


def _reader(extension: str) -> Callable[[Path, int], Arrays]:
    if extension == ".npz":
        return _read_npz
    if extension in (".obj", ".off"):
        parse = read_obj if extension == ".obj" else read_off
        return lambda path, frame: parse(path.read_text(encoding="utf-8", errors="replace"))
    try:
        import trimesh
    except ImportError as error:
        raise ImportError(f"reading {extension} files needs trimesh: pip install treelet[mesh]") from error
    return lambda path, frame: _read_with_trimesh(trimesh, path)


def _read_npz(path: Path, frame: int) -> Arrays:
    with np.load(path, allow_pickle=False) as arrays:
        missing = [key for key in ("vertices", "faces") if key not in arrays]
        if missing:
            raise ValueError(f"it has no array {missing[0]!r}")
        vertices, faces = arrays["vertices"], arrays["faces"]
    if vertices.ndim != 3:
        return vertices, faces
    if not -len(vertices) <= frame < len(vertices):
        raise ValueError(f"it has {len(vertices)} frames, so there is no frame {frame}")
    return vertices[frame], faces


def _read_with_trimesh(trimesh: Any, path: Path) -> Arrays:
    if path.suffix.lower() == ".stl":
        _check_stl_size(path)
    # fix_texture would split vertices and renumber faces.
    options = {"process": False, "validate": False, "skip_materials": True, "fix_texture": False}
    scene = trimesh.load_scene(str(path), **options)
    parts = [_placed_part(scene, node) for node in scene.graph.nodes_geometry]
    return _join([part for part in parts if part is not None])


def _check_stl_size(path: Path) -> None:
    """A binary STL of the wrong size would be taken for text, and fail with words about its encoding."""
    with path.open("rb") as file:
        header = file.read(84)
    if len(header) < 84 or header.lstrip().startswith(b"solid"):
        return
    count, size = int.from_bytes(header[80:], "little"), path.stat().st_size
    if size != 84 + 50 * count:
        raise ValueError(
            f"{count} triangles are announced, which take {84 + 50 * count} bytes, but it has {size}"
        )


def _placed_part(scene: Any, node: str) -> Arrays | None:
    """One geometry of a scene in world coordinates, or None for points and curves."""
    transform, geometry_name = scene.graph[node]
    geometry = scene.geometry[geometry_name]
    if not hasattr(geometry, "faces"):
        return None
    vertices, faces = np.asarray(geometry.vertices), np.asarray(geometry.faces)
    polygons = _ply_polygons(geometry.metadata.get("_ply_raw"))
    if polygons is not None:
        faces = triangulate_fans(*polygons)
    if not np.array_equal(transform, np.eye(4)):
        vertices = vertices @ transform[:3, :3].T + transform[:3, 3]
    if np.linalg.det(transform[:3, :3]) < 0.0:
        faces = faces[:, [0, 2, 1]]  # a mirror turns the winding round
    return vertices, faces


def _ply_polygons(raw: Any) -> Arrays | None:
    """The (corners, counts) of a PLY's polygons, which trimesh would sort by corner count."""
    if not raw or "face" not in raw or "data" not in raw["face"]:
        return None
    data = raw["face"]["data"]
    names = data.keys() if isinstance(data, dict) else (data.dtype.names or ())
    name = next((known for known in ("vertex_indices", "vertex_index") if known in names), None)
    if name is None:
        return None
    lists = data[name] if isinstance(data, dict) else data[name]["f1"]
    if lists.dtype != object and lists.ndim == 2 and lists.shape[1] == 3:
        return None
    counts = np.array([len(corners) for corners in lists], dtype=np.int64)
    return np.concatenate(list(lists)).astype(np.int64), counts


def _join(parts: list[Arrays]) -> Arrays:
    if not parts:
        return np.zeros((0, 3), dtype=np.float32), np.zeros((0, 3), dtype=np.int32)
    if len(parts) == 1:
        return parts[0]
    starts = np.cumsum([0] + [len(vertices) for vertices, _ in parts])
    faces = [part_faces + start for (_, part_faces), start in zip(parts, starts, strict=False)]
    return np.concatenate([vertices for vertices, _ in parts]), np.concatenate(faces)
