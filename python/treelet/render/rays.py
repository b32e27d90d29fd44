"""Sets of rays for measuring trees, all derived from a view and a seed.

Diffuse rays start where camera rays hit and leave in cosine-distributed directions; they are what Karras
and Aila judged trees by [KarrasAila2013 s5], since real renderers trace few coherent rays.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from treelet.render.arrays import Array, module_of
from treelet.render.camera import Camera
from treelet.render.directions import cosine_directions
from treelet.render.sampling import Sampler
from treelet.render.surface import Triangles


@dataclass(frozen=True)
class Rays:
    """A batch of rays of one kind."""

    kind: str  # "primary", "diffuse" or "ambient_occlusion"
    origins: Array  # (n, 3) float32
    directions: Array  # (n, 3) float32, unit
    t_max: float = np.inf  # in units of the direction's length
    any_hit: bool = False  # whether the first hit found is enough

    def __len__(self) -> int:
        return len(self.directions)

    def trace(self, bvh):
        """Answer the rays with `bvh`: Hits, or (n,) bool for any-hit rays."""
        query = bvh.occluded if self.any_hit else bvh.intersect
        return query(self.origins, self.directions, t_max=self.t_max)


def primary_rays(view, width: int, height: int, seed: int = 0, xp=np) -> Rays:
    """One jittered camera ray a pixel, row by row, in arrays of `xp`, numpy or cupy."""
    camera = Camera(view, width, height, xp)
    pixel = xp.arange(camera.pixel_count)
    origin, directions = camera.rays(pixel, *Sampler(seed, 1, xp).pairs(pixel, xp.zeros_like(pixel), 0))
    return Rays("primary", xp.ascontiguousarray(xp.broadcast_to(origin, directions.shape)), directions)


def diffuse_rays(bvh, mesh, primary: Rays, bounces: int = 1, samples: int = 1, seed: int = 0) -> Rays:
    """`samples` cosine-distributed rays from each hit of `primary`, followed for `bounces` surfaces.

    The rays of all bounces come one after the other in one batch, in the order of the pixels they belong to.
    """
    xp = module_of(primary.directions)
    sampler = Sampler(seed, samples, xp)
    triangles = Triangles(mesh.vertices, mesh.faces, xp)
    path = xp.tile(xp.arange(len(primary)), samples)
    sample = xp.repeat(xp.arange(samples), len(primary))
    rays = Rays("diffuse", xp.tile(primary.origins, (samples, 1)), xp.tile(primary.directions, (samples, 1)))
    batches = []
    for bounce in range(bounces):
        surface = triangles.surface(rays.trace(bvh), rays.directions)
        path, sample = path[surface.ray], sample[surface.ray]
        numbers = sampler.pairs(path, sample, 1 + bounce)
        rays = Rays("diffuse", surface.origins, cosine_directions(surface.normals, *numbers))
        batches.append(rays)
    origins = xp.concatenate([batch.origins for batch in batches])
    return Rays("diffuse", origins, xp.concatenate([batch.directions for batch in batches]))


def ambient_occlusion_rays(
    bvh, mesh, primary: Rays, reach: float = 0.08, samples: int = 1, seed: int = 0
) -> Rays:
    """Any-hit rays from the hits of `primary`, as long as `reach` times the diagonal of the scene."""
    diffuse = diffuse_rays(bvh, mesh, primary, bounces=1, samples=samples, seed=seed)
    bounds = np.asarray(bvh.bounds, dtype=np.float64)
    length = float(reach * np.linalg.norm(bounds[1] - bounds[0]))
    return Rays("ambient_occlusion", diffuse.origins, diffuse.directions, t_max=length, any_hit=True)
