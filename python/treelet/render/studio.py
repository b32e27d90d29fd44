"""Everything one picture needs, prepared once: tree, triangles, camera, light, random numbers."""

from __future__ import annotations

import numpy as np

from treelet.render.camera import Camera
from treelet.render.light import Albedo, Light
from treelet.render.sampling import Sampler
from treelet.render.settings import RenderSettings
from treelet.render.surface import Triangles
from treelet.render.work import Progress, for_each_chunk

Array = np.ndarray

# Dimensions of the sampler; a path adds two for each bounce after these.
_LENS_DIMENSION = 0
FIRST_FREE_DIMENSION = 1


class Studio:
    """A mesh and its `Bvh`, seen through a view with given settings."""

    def __init__(self, bvh, mesh, view, settings: RenderSettings) -> None:
        self.bvh, self.settings = bvh, settings
        self.camera = Camera(view, settings.width, settings.height)
        self.triangles = Triangles(mesh.vertices, mesh.faces)
        self.light = Light(self.camera)
        bounds = np.asarray(bvh.bounds, dtype=np.float64)
        if not np.isfinite(bounds).all():  # of a tree without triangles
            bounds = np.zeros((2, 3))
        self.albedo = Albedo(bounds, self.camera.up.astype(np.float32))
        self.diagonal = float(np.linalg.norm(bounds[1] - bounds[0]))

    def camera_rays(self, sampler: Sampler, pixel: Array, sample: Array) -> tuple[Array, Array]:
        """Origin (3,) and directions (n, 3) of samples inside their pixels."""
        return self.camera.rays(pixel, *sampler.pairs(pixel, sample, _LENS_DIMENSION))

    def average(self, trace, samples: int, channels: int, progress: Progress | None = None) -> Array:
        """Mean over each pixel's samples of trace(sampler, pixel, sample) -> (n, channels).

        Returns (height, width, channels) float32. Whole pixels make a chunk, so sums never cross chunks.
        """
        sampler = Sampler(self.settings.seed, samples)
        picture = np.empty((self.camera.pixel_count, channels), dtype=np.float32)

        def fill(pixels: Array) -> None:
            pixel = np.repeat(pixels, samples)
            sample = np.tile(np.arange(samples), len(pixels))
            values = trace(sampler, pixel, sample).reshape(len(pixels), samples, channels)
            picture[pixels] = values.mean(axis=1, dtype=np.float64)

        for_each_chunk(self.camera.pixel_count, max(1, self.settings.chunk // samples), fill, progress)
        return picture.reshape(self.camera.height, self.camera.width, channels)
