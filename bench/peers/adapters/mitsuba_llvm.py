"""Mitsuba 3 on the processor: Embree behind a just-in-time compiler, all threads."""

import drjit
import mitsuba
import numpy as np

NAME = "Mitsuba LLVM"

mitsuba.set_variant("llvm_ad_rgb")  # an ImportError where no LLVM is found


def build(vertices, faces):
    """From arrays to a function of origins and directions that gives t, inf for a miss."""
    mesh = mitsuba.Mesh("mesh", len(vertices), len(faces))
    arrays = mitsuba.traverse(mesh)
    arrays["vertex_positions"] = np.ravel(vertices)
    arrays["faces"] = np.ravel(faces).astype(np.uint32)
    arrays.update()
    scene = mitsuba.load_dict({"type": "scene", "mesh": mesh})
    drjit.sync_thread()

    def trace(origins, directions):
        ray = mitsuba.Ray3f(mitsuba.Point3f(origins.T), mitsuba.Vector3f(directions.T))
        return scene.ray_intersect_preliminary(ray, coherent=False).t.numpy()

    return trace
