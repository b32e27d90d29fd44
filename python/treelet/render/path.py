"""Diffuse path tracing under sun and sky, one wavefront of rays a bounce."""

from __future__ import annotations

import numpy as np

from treelet.render.arrays import Array, module_of, ratio
from treelet.render.color import luminance, tone_mapped
from treelet.render.denoise import denoise
from treelet.render.directions import cosine_directions
from treelet.render.studio import FIRST_FREE_DIMENSION, Studio
from treelet.render.work import Progress

# Stands for the bounces that are not followed, dimmed in narrow places.
_AMBIENT = np.array([0.10, 0.095, 0.09], dtype=np.float32)
_AMBIENT_REACH = 0.15  # share of the scene's diagonal
_MIDDLE_GRAY = 0.22
_BRIGHT = 0.80

# What one camera sample yields, in the last axis; of missed samples only the backdrop counts.
_RADIANCE, _NORMAL, _BACKDROP, _DEPTH, _SQUARE, _COVERED = slice(0, 3), slice(3, 6), slice(6, 9), 9, 10, 11
_CHANNELS = 12


def render_path(studio: Studio, progress: Progress | None = None) -> Array:
    """Path-traced picture, display colours (height, width, 3) in [0, 1].

    Mesh and backdrop are put together after the tone map: dark scenes stand before the same backdrop.
    """
    samples = studio.settings.samples
    picture = studio.average(lambda *where: _trace_paths(studio, *where), samples, _CHANNELS, progress)
    covered = picture[..., _COVERED, None]
    surface = ratio(picture, covered)
    radiance = surface[..., _RADIANCE]
    if studio.settings.denoise and samples > 1:
        spread = surface[..., _SQUARE] - luminance(radiance) ** 2
        variance = studio.xp.maximum(spread, 0.0) / (samples - 1)
        radiance = denoise(radiance, variance, surface[..., _NORMAL], surface[..., _DEPTH])
    exposure = studio.settings.exposure or _measured_exposure(radiance, covered[..., 0])
    return covered * tone_mapped(radiance * np.float32(exposure)) + picture[..., _BACKDROP]


def _trace_paths(studio: Studio, sampler, pixel: Array, sample: Array) -> Array:
    xp = studio.xp
    values = xp.zeros((len(pixel), _CHANNELS), dtype=np.float32)
    origins, directions = studio.camera_rays(sampler, pixel, sample)
    radiance = values[:, _RADIANCE]
    throughput = xp.ones((len(pixel), 3), dtype=np.float32)
    alive = xp.arange(len(pixel))
    for bounce in range(studio.settings.bounces + 1):
        hits = studio.bvh.intersect(origins, directions)
        missed = xp.flatnonzero(hits.face < 0)
        if bounce == 0:
            values[missed, _BACKDROP] = studio.light.backdrop(directions[missed])
        else:
            radiance[alive[missed]] += throughput[missed] * studio.light.sky(directions[missed])
        if bounce == studio.settings.bounces:
            hit = xp.flatnonzero(hits.face >= 0)
            radiance[alive[hit]] += throughput[hit] * _ambient(studio, hits.t[hit])
            break
        surface = studio.triangles.surface(hits, directions)
        alive, throughput = alive[surface.ray], throughput[surface.ray]
        if bounce == 0:
            _record_first_hit(values, alive, surface)
        throughput = throughput * studio.albedo(surface.points, surface.normals)
        where = pixel[alive], sample[alive], FIRST_FREE_DIMENSION + 2 * bounce
        radiance[alive] += throughput * _sunlight(studio, sampler, surface, where)
        origins = surface.origins
        directions = cosine_directions(surface.normals, *sampler.pairs(where[0], where[1], where[2] + 1))
    values[:, _SQUARE] = luminance(radiance) ** 2
    return values


def _record_first_hit(values: Array, alive: Array, surface) -> None:
    values[alive, _NORMAL] = surface.normals
    values[alive, _DEPTH] = surface.t
    values[alive, _COVERED] = 1.0


def _sunlight(studio: Studio, sampler, surface, where) -> Array:
    to_sun = studio.light.towards_sun(*sampler.pairs(*where))
    light = studio.light.sunlight(surface.normals, to_sun)
    facing = studio.xp.flatnonzero(light[:, 0] > 0.0)
    shadowed = studio.bvh.occluded(surface.origins[facing], to_sun[facing])
    light[facing] *= ~shadowed[:, None]
    return light


def _ambient(studio: Studio, t: Array) -> Array:
    far = t.astype(np.float64)  # in a huge scene the sum is beyond float32
    share = far / (far + _AMBIENT_REACH * studio.diagonal)
    return share.astype(np.float32)[:, None] * studio.xp.asarray(_AMBIENT)


def _measured_exposure(radiance: Array, covered: Array) -> float:
    """The factor that brings the scene's logarithmic mean to middle gray, short of bleaching its lights."""
    xp = module_of(radiance)
    seen = luminance(radiance)[covered > 0.5]
    seen = seen[seen > 0.0]
    if not len(seen):
        return 1.0
    mean, bright = xp.exp(xp.log(seen).mean()), xp.percentile(seen, 95.0)
    return min(float(_MIDDLE_GRAY / mean), float(_BRIGHT / bright))
