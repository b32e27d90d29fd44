"""Open3D's `RaycastingScene` on numpy arrays, answered by treelet.

from treelet.compat.open3d import RaycastingScene  # for open3d.t.geometry.RaycastingScene

What differs is in docs/compat.md. Open3D need not be installed.
"""

from __future__ import annotations

from typing import Any, NamedTuple, overload

import numpy as np
from numpy.typing import NDArray

from ..bvh import Bvh, build
from ..mesh import Mesh
from ._arrays import as_array
from ._overloads import choose_overload
from ._pinhole import rays_of_matrices, rays_of_view

__all__ = ["RaycastingScene"]

Answers = dict[str, NDArray[Any]]


class RaycastingScene:
    """Rays and points against triangle meshes, as `open3d.t.geometry.RaycastingScene`.

    Arguments are arrays, or tensors with a `numpy()` method, of any real type and any leading shape (...);
    answers are numpy arrays. A ray is (ox, oy, oz, dx, dy, dz), and t counts in lengths of its direction. The
    tree is built by the first query after `add_triangles`.

    Args:
        nthreads: for Open3D's programs, here and in all methods without effect: `treelet.set_thread_count`
            sets the number, of which no answer depends.
        device: the CPU, whatever it is called; ValueError for another.
        recipe: of `treelet.build`.
    """

    INVALID_ID = 2**32 - 1
    """Geometry and primitive of what hits nothing."""

    def __init__(self, nthreads: int = 0, device: object = "CPU:0", *, recipe: str = "balanced") -> None:
        if not str(device).upper().startswith("CPU"):
            raise ValueError(f"device must be the CPU, not {device}: see treelet.DeviceBvh for CUDA")
        self._recipe = recipe
        self._meshes = _JoinedMeshes()
        self._built: _BuiltScene | None = None

    @overload
    def add_triangles(self, vertex_positions: object, triangle_indices: object) -> int: ...

    @overload
    def add_triangles(self, mesh: object) -> int: ...

    def add_triangles(self, *arguments: Any, **named: Any) -> int:
        """Add a mesh, which is copied.

        Args:
            vertex_positions: (V, 3) float.
            triangle_indices: (F, 3) integers in [0, V).
            mesh: instead of both, a mesh of Open3D (of either kind), of trimesh or of treelet.

        Returns:
            The geometry's ID: 0 for the first, and so on.

        Raises:
            ValueError: for another shape, and for indices that are no integers or out of range.
            TypeError: for what is no mesh.
        """
        read = choose_overload("add_triangles", (_read_mesh, _read_arrays), arguments, named)
        geometry = self._meshes.add(read(*arguments, **named))
        self._built = None
        return geometry

    def cast_rays(self, rays: object, nthreads: int = 0) -> Answers:
        """Find the first hit of each ray.

        Args:
            rays: (..., 6) float.
            nthreads: without effect.

        Returns:
            t_hit (...) float32, inf for a miss; geometry_ids and primitive_ids (...) uint32, INVALID_ID for a
            miss; primitive_uvs (..., 2) float32, of the point (1-u-v) P0 + u P1 + v P2; primitive_normals
            (..., 3) float32 of length 1. The last two are zero for a miss.
        """
        scene = self._scene()
        t, face, u, v = scene.bvh.intersect(*_split_rays(rays))
        return {
            "t_hit": t,
            **scene.identify(face),
            "primitive_uvs": np.stack([u, v], axis=-1),
            "primitive_normals": scene.normals(face),
        }

    def test_occlusions(
        self, rays: object, tnear: float = 0.0, tfar: float = np.inf, nthreads: int = 0
    ) -> NDArray[np.bool_]:
        """Whether each ray (..., 6) hits anything with t in [tnear, tfar], bool (...)."""
        return self._scene().bvh.occluded(*_split_rays(rays), tnear, tfar)

    def count_intersections(self, rays: object, nthreads: int = 0) -> NDArray[np.int32]:
        """Count all hits of each ray (..., 6), int32 (...): each crossing of a surface counts once."""
        return self._scene().bvh.count_hits(*_split_rays(rays)).astype(np.int32)

    def list_intersections(self, rays: object, nthreads: int = 0) -> Answers:
        """List all hits of each ray, by ray and then by t.

        Args:
            rays: (..., 6) float, N rays in C order.
            nthreads: without effect.

        Returns:
            ray_splits (N + 1,) uint32: ray i has the hits ray_splits[i]:ray_splits[i + 1]. Of each hit
            ray_ids, geometry_ids and primitive_ids, uint32; t_hit, float32; primitive_uvs (hits, 2) float32.
        """
        scene = self._scene()
        hits = scene.bvh.intersect_all(*_split_rays(rays))
        return {
            "ray_splits": hits.offsets.astype(np.uint32),
            "ray_ids": hits.ray.astype(np.uint32),
            "t_hit": hits.t,
            **scene.identify(hits.face),
            "primitive_uvs": np.stack([hits.u, hits.v], axis=-1),
        }

    def compute_closest_points(self, query_points: object, nthreads: int = 0) -> Answers:
        """Find the nearest point of the meshes to each point.

        Args:
            query_points: (..., 3) float.
            nthreads: without effect.

        Returns:
            points (..., 3) float32, or float64 where float64 vertices lie far from the origin;
            geometry_ids, primitive_ids, primitive_uvs and primitive_normals as for `cast_rays`. A point with
            NaN or infinity has none, nor has any point where there are no triangles: points is NaN then, and
            the rest as for a ray that misses.
        """
        scene = self._scene()
        nearest = scene.bvh.closest_point(as_array(query_points))
        return {
            "points": nearest.point,
            **scene.identify(nearest.face),
            "primitive_uvs": np.stack([nearest.u, nearest.v], axis=-1),
            "primitive_normals": scene.normals(nearest.face),
        }

    def compute_distance(self, query_points: object, nthreads: int = 0) -> NDArray[np.float32]:
        """The distance of each point (..., 3) from the meshes, float32 (...); inf where there is none."""
        return self._scene().bvh.distance(as_array(query_points))

    def compute_signed_distance(
        self, query_points: object, nthreads: int = 0, nsamples: int = 1
    ) -> NDArray[np.float32]:
        """`compute_distance`, negative inside of closed meshes, float32 (...).

        Args:
            query_points: (..., 3) float.
            nthreads: without effect.
            nsamples: odd, and without effect: inside and outside are exact.
        """
        _require_odd(nsamples)
        return self._scene().bvh.signed_distance(as_array(query_points))

    def compute_occupancy(
        self, query_points: object, nthreads: int = 0, nsamples: int = 1
    ) -> NDArray[np.float32]:
        """1 for points inside of closed meshes, 0 outside, float32 (...).

        Arguments as `compute_signed_distance`.
        """
        _require_odd(nsamples)
        return self._scene().bvh.contains(as_array(query_points)).astype(np.float32)

    @overload
    @staticmethod
    def create_rays_pinhole(
        intrinsic_matrix: object, extrinsic_matrix: object, width_px: int, height_px: int
    ) -> NDArray[np.float32]: ...

    @overload
    @staticmethod
    def create_rays_pinhole(
        fov_deg: float, center: object, eye: object, up: object, width_px: int, height_px: int
    ) -> NDArray[np.float32]: ...

    @staticmethod
    def create_rays_pinhole(*arguments: Any, **named: Any) -> NDArray[np.float32]:
        """Rays of a camera, one through the centre of each pixel.

        Args:
            intrinsic_matrix: (3, 3), camera to pixels.
            extrinsic_matrix: (4, 4), world to camera: a rotation and a shift.
            fov_deg: instead of both, the horizontal field of view in degrees, between 0 and 180,
            center: with it, the point looked at, (3,),
            eye: the camera's place, (3,),
            up: the direction in which rows go, (3,); columns go to the left, as Open3D has them.
            width_px: columns.
            height_px: rows.

        Returns:
            (height_px, width_px, 6) float32, the directions not normalized.

        Raises:
            ValueError: for another shape, a matrix without inverse, a view without a direction or parallel
                to `up`, and for less than one column or row.
            TypeError: for other arguments than those of one camera, and for a size that is no whole number.
        """
        cameras = rays_of_matrices, rays_of_view
        make = choose_overload("create_rays_pinhole", cameras, arguments, named)
        return make(*arguments, **named)

    def _scene(self) -> _BuiltScene:
        scene = self._built
        if scene is None:
            vertices, faces = self._meshes.join()
            bvh = build(vertices, faces, self._recipe)
            scene = self._built = _BuiltScene(bvh, vertices, faces, np.array(self._meshes.first_faces))
        return scene


class _JoinedMeshes:
    """Meshes that are added one by one and joined when they are needed."""

    def __init__(self) -> None:
        self.first_faces = [0]
        self._vertex_count = 0
        self._vertices: list[NDArray[Any]] = [np.empty((0, 3), np.float32)]
        self._faces = [np.empty((0, 3), np.uint32)]

    def add(self, mesh: Mesh) -> int:
        """Copy a mesh; its number."""
        self._vertices.append(mesh.vertices.copy())
        self._faces.append(mesh.faces.astype(np.uint32) + np.uint32(self._vertex_count))
        self._vertex_count += len(mesh.vertices)
        self.first_faces.append(self.first_faces[-1] + len(mesh.faces))
        return len(self.first_faces) - 2

    def join(self) -> tuple[NDArray[Any], NDArray[np.uint32]]:
        """Vertices of all meshes, and faces that index them."""
        self._vertices = [np.concatenate(self._vertices)]
        self._faces = [np.concatenate(self._faces)]
        return self._vertices[0], self._faces[0]


class _BuiltScene(NamedTuple):
    """One tree over all meshes, whose faces stand one mesh's after the other's."""

    bvh: Bvh
    vertices: NDArray[Any]
    faces: NDArray[np.uint32]
    first_faces: NDArray[np.int64]

    def identify(self, face: NDArray[np.int32]) -> Answers:
        """The mesh of each face and its number there; INVALID_ID for -1."""
        geometry = np.searchsorted(self.first_faces[1:], face, side="right")
        primitive = np.asarray(face - self.first_faces[geometry])
        invalid = RaycastingScene.INVALID_ID  # also what -1 is in uint32
        return {
            "geometry_ids": np.where(face < 0, invalid, geometry).astype(np.uint32),
            "primitive_ids": primitive.astype(np.uint32),
        }

    def normals(self, face: NDArray[np.int32]) -> NDArray[np.float32]:
        """Unit normals of faces, counterclockwise; zero for -1 and for faces without area."""
        normals = np.zeros((*face.shape, 3), np.float32)
        hit = face >= 0
        first, second, third = np.moveaxis(self.vertices[self.faces[face[hit]]].astype(np.float64), -2, 0)
        across = np.cross(second - first, third - first)
        length = np.linalg.norm(across, axis=-1, keepdims=True)
        normals[hit] = np.divide(across, length, out=np.zeros_like(across), where=length > 0)
        return normals


def _read_arrays(vertex_positions: object, triangle_indices: object) -> Mesh:
    return Mesh(as_array(vertex_positions), as_array(triangle_indices))


def _read_mesh(mesh: Any) -> Mesh:
    if hasattr(mesh, "vertex") and hasattr(mesh, "triangle"):
        return _read_arrays(mesh.vertex.positions, mesh.triangle.indices)
    faces = mesh.faces if hasattr(mesh, "faces") else getattr(mesh, "triangles", None)  # trimesh has both
    if faces is None or not hasattr(mesh, "vertices"):
        raise TypeError(f"mesh must have vertices and triangles, but {type(mesh).__name__} has not")
    return _read_arrays(mesh.vertices, faces)


def _split_rays(rays: object) -> tuple[NDArray[Any], NDArray[Any]]:
    array = as_array(rays)
    if array.ndim == 0 or array.shape[-1] != 6:
        raise ValueError(f"rays must have shape (..., 6), not {array.shape}")
    return array[..., :3], array[..., 3:]


def _require_odd(nsamples: int) -> None:
    if nsamples < 1 or nsamples % 2 == 0:
        raise ValueError(f"nsamples must be odd and at least 1, not {nsamples}")
