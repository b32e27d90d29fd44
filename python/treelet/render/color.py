"""Colour maps, tone map and the sRGB curve. Arrays of any shape, colours in the last axis."""

from __future__ import annotations

import numpy as np

from treelet.render.arrays import Array, dot, module_of

# 33 stops of matplotlib's maps (CC0) in sRGB, joined by straight lines.
_INFERNO = (
    "000004 040312 0b0724 150b37 210c4a 2f0a5b 3d0965 4a0c6b 57106e 64156e 71196e 7d1e6d 8a226a 972766 "
    "a32c61 b0315b bc3754 c73e4c d24644 db503b e45a31 eb6628 f1731d f68013 f98e09 fb9d07 fcac11 fbbc21 "
    "f9cb35 f5db4c f2ea69 f3f68a fcffa4"
)
_CIVIDIS = (
    "00224e 00285b 002e6a 053371 1a386f 273e6e 32436d 3b496c 434e6c 4b546c 535a6d 5a5f6e 61656f 686a71 "
    "6f7073 767676 7d7c78 848279 8c8878 938e78 9b9476 a39a74 aba072 b4a76f bcae6c c4b468 cdbb63 d5c25e "
    "dec958 e7d150 f0d846 f9e03a fee838"
)


def _stops(text: str) -> Array:
    return np.array([list(bytes.fromhex(stop)) for stop in text.split()], dtype=np.float32) / 255.0


_MAPS = {"inferno": _stops(_INFERNO), "cividis": _stops(_CIVIDIS)}


def inferno(values: Array) -> Array:
    """Display colours (..., 3) in [0, 1] for values in [0, 1]: black, purple, orange, pale yellow."""
    return _mapped("inferno", values)


def cividis(values: Array) -> Array:
    """Display colours (..., 3) in [0, 1] for values in [0, 1]: navy, gray, yellow."""
    return _mapped("cividis", values)


def _mapped(name: str, values: Array) -> Array:
    xp = module_of(values)
    stops = xp.asarray(_MAPS[name])
    position = xp.linspace(0.0, 1.0, len(stops))
    channels = [xp.interp(values, position, stops[:, channel]) for channel in range(3)]
    return xp.stack(channels, axis=-1).astype(np.float32)


def luminance(color: Array) -> Array:
    """Relative luminance of linear Rec. 709 colours (..., 3)."""
    return dot(color, module_of(color).array([0.2126, 0.7152, 0.0722], dtype=color.dtype))


def srgb(linear: Array) -> Array:
    """Linear light in [0, 1] to sRGB display values in [0, 1]."""
    xp = module_of(linear)
    linear = xp.clip(linear, 0.0, 1.0)
    return xp.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)


def tone_mapped(radiance: Array) -> Array:
    """Linear radiance to display values in [0, 1]: Narkowicz's fit of the ACES film curve, then sRGB."""
    x = module_of(radiance).maximum(radiance, 0.0)
    return srgb(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14))


def to_bytes(display: Array) -> Array:
    """Display values in [0, 1] to uint8."""
    return (module_of(display).clip(display, 0.0, 1.0) * 255.0 + 0.5).astype(np.uint8)
