"""What answers the queries of python_queries.py: this library and others, arrays in and arrays out.

A contender is a function of vertices and faces that gives a function for each query it knows. Those of rays
take origins and directions and give the number of hits of each ray, listed or counted; those of points give
distances, signed ones negative inside.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

import numpy as np

import treelet

Ask = Callable[..., np.ndarray]
Make = Callable[[np.ndarray, np.ndarray], dict[str, Ask]]


def ask_treelet(vertices: np.ndarray, faces: np.ndarray) -> dict[str, Ask]:
    """The default tree."""
    bvh = treelet.build(vertices, faces)
    return {
        "all_hits": lambda *rays: np.diff(bvh.intersect_all(*rays).offsets),
        "counts": bvh.count_hits,
        "closest_point": lambda points: bvh.closest_point(points).distance,
        "signed_distance": bvh.signed_distance,
    }


def ask_open3d(vertices: np.ndarray, faces: np.ndarray) -> dict[str, Ask]:
    """RaycastingScene: Embree, robust, all threads."""
    o3d = import_module("open3d")
    scene = o3d.t.geometry.RaycastingScene()
    tensor = o3d.core.Tensor
    scene.add_triangles(tensor(vertices), tensor(faces.astype(np.uint32)))

    def joined(origins: np.ndarray, directions: np.ndarray):
        return tensor(np.concatenate([origins, directions], axis=1))

    def closest(points: np.ndarray) -> np.ndarray:
        found = scene.compute_closest_points(tensor(points))["points"].numpy()
        return np.linalg.norm(found - points, axis=1)

    return {
        "all_hits": lambda *rays: np.diff(
            scene.list_intersections(joined(*rays))["ray_splits"].numpy().astype(np.int64)
        ),
        "counts": lambda *rays: scene.count_intersections(joined(*rays)).numpy(),
        "closest_point": closest,
        "signed_distance": lambda points: scene.compute_signed_distance(tensor(points)).numpy(),
    }


def ask_trimesh(vertices: np.ndarray, faces: np.ndarray) -> dict[str, Ask]:
    """Over Embree (embreex) where that is installed; points need rtree and scipy."""
    trimesh = import_module("trimesh")
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    asks: dict[str, Ask] = {
        "all_hits": lambda *rays: np.bincount(mesh.ray.intersects_location(*rays)[1], minlength=len(rays[0]))
    }
    try:
        import_module("rtree")
        import_module("scipy")
    except ImportError:
        return asks
    query = trimesh.proximity.ProximityQuery(mesh)
    asks["closest_point"] = lambda points: query.on_surface(points)[1]
    asks["signed_distance"] = lambda points: -query.signed_distance(points)
    return asks


def ask_libigl(vertices: np.ndarray, faces: np.ndarray) -> dict[str, Ask]:
    """A tree for nearest points; signed distances by pseudonormals, whose tree is built anew by each call."""
    igl = import_module("igl")
    corners, indices = vertices.astype(np.float64), faces.astype(np.int64)
    tree = igl.AABB()
    tree.init(corners, indices)
    return {
        "closest_point": lambda points: np.sqrt(
            tree.squared_distance(corners, indices, points.astype(np.float64))[0]
        ),
        "signed_distance": lambda points: igl.signed_distance(points.astype(np.float64), corners, indices)[0],
    }


CONTENDERS: dict[str, Make] = {
    "treelet": ask_treelet,
    "Open3D": ask_open3d,
    "trimesh": ask_trimesh,
    "libigl": ask_libigl,
}

SLOWER = {
    ("trimesh", "closest_point"): 100,
    ("trimesh", "signed_distance"): 100,
    ("libigl", "closest_point"): 4,
    ("libigl", "signed_distance"): 4,
}
"""Who is asked for every so many-th answer only, that a run may end."""
