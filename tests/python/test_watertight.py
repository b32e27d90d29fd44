"""No ray slips through a closed surface: not at a vertex, not at an edge, not from far away.

Vertices are snapped to a grid and rays start between its lines, so that a direction in float32 aims at a
vertex, at the middle of an edge or into a triangle exactly, and no ray lies in a triangle's plane by design.
"""

from functools import cache

import numpy as np
import pytest
from sample_meshes import torus

import treelet
from treelet import scenes

CELL = 2.0**-12  # where meshes are scaled to [-1, 1]
RAYS = 100_000
ORIGINS = 60
MESHES = ["sphere", "menger", "city", "torus"]
RECIPES = ["fast", "balanced"]
# Weights of a triangle's vertices; the points they give are exact on a grid of CELL / 4.
TARGETS = {"vertices": (1, 0, 0), "edges": (0.5, 0.5, 0), "insides": (0.5, 0.25, 0.25)}


@cache
def closed_mesh(name):
    """Vertices on the grid. Triangles that collapse there leave no hole: their neighbours close up."""
    mesh = treelet.Mesh(*torus(60, 24)) if name == "torus" else scenes.make(name, 3000)
    lower, upper = mesh.bounds.astype(np.float64)
    scaled = (mesh.vertices - (lower + upper) / 2) * (2 / (upper - lower).max())
    return (np.round(scaled / CELL) * CELL).astype(np.float32), mesh.faces


@cache
def tree(name, recipe):
    return treelet.build(*closed_mesh(name), recipe)


def winding_numbers(points, vertices, faces):
    """How often the surface surrounds each point (N, 3): its solid angle [VanOosteromStrackee1983]."""
    numbers = []
    for point in points:
        a, b, c = (vertices[faces].astype(np.float64) - point).swapaxes(0, 1)
        la, lb, lc = (np.linalg.norm(corner, axis=1) for corner in (a, b, c))
        volume = np.einsum("ni,ni->n", a, np.cross(b, c))
        dots = [np.einsum("ni,ni->n", p, q) for p, q in ((a, b), (b, c), (c, a))]
        angles = np.arctan2(volume, la * lb * lc + dots[0] * lc + dots[1] * la + dots[2] * lb)
        numbers.append(round(angles.sum() / (2 * np.pi)))
    return np.array(numbers)


@cache
def origins_of(name, where):
    """(ORIGINS, 3) float32 points inside or outside the mesh, between the lines of the grid."""
    rng = np.random.default_rng(21)
    found = np.empty((0, 3))
    while len(found) < ORIGINS:
        points = (np.round(rng.uniform(-1.2, 1.2, (100, 3)) / CELL) + 0.125) * CELL
        windings = winding_numbers(points, *closed_mesh(name))
        found = np.concatenate([found, points[windings > 0 if where == "inside" else windings == 0]])
    return found[:ORIGINS].astype(np.float32)


def rays_at(name, where, target):
    """Origins and directions (RAYS, 3) such that t = 1 is a target, exactly."""
    vertices, faces = closed_mesh(name)
    rng = np.random.default_rng(22)
    triangles = vertices[rng.choice(faces, RAYS)]
    weights = rng.permuted(np.tile(TARGETS[target], (RAYS, 1)), axis=1)
    targets = np.einsum("nk,nkx->nx", weights, triangles)
    origins = np.resize(origins_of(name, where), (RAYS, 3))
    directions = targets - origins
    assert (directions.astype(np.float32) == directions).all()
    return origins, directions.astype(np.float32)


@pytest.mark.parametrize("target", TARGETS)
@pytest.mark.parametrize("where", ["inside", "outside"])
@pytest.mark.parametrize("name", MESHES)
def test_rays_hit_what_they_are_aimed_at_or_something_nearer(name, where, target):
    origins, directions = rays_at(name, where, target)
    for recipe in RECIPES:
        hits = tree(name, recipe).intersect(origins, directions)
        assert (hits.face >= 0).all()
        assert (hits.t <= 1).all()
        assert (hits.t == 1).mean() > 0.005
        assert tree(name, recipe).occluded(origins[::4], directions[::4], t_max=1).all()


@pytest.mark.parametrize("target", TARGETS)
@pytest.mark.parametrize("name", MESHES)
def test_no_ray_leaves_the_inside(name, target):
    """Unit directions: rounding moves the ray a little beside what it was aimed at."""
    origins, directions = rays_at(name, "inside", target)
    unit = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    assert (tree(name, "balanced").intersect(origins, unit).face >= 0).all()


@pytest.mark.parametrize("distance", [10, 1000, 1e5])
@pytest.mark.parametrize("name", MESHES)
def test_rays_from_far_away_do_not_miss_the_inside(name, distance):
    """Through points so deep inside that rounding the origin and the direction leaves the ray inside."""
    rng = np.random.default_rng(23)
    bvh = tree(name, "balanced")
    directions = rng.standard_normal((1000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    depth = bvh.intersect(origins_of(name, "inside")[:, None], directions).t.min(axis=1)
    points = origins_of(name, "inside")[depth > 2**-22 * distance]
    assert len(points) >= 5
    far = points[:, None] - directions * distance
    assert (bvh.intersect(far, directions).face >= 0).all()
    assert bvh.occluded(far, directions).all()
