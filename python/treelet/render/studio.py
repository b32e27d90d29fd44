"""Everything one picture needs, prepared once: tree, triangles, camera, light, random numbers."""

from __future__ import annotations

import numpy as np

from treelet.render.arrays import Array, module_for
from treelet.render.camera import Camera
from treelet.render.light import Albedo, Light
from treelet.render.sampling import Sampler
from treelet.render.settings import RenderSettings
from treelet.render.surface import Triangles
from treelet.render.work import Progress, for_each_chunk, for_each_wave

# Dimensions of the sampler; a path adds two for each bounce after these.
_LENS_DIMENSION = 0
FIRST_FREE_DIMENSION = 1

_HOST_RAYS = 1 << 16  # in flight in each thread
_DEVICE_RAYS = 1 << 21  # in flight on a CUDA device, each with less than 512 bytes: 1 GiB


class Studio:
    """A mesh and its `Bvh`, seen through a view with given settings."""

    def __init__(self, bvh, mesh, view, settings: RenderSettings) -> None:
        self.bvh, self.settings, self.xp = bvh, settings, module_for(bvh)
        self.camera = Camera(view, settings.width, settings.height, self.xp)
        self.triangles = Triangles(mesh.vertices, mesh.faces, self.xp)
        self.light = Light(self.camera, self.xp)
        bounds = np.asarray(bvh.bounds, dtype=np.float64)
        if not np.isfinite(bounds).all():  # of a tree without triangles
            bounds = np.zeros((2, 3))
        self.albedo = Albedo(bounds, self.camera.up.astype(np.float32), self.xp)
        self.diagonal = float(np.linalg.norm(bounds[1] - bounds[0]))

    def camera_rays(self, sampler: Sampler, pixel: Array, sample: Array) -> tuple[Array, Array]:
        """Origin (3,) and directions (n, 3) of samples inside their pixels."""
        return self.camera.rays(pixel, *sampler.pairs(pixel, sample, _LENS_DIMENSION))

    def average(self, trace, samples: int, channels: int, progress: Progress | None = None) -> Array:
        """Mean over each pixel's samples of trace(sampler, pixel, sample) -> (n, channels).

        Returns (height, width, channels) float32. Whole pixels make a chunk, so sums never cross chunks.
        """
        xp = self.xp
        sampler = Sampler(self.settings.seed, samples, xp)
        picture = xp.empty((self.camera.pixel_count, channels), dtype=np.float32)

        def fill(pixels: range) -> None:
            pixel = xp.repeat(xp.arange(pixels.start, pixels.stop), samples)
            sample = xp.tile(xp.arange(samples), len(pixels))
            values = trace(sampler, pixel, sample).reshape(len(pixels), samples, channels)
            picture[pixels.start : pixels.stop] = values.mean(axis=1, dtype=np.float64)

        run, most_rays = (for_each_chunk, _HOST_RAYS) if xp is np else (for_each_wave, _DEVICE_RAYS)
        most_rays = self.settings.chunk or most_rays
        run(self.camera.pixel_count, max(1, most_rays // samples), fill, progress)
        return picture.reshape(self.camera.height, self.camera.width, channels)
