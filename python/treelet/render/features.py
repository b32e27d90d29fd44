"""The modes that show geometry: depth, normals and ambient occlusion."""

from __future__ import annotations

import numpy as np

from treelet.render.arrays import Array, module_of, ratio, to_host
from treelet.render.color import cividis
from treelet.render.directions import cosine_directions
from treelet.render.studio import FIRST_FREE_DIMENSION, Studio
from treelet.render.work import Progress

_BACKGROUND = np.array([0.93, 0.94, 0.95], dtype=np.float32)
_MOST_FEATURE_SAMPLES = 16  # only edges gain from more than one


def render_depth(studio: Studio, progress: Progress | None = None) -> Array:
    """Distance along the ray, near light, far dark; display colours (height, width, 3) in [0, 1]."""

    xp = studio.xp

    def trace(sampler, pixel, sample) -> Array:
        hits = studio.bvh.intersect(*studio.camera_rays(sampler, pixel, sample))
        is_hit = hits.face >= 0
        return xp.stack([xp.where(is_hit, hits.t, np.float32(0.0)), is_hit.astype(np.float32)], axis=-1)

    picture = studio.average(trace, _feature_samples(studio), 2, progress)
    covered = picture[..., 1]
    depth = ratio(picture[..., 0], covered)
    seen = depth[covered > 0.0]
    near, far = to_host(xp.percentile(seen, [1.0, 98.0])) if len(seen) else (0.0, 1.0)
    nearness = 1.0 - (depth - near) / max(far - near, np.finfo(np.float32).tiny)
    return _over_background(cividis(nearness), covered)


def render_normals(studio: Studio, progress: Progress | None = None) -> Array:
    """Geometric normals facing the camera as colours (n + 1) / 2; (height, width, 3) in [0, 1]."""

    background = studio.xp.asarray(_BACKGROUND)

    def trace(sampler, pixel, sample) -> Array:
        origin, directions = studio.camera_rays(sampler, pixel, sample)
        surface = studio.triangles.surface(studio.bvh.intersect(origin, directions), directions)
        values = studio.xp.tile(background, (len(pixel), 1))
        values[surface.ray] = 0.5 * surface.normals + 0.5
        return values

    return studio.average(trace, _feature_samples(studio), 3, progress)


def render_ambient_occlusion(studio: Studio, progress: Progress | None = None) -> Array:
    """Share of the hemisphere that is free within `settings.reach`; display colours (height, width, 3)."""
    reach = np.float32(studio.settings.reach * studio.diagonal)

    def trace(sampler, pixel, sample) -> Array:
        origin, directions = studio.camera_rays(sampler, pixel, sample)
        surface = studio.triangles.surface(studio.bvh.intersect(origin, directions), directions)
        numbers = sampler.pairs(pixel[surface.ray], sample[surface.ray], FIRST_FREE_DIMENSION)
        to_sky = cosine_directions(surface.normals, *numbers)
        values = studio.xp.zeros((len(pixel), 2), dtype=np.float32)
        values[surface.ray, 0] = ~studio.bvh.occluded(surface.origins, to_sky, t_max=reach)
        values[surface.ray, 1] = 1.0
        return values

    picture = studio.average(trace, studio.settings.samples, 2, progress)
    covered = picture[..., 1]
    free = ratio(picture[..., 0], covered, otherwise=1.0)
    return _over_background(studio.xp.repeat(0.97 * free[..., None], 3, axis=-1), covered)


def _feature_samples(studio: Studio) -> int:
    return min(studio.settings.samples, _MOST_FEATURE_SAMPLES)


def _over_background(colors: Array, covered: Array) -> Array:
    background = module_of(colors).asarray(_BACKGROUND)
    return background + (colors - background) * covered[..., None]
