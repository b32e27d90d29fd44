"""Mitsuba 3 on CUDA, which traces with OptiX: the driver must bring it (libnvoptix).

On devices without ray-tracing cores OptiX does the same in software.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from treelet.render.rays import Rays

NAME = "mitsuba"
VARIANTS = ("optix",)


def load() -> Mitsuba:
    """Raises ImportError without Mitsuba, OSError where the driver brings no OptiX."""
    import drjit
    import mitsuba

    ctypes.CDLL("libnvoptix.so.1")
    mitsuba.set_variant("cuda_ad_rgb")
    return Mitsuba(drjit, mitsuba)


class Mitsuba:
    """See `Peer`."""

    def __init__(self, drjit: Any, mitsuba: Any) -> None:
        self._dr, self._mi = drjit, mitsuba
        self.version = f"mitsuba {mitsuba.__version__}"

    def synchronize(self) -> None:
        """Wait for the device."""
        self._dr.sync_thread()

    def upload(self, vertices: np.ndarray, faces: np.ndarray) -> Callable[[str], Any]:
        """A scene builds its tree when it is made of a shape."""
        mi = self._mi
        mesh = mi.Mesh("mesh", vertex_count=len(vertices), face_count=len(faces))
        parameters = mi.traverse(mesh)
        parameters["vertex_positions"] = mi.Float(np.ravel(vertices).astype(np.float32))
        parameters["faces"] = mi.UInt32(np.ravel(faces).astype(np.uint32))
        parameters.update()
        return lambda variant: mi.load_dict({"type": "scene", "mesh": mesh})

    def prepare(self, tree: Any, rays: Rays) -> _Tracer:
        """Copy rays."""
        mi = self._mi
        origins, directions = (
            [mi.Float(np.ascontiguousarray(part[:, axis])) for axis in range(3)]
            for part in (rays.origins, rays.directions)
        )
        batch = mi.Ray3f(mi.Point3f(*origins), mi.Vector3f(*directions))
        if math.isfinite(rays.t_max):
            batch.maxt = mi.Float(rays.t_max)
        self._dr.eval(batch)
        return _Tracer(self._dr, tree, batch, rays.any_hit)


class _Tracer:
    def __init__(self, drjit: Any, scene: Any, rays: Any, any_hit: bool) -> None:
        self._dr, self._rays, self._any_hit = drjit, rays, any_hit
        self._query = scene.ray_test if any_hit else scene.ray_intersect_preliminary
        self._found: Any = None

    def __call__(self) -> None:
        self._found = self._query(self._rays, coherent=False)
        self._dr.eval(self._found)

    def answers(self) -> Any:
        if self._any_hit:
            return np.array(self._found)
        t = np.array(self._found.t)
        return t, np.where(np.isfinite(t), np.array(self._found.prim_index).astype(np.int64), -1)
