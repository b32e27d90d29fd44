"""warp-lang: `wp.Mesh` and `mesh_query_ray`, a binary tree that the device builds (lbvh) or the CPU (sah)."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from treelet.render.rays import Rays

NAME = "warp"
VARIANTS = ("lbvh", "sah")


def load() -> Warp:
    """Raises ImportError without warp, OSError where it finds no CUDA device."""
    import warp

    warp.init()
    if not warp.is_cuda_available():
        raise OSError("warp finds no CUDA device")
    return Warp(warp)


def _compile(wp: Any) -> tuple[Any, Any]:
    """The kernels. Their annotations are set as objects: warp is no global that text could name."""

    def closest(mesh, origins, directions, t_max, t, face):
        i = wp.tid()
        hit = wp.mesh_query_ray(mesh, origins[i], directions[i], t_max)
        if hit.result:
            t[i] = hit.t
            face[i] = hit.face
        else:
            t[i] = wp.inf
            face[i] = -1

    def occluded(mesh, origins, directions, t_max, found):
        i = wp.tid()
        found[i] = wp.mesh_query_ray_anyhit(mesh, origins[i], directions[i], t_max)

    vectors = wp.array(dtype=wp.vec3)
    rays = {"mesh": wp.uint64, "origins": vectors, "directions": vectors, "t_max": wp.float32}
    closest.__annotations__ = rays | {"t": wp.array(dtype=wp.float32), "face": wp.array(dtype=wp.int32)}
    occluded.__annotations__ = rays | {"found": wp.array(dtype=wp.bool)}
    return wp.kernel(closest), wp.kernel(occluded)


class Warp:
    """See `Peer`."""

    def __init__(self, warp: Any, device: str = "cuda") -> None:
        self._wp, self._device = warp, device
        self.version = f"warp {warp.__version__}"
        self._closest, self._occluded = _compile(warp)

    def synchronize(self) -> None:
        """Wait for the device."""
        self._wp.synchronize()

    def upload(self, vertices: np.ndarray, faces: np.ndarray) -> Callable[[str], Any]:
        """A mesh builds its tree in its constructor."""
        wp = self._wp
        points = wp.array(np.asarray(vertices, np.float32), dtype=wp.vec3, device=self._device)
        indices = wp.array(np.ravel(faces).astype(np.int32), dtype=wp.int32, device=self._device)
        return lambda variant: wp.Mesh(points=points, indices=indices, bvh_constructor=variant)

    def prepare(self, tree: Any, rays: Rays) -> _Tracer:
        """Copy rays."""
        kernel = self._occluded if rays.any_hit else self._closest
        return _Tracer(self._wp, self._device, kernel, tree, rays)


class _Tracer:
    def __init__(self, wp: Any, device: str, kernel: Any, tree: Any, rays: Rays) -> None:
        dtypes = (wp.bool,) if rays.any_hit else (wp.float32, wp.int32)
        vectors = [wp.array(part, dtype=wp.vec3, device=device) for part in (rays.origins, rays.directions)]
        reach = rays.t_max if math.isfinite(rays.t_max) else float(np.finfo(np.float32).max)
        self._outputs = [wp.empty(len(rays), dtype=dtype, device=device) for dtype in dtypes]
        self._launch = lambda: wp.launch(
            kernel,
            dim=len(rays),
            inputs=[tree.id, *vectors, reach],
            outputs=self._outputs,
            device=device,
        )

    def __call__(self) -> None:
        self._launch()

    def answers(self) -> Any:
        arrays = [output.numpy() for output in self._outputs]
        return arrays[0] if len(arrays) == 1 else tuple(arrays)
