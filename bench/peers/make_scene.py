"""Scene files out of treelet's scenes and ray kinds."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scene_file import RaySet, SceneFile, write_scene_file

import treelet
from treelet.bench.measure import RAY_KINDS, Plan, make_ray_sets
from treelet.render.rays import Rays
from treelet.view import automatic_view

TILE = 4  # pixels: sixteen primary rays that follow each other fill a packet with neighbours


def make_scene_file(path: str | Path, mesh: treelet.Mesh, width: int, height: int) -> SceneFile:
    """Write the mesh and its rays of every kind, one a pixel of its first view, and return both."""
    mesh = mesh.rounded()
    view = mesh.views[0] if mesh.views else automatic_view(mesh.vertices, mesh.faces)
    bvh = treelet.build(mesh.vertices, mesh.faces)
    ray_sets = make_ray_sets(bvh, mesh, view, Plan((), RAY_KINDS, width=width, height=height))
    scene = SceneFile(mesh.vertices, mesh.faces, [_ray_set(rays, width, height) for rays in ray_sets])
    write_scene_file(path, scene)
    return scene


def order_by_tiles(width: int, height: int, tile: int = TILE) -> np.ndarray:
    """The pixels, numbered row by row, in the order of square tiles and row by row inside each."""
    y, x = np.divmod(np.arange(width * height), width)
    return np.lexsort((x, y, x // tile, y // tile))


def _ray_set(rays: Rays, width: int, height: int) -> RaySet:
    order = order_by_tiles(width, height) if rays.kind == "primary" else slice(None)
    t_max = np.full(len(rays), rays.t_max, dtype=np.float32)
    return RaySet(rays.kind, rays.any_hit, rays.origins[order], rays.directions[order], t_max)
