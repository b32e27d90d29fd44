"""PNG files, and putting pictures together with captions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

Array = np.ndarray

_PAPER = (17, 18, 23)
_INK = (236, 238, 242)
_QUIET_INK = (160, 165, 178)
_GAP = 8  # pixels between panels


def save_png(path: str | Path, picture: Array) -> Path:
    """Write (height, width, 3) uint8 as PNG, making the folder; returns the path."""
    image = _pillow().fromarray(np.ascontiguousarray(picture))
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    image.save(path, format="PNG", optimize=True)
    return path


def beside(pictures: Sequence[Array]) -> Array:
    """Pictures of one height from left to right, a gap between them."""
    height = pictures[0].shape[0]
    gap = _blank(height, _GAP)
    parts = [part for picture in pictures for part in (gap, picture)][1:]
    return np.concatenate(parts, axis=1)


def stacked(pictures: Sequence[Array]) -> Array:
    """Pictures of one width from top to bottom."""
    return np.concatenate(list(pictures), axis=0)


def titled(picture: Array, title: str, note: str) -> Array:
    """A caption strip above the picture: `title` on the left, `note` on the right."""
    width = picture.shape[1]
    size = _text_size(width)
    strip = _pillow().fromarray(_blank(2 * size, width))
    draw = _draw(strip)
    draw.text((size * 0.6, size), title, fill=_INK, font=_font(size), anchor="lm")
    draw.text((width - size * 0.6, size), note, fill=_QUIET_INK, font=_font(size), anchor="rm")
    return stacked([np.asarray(strip), picture])


def colour_bar(colours: Callable[[Array], Array], top: float, caption: str, width: int) -> Array:
    """A horizontal scale from 0 to `top` with round ticks, (height, width, 3) uint8."""
    size = _text_size(width // 2)
    left, right = round(0.25 * width), round(0.75 * width)
    bar_top, bar_bottom = round(0.9 * size), round(1.7 * size)
    strip = _blank(round(3.3 * size), width)
    ramp = colours(np.linspace(0.0, 1.0, right - left))
    strip[bar_top:bar_bottom, left:right] = (255.0 * ramp + 0.5).astype(np.uint8)
    image = _pillow().fromarray(strip)
    draw = _draw(image)
    for tick in round_ticks(top):
        x = left + (right - left - 1) * tick / top
        draw.line([(x, bar_bottom), (x, bar_bottom + 0.25 * size)], fill=_QUIET_INK)
        draw.text(
            (x, bar_bottom + 0.4 * size),
            f"{tick:g}",
            fill=_QUIET_INK,
            font=_font(round(0.8 * size)),
            anchor="mt",
        )
    draw.text(
        (left - size, (bar_top + bar_bottom) / 2),
        caption,
        fill=_INK,
        font=_font(round(0.8 * size)),
        anchor="rm",
    )
    return np.asarray(image)


def round_ticks(top: float) -> list[float]:
    """Four to nine multiples of 1, 2 or 5 times a power of ten, from 0 up to `top` > 0."""
    power = 10.0 ** np.floor(np.log10(top))
    step = next(power * factor for factor in (0.2, 0.5, 1.0, 2.0) if top <= 9.0 * power * factor)
    return [round(step * index, 12) for index in range(int(top / step) + 1)]


def _blank(height: int, width: int) -> Array:
    return np.full((height, width, 3), _PAPER, dtype=np.uint8)


def _text_size(width: int) -> int:
    return max(10, round(width / 38))


def _pillow():
    try:
        from PIL import Image
    except ImportError as missing:
        raise ImportError("writing pictures needs Pillow: pip install 'treelet[cli]'") from missing
    return Image


def _draw(image):
    from PIL import ImageDraw

    return ImageDraw.Draw(image)


def _font(size: int):
    from PIL import ImageFont

    return ImageFont.load_default(size=size)
