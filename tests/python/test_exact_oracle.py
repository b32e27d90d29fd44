"""The oracle itself, on triangles that a person can check."""

from fractions import Fraction

import numpy as np
import pytest
from exact_oracle import exact_hit, exact_hits, fault, kind_of_difference
from sample_meshes import TRIANGLE_VERTICES

DOWN = np.array([0, 0, -1], np.float32)
TINY = np.float32(2.0**-149)


@pytest.mark.parametrize(
    ("origin", "direction", "t"),
    [
        ((0.25, 0.25, 2), (0, 0, -1), Fraction(2)),
        ((0.25, 0.25, 2), (0, 0, -8), Fraction(1, 4)),
        ((0.25, 0.25, 2), (0, 0, 1), Fraction(-2)),
        ((0, 0, 1), (0, 0, -3), Fraction(1, 3)),  # a vertex
        ((0.5, 0.5, 1), (0, 0, -1), Fraction(1)),  # an edge
        ((TINY, TINY, 1), (0, 0, -1), Fraction(1)),
        ((-TINY, 0.5, 1), (0, 0, -1), None),
        ((0.5, np.nextafter(np.float32(0.5), np.float32(1)), 1), (0, 0, -1), None),
        ((-1, 0.25, 0), (1, 0, 0), None),  # edge-on
    ],
)
def test_exact_hit(origin, direction, t):
    ray = np.array([origin, direction], np.float32)
    for triangle in (TRIANGLE_VERTICES, TRIANGLE_VERTICES[::-1], np.roll(TRIANGLE_VERTICES, 1, axis=0)):
        assert exact_hit(ray[0], ray[1], triangle) == t


def test_exact_hits_leave_out_what_is_no_triangle():
    shifted = TRIANGLE_VERTICES - np.float32([0, 0, 1])
    not_finite = np.where(np.eye(3) > 0, np.float32(np.nan), TRIANGLE_VERTICES)
    degenerate = TRIANGLE_VERTICES[[0, 1, 1]]
    behind = TRIANGLE_VERTICES + np.float32([0, 0, 5])
    corners = np.stack([shifted, TRIANGLE_VERTICES, not_finite, degenerate, behind])
    hits = exact_hits(np.float32([0.25, 0.25, 1]), DOWN, corners, range(5))
    assert hits == {0: 2, 1: 1}


@pytest.mark.parametrize(
    ("t", "face", "exact", "what"),
    [
        (1.0, 3, {3: Fraction(1), 4: Fraction(1), 2: Fraction(2)}, None),
        (np.inf, -1, {}, None),
        (np.inf, -1, {7: Fraction(2), 5: Fraction(1)}, "missed face 5"),
        (1.0, 3, {4: Fraction(1)}, "does not meet face 3"),
        (1.5, 3, {3: Fraction(1)}, "t is 1.5, not 1.0"),
        (2.0, 3, {3: Fraction(2), 9: Fraction(1)}, "face 9 is nearer than face 3"),
        (1.0, 3, {3: Fraction(1), 1: Fraction(1)}, "face 1 is as near as face 3 and smaller"),
        (1.0, 3, {3: Fraction(1), 1: 1 - Fraction(2) ** -30}, None),
        (np.float32(1 / 3), 3, {3: Fraction(1, 3)}, None),
    ],
)
def test_fault(t, face, exact, what):
    assert fault(t, face, exact) == what


@pytest.mark.parametrize(
    ("other_face", "kind"), [(-1, "edge miss"), (5, "edge miss"), (4, "tie"), (8, "wrong face")]
)
def test_kind_of_difference(other_face, kind):
    assert kind_of_difference(3, other_face, {3: Fraction(1), 4: Fraction(1), 5: Fraction(2)}) == kind
