"""A forest on rolling ground: trunks, branches and leaves, a trail between them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..view import View
from . import terrain
from .shapes import Floats, Part, grid_faces, random_generator, repeat_faces, sphere_directions, tubes, unit

SUMMARY = "a forest of conifers and broadleaf trees on rolling ground: mostly leaves of two small triangles"
_SPACING = 8.0  # metres between trees
_VARIANTS = 6
_TRAIL_HALF_WIDTH = 4.5
_GROUND_SHARE = 0.1
# A leaf is folded along its midrib: stem, one side, tip, other side; x along the leaf, z its normal.
_LEAF: Floats = np.array(
    [[0.0, 0.0, 0.0], [0.5, -0.32, 0.1], [1.0, 0.0, 0.0], [0.5, 0.32, 0.1]], dtype=np.float32
)
_LEAF_FACES = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32)


def build(triangles: int, seed: int) -> Part:
    """Ground (a tenth) and trees, within 2 % of those asked for (5 % below 5 000). Metres, z up.

    More triangles mean more trees, and more branches and smaller leaves on each. Six trees are grown, three
    of each kind; the forest repeats them turned and scaled.
    """
    generator = random_generator(seed)
    tree_count = max(4, round(6 * (triangles / 1000) ** 0.55))
    half_size = _SPACING * np.sqrt(tree_count) / 2.0
    cells = max(2, round(np.sqrt(_GROUND_SHARE * triangles / 2.0)))
    per_tree = max(60, round((triangles - 2 * cells**2) / tree_count))
    trees = [
        _tree(random_generator(seed, 2, variant), per_tree, variant % 2 == 0) for variant in range(_VARIANTS)
    ]
    tree_faces = trees[0][1]
    tree_size = len(trees[0][0])
    ground_size = (cells + 1) ** 2
    vertices = np.empty((ground_size + tree_count * tree_size, 3), dtype=np.float32)
    faces = np.empty((2 * cells**2 + tree_count * len(tree_faces), 3), dtype=np.int32)
    vertices[:ground_size] = _ground(half_size * 1.15, cells, seed)
    faces[: 2 * cells**2] = grid_faces(cells + 1, cells + 1)
    positions = _positions(generator, tree_count, half_size, seed)
    turns = generator.random(tree_count) * 2.0 * np.pi
    scales = 0.7 + 0.6 * generator.random(tree_count)
    variants = generator.integers(0, _VARIANTS, tree_count)
    for tree in range(tree_count):
        start = ground_size + tree * tree_size
        _place(
            trees[variants[tree]][0],
            positions[tree],
            turns[tree],
            scales[tree],
            vertices[start : start + tree_size],
        )
        first = 2 * cells**2 + tree * len(tree_faces)
        np.add(tree_faces, np.int32(start), out=faces[first : first + len(tree_faces)])
    return vertices, faces


def views(vertices: Floats) -> tuple[View, ...]:
    """From above, from the trail at eye height, and up into the crowns."""
    half = float(vertices[:, 0].max())
    low = float(vertices[:, 2].min())

    def on_trail(y: float, above: float) -> tuple[float, float, float]:
        x = float(_trail(np.array(y)))
        nearest = (
            np.abs(vertices[:, :2] - np.array([x, y])).sum(axis=1) + np.abs(vertices[:, 2] - low) * 1e-3
        ).argmin()
        return (x, y, float(vertices[nearest, 2]) + above)

    return (
        View(
            (-1.2 * half, -1.6 * half, low + 1.1 * half + 6.0),
            (0.0, 0.0, low + 3.0),
            fov_degrees=40.0,
            name="overview",
        ),
        View(on_trail(-0.85 * half, 1.9), on_trail(0.2 * half, 3.0), fov_degrees=60.0, name="trail"),
        View(on_trail(-0.2 * half, 1.2), on_trail(0.1 * half, 9.0), fov_degrees=75.0, name="crowns"),
    )


def _trail(y: Floats) -> Floats:
    return np.float32(3.0) * np.sin(y / np.float32(14.0))


def _height(x: Floats, y: Floats, seed: int) -> Floats:
    scale = np.float32(1.0 / 25.0)
    return np.float32(3.0) * terrain.heights(x * scale, y * scale, seed, octaves=5)


def _ground(half_size: float, cells: int, seed: int) -> Floats:
    line = np.linspace(-half_size, half_size, cells + 1, dtype=np.float32)
    x, y = np.meshgrid(line, line, indexing="xy")
    return np.stack([x, y, _height(x, y, seed)], axis=-1).reshape(-1, 3)


def _positions(generator: np.random.Generator, count: int, half_size: float, seed: int) -> Floats:
    """One tree a cell of a jittered grid, moved off the trail, its foot a little in the ground."""
    side = int(np.ceil(np.sqrt(count)))
    cell = generator.permutation(side * side)[:count]
    grid = np.stack([cell % side, cell // side], axis=-1) + 0.1 + 0.8 * generator.random((count, 2))
    x, y = ((2.0 * grid / side - 1.0) * half_size).astype(np.float32).T
    aside = x - _trail(y)
    x = _trail(y) + np.where(aside < 0, -1, 1) * np.maximum(np.abs(aside), np.float32(_TRAIL_HALF_WIDTH))
    x = x.astype(np.float32)
    return np.stack([x, y, _height(x, y, seed) - np.float32(0.2)], axis=-1)


def _place(tree: Floats, position: Floats, turn: float, scale: float, out: Floats) -> None:
    cosine, sine = np.float32(np.cos(turn) * scale), np.float32(np.sin(turn) * scale)
    out[:, 0] = cosine * tree[:, 0] - sine * tree[:, 1] + position[0]
    out[:, 1] = sine * tree[:, 0] + cosine * tree[:, 1] + position[1]
    out[:, 2] = np.float32(scale) * tree[:, 2] + position[2]


def _tree(generator: np.random.Generator, triangles: int, conifer: bool) -> Part:
    """A tree at the origin: a trunk, branches of 12 triangles, and leaves for all that is left."""
    knots, sides = (7, 8) if triangles > 1000 else (3, 4)
    branch_count = int(np.clip(triangles // 60, 4, 400))
    leaf_count = (triangles - 2 * sides * (knots - 1) - 12 * branch_count) // 2
    grow: Callable[[np.random.Generator, int], Floats] = _conifer_branches if conifer else _broadleaf_branches
    height = 12.0 if conifer else 8.0
    line = np.linspace(0.0, 1.0, knots, dtype=np.float32)
    trunk = np.stack([0.15 * np.sin(3.0 * line), 0.1 * np.sin(5.0 * line), height * line], axis=-1).astype(
        np.float32
    )
    branches = grow(generator, branch_count)
    crown_area = 220.0 if conifer else 260.0
    parts = [
        tubes(trunk[None], np.linspace(0.32, 0.03, knots), sides),
        tubes(branches, np.array([0.07, 0.045, 0.012]) * min(1.0, 3.0 / np.sqrt(branch_count) + 0.4), 3),
        _leaves(generator, branches, leaf_count, np.sqrt(crown_area / leaf_count), 0.5 if conifer else 1.0),
    ]
    sizes = np.cumsum([0] + [len(vertices) for vertices, _ in parts]).astype(np.int32)
    faces = np.concatenate([faces + start for (_, faces), start in zip(parts, sizes[:-1], strict=True)])
    return np.concatenate([vertices for vertices, _ in parts]), faces


def _conifer_branches(generator: np.random.Generator, count: int) -> Floats:
    """Branches (count, 3 knots, 3) all the way up, shorter towards the top and hanging at their ends."""
    share = (np.arange(count) + generator.random(count)) / count
    height = 1.6 + 10.1 * share
    length = 0.35 + 2.9 * (1.0 - share) ** 0.9 * (0.75 + 0.5 * generator.random(count))
    turn = np.arange(count) * 2.39996 + 0.4 * generator.random(count)  # the golden angle spreads them
    return _arcs(height, length, turn, rise=np.full(count, -0.1), droop=np.full(count, -0.35))


def _broadleaf_branches(generator: np.random.Generator, count: int) -> Floats:
    """Branches that rise and spread until they reach the surface of a round crown."""
    share = (np.arange(count) + generator.random(count)) / count
    height = 2.4 + 5.2 * share
    length = (1.0 + 3.0 * np.sqrt(np.sin(np.pi * (0.15 + 0.8 * share)))) * (
        0.55 + 0.45 * generator.random(count)
    )
    turn = np.arange(count) * 2.39996 + 0.6 * generator.random(count)
    return _arcs(height, length, turn, rise=0.25 + 0.7 * share, droop=0.15 * np.ones(count))


def _arcs(height: Floats, length: Floats, turn: Floats, rise: Floats, droop: Floats) -> Floats:
    reach = np.array([0.0, 0.5, 1.0])
    out = np.stack([np.cos(turn), np.sin(turn)], axis=-1)[:, None] * (length[:, None] * reach)[..., None]
    up = height[:, None] + length[:, None] * (rise[:, None] * reach + droop[:, None] * reach**2)
    return np.concatenate([out, up[..., None]], axis=-1).astype(np.float32)


def _leaves(generator: np.random.Generator, branches: Floats, count: int, size: float, spread: float) -> Part:
    """Leaves around the outer halves of the branches, pointing outwards and facing mostly up."""
    branch = generator.integers(0, len(branches), count)
    along = np.sqrt(generator.random((count, 1), dtype=np.float32)) * np.float32(1.05)
    root, tip = branches[branch, 0], branches[branch, 2]
    bend = branches[branch, 1] - np.float32(0.5) * (root + tip)
    jitter = sphere_directions(generator, count)
    jitter *= (
        np.float32(0.55 * spread)
        * (np.float32(0.25) + along)
        * np.cbrt(generator.random((count, 1), dtype=np.float32))
    )
    positions = root + along * (tip - root) + np.float32(4.0) * along * (1 - along) * bend + jitter
    ahead = unit(unit(tip - root) + np.float32(0.9) * sphere_directions(generator, count))
    normal = sphere_directions(generator, count)
    normal[:, 2] = np.abs(normal[:, 2]) + np.float32(0.5)
    aside = unit(np.cross(normal, ahead))
    normal = np.cross(ahead, aside)
    scale = np.float32(size) * (
        np.float32(0.7) + np.float32(0.6) * generator.random((count, 1), dtype=np.float32)
    )
    frames = np.stack([ahead, aside, normal], axis=1) * scale[..., None]
    vertices = positions[:, None] + sum(
        _LEAF[None, :, axis, None] * frames[:, None, axis] for axis in range(3)
    )
    return vertices.reshape(-1, 3).astype(np.float32), repeat_faces(_LEAF_FACES, count, 4)
