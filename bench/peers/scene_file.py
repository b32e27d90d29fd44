"""Meshes and rays in a plain file, so that all who race trace the same ones.

Little-endian, nothing aligned:

    "treelet peers 1\\n"
    uint64     vertices V, faces F, ray sets
    float32    vertices[V][3]
    uint32     faces[F][3]
    for each set of rays:
      char[24]   kind, zeros behind it
      uint64     1 where the first hit found is enough, else 0; number of rays N
      float32    origins[N][3], directions[N][3], t_max[N]
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

MAGIC = b"treelet peers 1\n"
KIND_BYTES = 24


@dataclass(frozen=True, eq=False)
class RaySet:
    """Rays of one kind."""

    kind: str
    any_hit: bool
    origins: np.ndarray  # (n, 3) float32
    directions: np.ndarray  # (n, 3) float32
    t_max: np.ndarray  # (n,) float32

    def __len__(self) -> int:
        return len(self.origins)


@dataclass(frozen=True, eq=False)
class SceneFile:
    """A mesh and rays through it."""

    vertices: np.ndarray  # (v, 3) float32
    faces: np.ndarray  # (f, 3) uint32
    ray_sets: list[RaySet]


def write_scene_file(path: str | Path, scene: SceneFile) -> None:
    """Write `scene`, its arrays converted to the file's types."""
    with Path(path).open("wb") as file:
        file.write(MAGIC)
        file.write(struct.pack("<3Q", len(scene.vertices), len(scene.faces), len(scene.ray_sets)))
        _write_array(file, scene.vertices, "<f4")
        _write_array(file, scene.faces, "<u4")
        for rays in scene.ray_sets:
            file.write(struct.pack(f"<{KIND_BYTES}s2Q", _kind_bytes(rays.kind), rays.any_hit, len(rays)))
            for array in (rays.origins, rays.directions, rays.t_max):
                _write_array(file, array, "<f4")


def read_scene_file(path: str | Path) -> SceneFile:
    """Read what `write_scene_file` wrote. Raises ValueError for another file, or one that ends early."""
    with Path(path).open("rb") as file:
        if file.read(len(MAGIC)) != MAGIC:
            raise ValueError(f"{path} is no scene file of the peers")
        vertices, faces, ray_sets = _read_struct(file, "<3Q")
        return SceneFile(
            _read_array(file, "<f4", vertices, 3),
            _read_array(file, "<u4", faces, 3),
            [_read_ray_set(file) for _ in range(ray_sets)],
        )


def _read_ray_set(file: BinaryIO) -> RaySet:
    kind, any_hit, rays = _read_struct(file, f"<{KIND_BYTES}s2Q")
    origins, directions = _read_array(file, "<f4", rays, 3), _read_array(file, "<f4", rays, 3)
    return RaySet(
        kind.rstrip(b"\0").decode(), bool(any_hit), origins, directions, _read_array(file, "<f4", rays)
    )


def _kind_bytes(kind: str) -> bytes:
    if len(kind.encode()) > KIND_BYTES:
        raise ValueError(f"the ray kind {kind!r} is longer than {KIND_BYTES} bytes")
    return kind.encode()


def _write_array(file: BinaryIO, array: np.ndarray, dtype: str) -> None:
    file.write(np.ascontiguousarray(array, dtype=dtype).tobytes())


def _read_struct(file: BinaryIO, layout: str) -> tuple:
    return struct.unpack(layout, _read_bytes(file, struct.calcsize(layout)))


def _read_array(file: BinaryIO, dtype: str, *shape: int) -> np.ndarray:
    count = int(np.prod(shape))
    data = _read_bytes(file, count * np.dtype(dtype).itemsize)
    return np.frombuffer(data, dtype).reshape(shape)


def _read_bytes(file: BinaryIO, count: int) -> bytes:
    data = file.read(count)
    if len(data) < count:
        raise ValueError(f"{file.name} ends too early")
    return data
