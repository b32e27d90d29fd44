"""An edge-avoiding filter for the noise that few samples leave.

A-trous wavelets [Dammertz2010] with the variance-driven weight of [Schied2017]: where the samples of a
pixel agree, its neighbours hardly count, so the filter fades away by itself as the sample count grows.
Planes (height, width) are kept apart in memory, which numpy works through several times faster than
interleaved colours.
"""

from __future__ import annotations

import itertools

import numpy as np

from treelet.render.arrays import Array, module_of

_KERNEL = {-1: 0.25, 0: 0.5, 1: 0.25}
_LEVELS = 5  # reaches 1 + 2 + 4 + 8 + 16 = 31 pixels
_NORMAL_SQUARINGS = 5  # cosine to the power of 32
_DEPTH_TOLERANCE = np.float32(0.02)  # share of the distance, a pixel of step
_NOISE_TOLERANCE = np.float32(4.0)  # standard deviations
_VARIANCE_BLURS = (
    6  # eight samples that happen to be dark alike claim no variance; their neighbours know better
)
_TINY = np.float32(1e-12)


def denoise(color: Array, variance: Array, normals: Array, depth: Array) -> Array:
    """Filter `color` (h, w, 3), leaving edges of `normals` (h, w, 3) and `depth` (h, w); float32.

    `variance` (h, w) is that of the pixel means of luminance. Depth 0 marks background.
    """
    xp = module_of(color)
    planes = xp.ascontiguousarray(xp.moveaxis(color, -1, 0), dtype=np.float32)
    facing = xp.ascontiguousarray(xp.moveaxis(normals, -1, 0), dtype=np.float32)
    facing /= xp.sqrt((facing * facing).sum(axis=0)) + _TINY
    depth = xp.ascontiguousarray(depth, dtype=np.float32)
    for _ in range(_VARIANCE_BLURS):
        variance = _blurred(variance)
    for level in range(_LEVELS):
        planes, variance = _filter_level(planes, variance, facing, depth, 1 << level)
    return _without_specks(xp.moveaxis(planes, 0, -1))


def _filter_level(
    planes: Array, variance: Array, normals: Array, depth: Array, step: int
) -> tuple[Array, Array]:
    xp = module_of(planes)
    luminance = planes.mean(axis=0)
    per_noise = np.float32(1.0) / (_NOISE_TOLERANCE * xp.sqrt(_blurred(variance)) + _TINY)
    per_depth = np.float32(1.0) / (_DEPTH_TOLERANCE * np.float32(step) * depth + _TINY)
    total = xp.zeros_like(variance)
    plane_sums, variance_sum = xp.zeros_like(planes), xp.zeros_like(variance)
    for dy, dx in itertools.product(_KERNEL, _KERNEL):
        here, there = _overlap(dy * step, dx * step)
        exponent = xp.abs(luminance[here] - luminance[there]) * per_noise[here]
        with np.errstate(over="ignore"):  # background beside what is far away: a weight of zero
            exponent += xp.abs(depth[here] - depth[there]) * per_depth[here]
        weight = xp.exp(-exponent) * np.float32(_KERNEL[dy] * _KERNEL[dx])
        if dy or dx:
            weight *= _alike(normals, here, there)
        total[here] += weight
        variance_sum[here] += weight * weight * variance[there]
        for plane_sum, plane in zip(plane_sums, planes, strict=True):
            plane_sum[here] += weight * plane[there]
    return plane_sums / total, variance_sum / (total * total)


def _alike(normals: Array, here, there) -> Array:
    """A high power of the cosine between two normals; background matches background."""
    cosine = sum(plane[here] * plane[there] for plane in normals)
    module_of(cosine).clip(cosine, 0.0, 1.0, out=cosine)
    for _ in range(_NORMAL_SQUARINGS):
        cosine *= cosine
    return cosine


def _overlap(dy: int, dx: int) -> tuple[tuple[slice, slice], tuple[slice, slice]]:
    """Slices of an image and of the same image shifted by (dy, dx), where both exist."""
    here = tuple(slice(max(0, -shift), -shift if shift > 0 else None) for shift in (dy, dx))
    there = tuple(slice(max(0, shift), shift if shift < 0 else None) for shift in (dy, dx))
    return here, there


def _blurred(values: Array) -> Array:
    """3 x 3 binomial blur with repeated borders."""
    padded = module_of(values).pad(values, 1, mode="edge")
    rows = 0.25 * padded[:-2] + 0.5 * padded[1:-1] + 0.25 * padded[2:]
    return 0.25 * rows[:, :-2] + 0.5 * rows[:, 1:-1] + 0.25 * rows[:, 2:]


def _without_specks(color: Array) -> Array:
    """Clamp each pixel to the range of its eight neighbours.

    A pixel on an edge sees two surfaces at once and matches neither side, so the filter leaves it as noisy
    as it was.
    """
    xp = module_of(color)
    height, width = color.shape[:2]
    padded = xp.pad(color, ((1, 1), (1, 1), (0, 0)), mode="edge")
    shifts = [(dy, dx) for dy, dx in itertools.product(range(3), range(3)) if (dy, dx) != (1, 1)]
    low, high = xp.full_like(color, np.inf), xp.full_like(color, -np.inf)
    for dy, dx in shifts:
        neighbour = padded[dy : dy + height, dx : dx + width]
        xp.minimum(low, neighbour, out=low)
        xp.maximum(high, neighbour, out=high)
    return xp.clip(color, low, high)
