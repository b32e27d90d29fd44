"""What stands and hangs in a room of the interior scene: table, chairs, bookcase, lamps, radiators."""

from __future__ import annotations

import numpy as np

from .joinery import LENGTH, WIDTH, amount, box_between, rods
from .shapes import Part, boxes, join, tubes

_TABLE = (3.6, 3.9)  # its middle
_FLOOR = 0.01


def table(generator: np.random.Generator, detail: float) -> Part:
    """A long table on four tapered legs, laid with thin rods of cutlery."""
    x, y = _TABLE
    top = box_between((x - 1.3, y - 0.45, 0.72, x + 1.3, y + 0.45, 0.76))
    feet = np.array([[x + i * 1.2, y + j * 0.38, 0.365] for i in (-1, 1) for j in (-1, 1)])
    legs, leg_faces = boxes(feet, [0.035, 0.035, 0.355])
    corners = legs.reshape(-1, 8, 3)
    corners[:, :4, :2] = feet[:, None, :2] + 0.5 * (corners[:, :4, :2] - feet[:, None, :2])
    count = amount(detail, 12, 2, 60)
    place = np.column_stack(
        [
            x - 1.15 + 2.3 * (np.arange(count) + 0.5) / count,
            y + 0.3 * (-1.0) ** np.arange(count),
            np.full(count, 0.768),
        ]
    )
    slant = np.column_stack([0.02 * generator.standard_normal(count), np.full(count, 0.09), np.zeros(count)])
    return join([top, (legs, leg_faces), rods(place - slant, place + slant, 0.006, amount(detail, 5, 3, 12))])


def chairs(generator: np.random.Generator, detail: float) -> Part:
    """Up to six chairs of legs and slats around the table, none pushed in quite straight."""
    count, slats = amount(detail, 4, 1, 6), amount(detail, 5, 2, 30)
    spread = (np.arange(slats) + 0.5) / slats * 0.36 - 0.18
    parts = [((0.0, 0.0, 0.45), (0.2, 0.2, 0.015)), ((0.0, 0.19, 0.93), (0.2, 0.012, 0.03))]
    parts += [((i * 0.18, j * 0.18, 0.225), (0.016, 0.016, 0.225)) for i in (-1, 1) for j in (-1, 1)]
    parts += [((i * 0.185, 0.19, 0.69), (0.014, 0.014, 0.24)) for i in (-1, 1)]
    parts += [((x, 0.19, 0.685), (0.12 / slats, 0.005, 0.225)) for x in spread]
    vertices, _ = boxes([centre for centre, _ in parts], [half for _, half in parts])
    seats = []
    for chair in range(count):
        side = 1.0 if chair % 2 == 0 else -1.0
        turn = 0.25 * generator.standard_normal() + (0.0 if side > 0 else np.pi)
        cosine, sine = np.float32(np.cos(turn)), np.float32(np.sin(turn))
        turned = np.column_stack(
            [
                cosine * vertices[:, 0] - sine * vertices[:, 1],
                sine * vertices[:, 0] + cosine * vertices[:, 1],
                vertices[:, 2],
            ]
        )
        place = [
            _TABLE[0] - 0.8 + 0.8 * (chair // 2),
            _TABLE[1] + side * (0.55 + 0.15 * generator.random()),
            _FLOOR,
        ]
        seats.append((turned + np.array(place, dtype=np.float32), boxes(np.zeros((len(parts), 3)), 1.0)[1]))
    return join(seats)


def bookcase(generator: np.random.Generator, detail: float) -> Part:
    """Shelves under the gallery, filled with books of every thickness and height."""
    shelves = amount(detail, 12, 2, 6)
    left, right, depth = 5.45, 7.75, 0.28
    boards = [
        (left, 0.02, 0.05 + 0.4 * level, right, depth, 0.075 + 0.4 * level) for level in range(shelves + 1)
    ]
    uprights = [(x, 0.02, 0.02, x + 0.025, depth, 2.47) for x in np.linspace(left - 0.025, right, 4)]
    count = amount(detail, 220, 3, 3000)
    shelf = np.arange(count) % shelves
    on_shelf = np.bincount(shelf, minlength=shelves)
    thickness = 0.4 + generator.random(count)
    ends = np.zeros(count)
    for level in range(shelves):
        row = shelf == level
        total = thickness[row].sum()
        thickness[row] *= (right - left - 0.1) / total if on_shelf[level] else 0.0
        ends[row] = np.cumsum(thickness[row])
    height = 0.2 + 0.14 * generator.random(count)
    reach = 0.14 + 0.1 * generator.random(count)
    centres = np.column_stack(
        [left + 0.05 + ends - thickness / 2.0, 0.03 + reach / 2.0, 0.075 + 0.4 * shelf + height / 2.0]
    )
    books = boxes(centres, np.column_stack([0.47 * thickness, reach / 2.0, height / 2.0]))
    return join([box_between(*boards, *uprights), books])


def lamps(generator: np.random.Generator, detail: float) -> Part:
    """Cones that hang over the table on cables four millimetres thick."""
    count, sides = amount(detail, 6, 1, 3), amount(detail, 16, 5, 96)
    x = _TABLE[0] + np.array([0.0, -0.9, 0.9])[:count]
    low = 1.75 + 0.08 * generator.random(count)
    foot = np.column_stack([x, np.full(count, _TABLE[1]), low])
    rims = [foot + np.array([0.0, 0.0, rise]) for rise in (0.0, 0.05, 0.16, 0.22)]
    cable_top = foot.copy()
    cable_top[:, 2] = 4.3
    return join(
        [
            tubes(np.stack(rims, axis=1).astype(np.float32), np.array([0.2, 0.19, 0.07, 0.02]), sides),
            rods(rims[-1], cable_top, 0.004, 3),
        ]
    )


def radiators(generator: np.random.Generator, detail: float) -> Part:
    """Rows of fins under the windows between two pipes."""
    count = amount(detail, 40, 3, 400)
    x = 0.5 + (LENGTH - 1.0) * (np.arange(count) + 0.5) / count
    fins = np.column_stack([x, np.full(count, WIDTH - 0.09), np.full(count, 0.42)])
    pipes = np.array([[0.4, WIDTH - 0.09, z] for z in (0.2, 0.64)])
    return join(
        [
            boxes(fins, [min(0.03, 2.0 / count), 0.045, 0.26]),
            rods(pipes, pipes + np.array([LENGTH - 0.8, 0.0, 0.0]), 0.018, amount(detail, 8, 4, 32)),
        ]
    )
