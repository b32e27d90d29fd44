"""Pictures and ray sets from a `treelet.Bvh`: a small wavefront renderer in numpy, or cupy on a CUDA device.

Every mode traces whole arrays of rays with `bvh.intersect` and `bvh.occluded`, so it doubles as an example
of how to use them. The same seed gives the same picture, whatever the chunk size or thread count; on a
CUDA device it is that picture but for the last bits of sines and powers.
"""

from treelet.render.arrays import upload_mesh
from treelet.render.camera import Camera
from treelet.render.image import save_png
from treelet.render.modes import MODES, render
from treelet.render.settings import RenderSettings

__all__ = ["MODES", "Camera", "RenderSettings", "render", "save_png", "upload_mesh"]
