"""What is built into a room of the interior scene: floor, beams, pipes, blinds, stairs, gallery.

A room spans x 0 to 8, y 0 to 6 and z 0 to 4.5 metres; windows in the wall at y = 6, doors in those at x = 0
and x = 8. `detail` scales counts: 1 is a room of some ten thousand triangles.
"""

from __future__ import annotations

import numpy as np

from .shapes import Floats, Part, boxes, join, tubes

LENGTH, WIDTH, HEIGHT = 8.0, 6.0, 4.5
_WINDOWS = 4
_SILL, _LINTEL = 0.9, 3.6


def amount(detail: float, usual: float, fewest: int, most: int = 1_000_000) -> int:
    """How many of a thing there are at a level of detail."""
    return int(np.clip(round(usual * detail), fewest, most))


def box_between(*corners: tuple[float, float, float, float, float, float]) -> Part:
    """Boxes from low and high corners: (x0, y0, z0, x1, y1, z1) each."""
    spans = np.array(corners, dtype=np.float64)
    return boxes((spans[:, 3:] + spans[:, :3]) / 2.0, (spans[:, 3:] - spans[:, :3]) / 2.0)


def rods(starts: Floats, ends: Floats, radius: float, sides: int) -> Part:
    """Straight open tubes, 2 x sides triangles each, as long and thin as they come."""
    paths = np.stack([np.asarray(starts), np.asarray(ends)], axis=1).astype(np.float32)
    return tubes(paths, radius, sides)


def shell() -> Part:
    """Floor, ceiling and walls a tenth thick, with two doorways and the window openings."""
    thick = 0.1
    openings = np.linspace(0.0, LENGTH, _WINDOWS + 1)
    posts = [(x - 0.08, WIDTH, _SILL, x + 0.08, WIDTH + thick, _LINTEL) for x in openings]
    doors = [
        wall
        for x in (-thick, LENGTH)
        for wall in (
            (x, 0.0, 0.0, x + thick, 3.4, HEIGHT),
            (x, 4.4, 0.0, x + thick, WIDTH, HEIGHT),
            (x, 3.4, 2.1, x + thick, 4.4, HEIGHT),
        )
    ]
    return box_between(
        (-thick, -thick, -thick, LENGTH + thick, WIDTH + thick, -0.02),
        (-thick, -thick, HEIGHT, LENGTH + thick, WIDTH + thick, HEIGHT + thick),
        (-thick, -thick, -0.02, LENGTH + thick, 0.0, HEIGHT),
        (0.0, WIDTH, 0.0, LENGTH, WIDTH + thick, _SILL),
        (0.0, WIDTH, _LINTEL, LENGTH, WIDTH + thick, HEIGHT),
        *posts,
        *doors,
    )


def planks(generator: np.random.Generator, detail: float) -> Part:
    """Floor boards as long as the room, a hair's gap between them."""
    count = amount(detail, 40, 3, 240)
    pitch = WIDTH / count
    y = (np.arange(count) + 0.5) * pitch
    lift = 0.002 * generator.random(count)
    centres = np.column_stack([np.full(count, LENGTH / 2.0), y, lift - 0.01])
    return boxes(centres, [LENGTH / 2.0, 0.5 * pitch - min(0.004, 0.1 * pitch), 0.01])


def beams(generator: np.random.Generator, detail: float) -> Part:
    """Joists from wall to wall under the ceiling and two girders under them."""
    count = amount(detail, 9, 3, 40)
    x = (np.arange(count) + 0.5) * LENGTH / count
    joists = boxes(
        np.column_stack([x, np.full(count, WIDTH / 2.0), np.full(count, HEIGHT - 0.11)]),
        [0.05, WIDTH / 2.0, 0.11],
    )
    girders = box_between(
        *((0.0, y - 0.09, HEIGHT - 0.5, LENGTH, y + 0.09, HEIGHT - 0.22) for y in (2.0, 4.3))
    )
    return join([joists, girders])


def pipes(generator: np.random.Generator, detail: float) -> Part:
    """Pipes that run the length of the room and then down the wall."""
    count, sides = amount(detail, 6, 2, 24), amount(detail, 10, 3, 48)
    lane = np.arange(count)
    y, z = 0.12 + 0.14 * (lane % 8), HEIGHT - 0.62 - 0.16 * (lane // 8)
    reach = LENGTH - 0.1 - 0.1 * lane
    knots = [
        (np.full(count, 0.0), y, z),
        (reach - 0.1, y, z),
        (reach, y, z - 0.1),
        (reach, y, np.full(count, 2.75)),
    ]
    paths = np.stack([np.column_stack(knot) for knot in knots], axis=1).astype(np.float32)
    return tubes(paths, (0.025 + 0.035 * generator.random((count, 1))).astype(np.float32), sides)


def cables(generator: np.random.Generator, detail: float) -> Part:
    """Thin cables that sag from joist to joist."""
    count, knots = amount(detail, 14, 1, 60), amount(detail, 14, 3, 60) + 1
    along = np.linspace(0.0, 1.0, knots)[None]
    y = 4.5 + 0.6 * generator.random((count, 1))
    sag = 0.05 + 0.2 * generator.random((count, 1))
    sway = 0.05 * np.sin(2.0 * np.pi * (along * 3.0 + generator.random((count, 1))))
    x, z = (
        np.broadcast_to(along * LENGTH, (count, knots)),
        HEIGHT - 0.3 - sag * np.sin(3.0 * np.pi * along) ** 2,
    )
    return tubes(np.stack([x, y + sway, z], axis=-1).astype(np.float32), 0.008, 3)


def blinds(generator: np.random.Generator, detail: float) -> Part:
    """Venetian blinds: slats tilted by an angle of each window's own, on two cords."""
    count = amount(detail, 34, 2, 300)
    pitch = LENGTH / _WINDOWS
    window = np.repeat(np.arange(_WINDOWS), count)
    drop = np.array([1.0, 0.55, 0.8, 1.0])[window]
    height = (
        _LINTEL - 0.05 - drop * (_LINTEL - _SILL - 0.1) * (np.tile(np.arange(count), _WINDOWS) + 0.5) / count
    )
    centres = np.column_stack([(window + 0.5) * pitch, np.full(len(window), WIDTH - 0.08), height]).astype(
        np.float32
    )
    depth = min(0.035, 1.1 / count)
    vertices, faces = boxes(np.zeros_like(centres), [pitch / 2.0 - 0.12, depth, 0.0012])
    tilt = (0.15 + 0.9 * generator.random(_WINDOWS)).astype(np.float32)[window][:, None]
    corners = vertices.reshape(-1, 8, 3)
    y, z = corners[..., 1].copy(), corners[..., 2].copy()
    corners[..., 1], corners[..., 2] = (
        np.cos(tilt) * y - np.sin(tilt) * z,
        np.sin(tilt) * y + np.cos(tilt) * z,
    )
    corners += centres[:, None]
    cord_x = ((np.arange(_WINDOWS)[:, None] + 0.5) * pitch + np.array([-0.55, 0.55])).reshape(-1)
    top = np.column_stack([cord_x, np.full_like(cord_x, WIDTH - 0.08), np.full_like(cord_x, _LINTEL)])
    return join([(vertices, faces), rods(top, top - [0.0, 0.0, _LINTEL - _SILL], 0.003, 3)])


def stairs(generator: np.random.Generator, detail: float) -> Part:
    """Open treads along the wall up to the gallery, two stringers, balusters and a handrail."""
    steps = amount(detail, 26, 4, 13)
    rise = (np.arange(steps) + 1.0) / steps
    treads = np.column_stack([1.65 + 3.25 * rise, np.full(steps, 0.65), 2.6 * rise - 0.02])
    count = amount(detail, 26, 3, 260)
    along = (np.arange(count) + 0.5) / count
    foot = np.column_stack([1.8 + 3.3 * along, np.full(count, 1.12), 0.1 + 2.6 * along])
    rail = np.array([[[1.75, 1.12, 1.05], [5.15, 1.12, 3.72]]], dtype=np.float32)
    stringers = np.array([[[1.75, y, 0.0], [5.2, y, 2.55]] for y in (0.15, 1.15)], dtype=np.float32)
    return join(
        [
            boxes(treads, [0.15, 0.5, 0.02]),
            rods(foot, foot + np.array([0.0, 0.0, 0.96]), 0.009, amount(detail, 6, 3, 12)),
            tubes(rail, 0.03, amount(detail, 8, 4, 32)),
            tubes(stringers, 0.05, 4),
        ]
    )


def gallery(generator: np.random.Generator, detail: float) -> Part:
    """A mezzanine over one corner, on two posts, with a railing."""
    count = amount(detail, 34, 3, 340)
    along = (np.arange(count) + 0.5) / count
    foot = np.column_stack([5.25 + 2.7 * along, np.full(count, 2.95), np.full(count, 2.7)])
    return join(
        [
            box_between(
                (5.2, 0.0, 2.58, LENGTH, 3.0, 2.7),
                (5.25, 2.85, 0.0, 5.37, 2.97, 2.58),
                (7.8, 2.85, 0.0, 7.92, 2.97, 2.58),
                (5.2, 2.92, 3.66, LENGTH, 2.98, 3.71),
            ),
            rods(foot, foot + np.array([0.0, 0.0, 0.96]), 0.008, amount(detail, 6, 3, 12)),
        ]
    )
