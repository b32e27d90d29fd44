"""NVIDIA Warp on the processor, one thread."""

import numpy as np
import warp

NAME = "Warp CPU"

warp.config.log_level = warp.LOG_WARNING
warp.init()


@warp.kernel
def _closest(
    mesh: warp.uint64,
    origins: warp.array(dtype=warp.vec3),
    directions: warp.array(dtype=warp.vec3),
    t: warp.array(dtype=float),
):
    ray = warp.tid()
    found = warp.mesh_query_ray(mesh, origins[ray], directions[ray], warp.inf)
    t[ray] = warp.where(found.result, found.t, warp.inf)


def build(vertices, faces):
    """From arrays to a function of origins and directions that gives t, inf for a miss."""
    points = warp.array(vertices, dtype=warp.vec3, device="cpu")
    corners = warp.array(np.ravel(faces).astype(np.int32), dtype=warp.int32, device="cpu")
    mesh = warp.Mesh(points, corners)

    def trace(origins, directions):
        rays = [warp.array(each, dtype=warp.vec3, device="cpu") for each in (origins, directions)]
        t = warp.empty(len(origins), dtype=float, device="cpu")
        warp.launch(_closest, dim=len(origins), inputs=[mesh.id, *rays, t], device="cpu")
        return t.numpy()

    return trace
