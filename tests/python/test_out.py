"""Answers in arrays of the caller."""

from __future__ import annotations

import numpy as np
import pytest
from sample_meshes import torus

import treelet

RNG = np.random.default_rng(3)
ORIGINS = RNG.uniform(-2, 2, (20, 30, 3))
DIRECTIONS = RNG.uniform(-1, 1, (20, 30, 3))
SHAPE = (20, 30)


@pytest.fixture(scope="module")
def bvh():
    return treelet.build(*torus(30, 20))


@pytest.fixture(scope="module")
def far():
    """A tree with an offset, whose nearest points are float64."""
    vertices, faces = torus(30, 20)
    return treelet.build(vertices + np.array([4e6, 5e5, 0]), faces)


def scribbled(answers):
    """Arrays as the answers' own, full of something else."""
    return type(answers)(*(np.full_like(part, 99) for part in answers))


def test_hits_are_written_to_given_arrays(bvh):
    expected = bvh.intersect(ORIGINS, DIRECTIONS)
    out = scribbled(expected)
    assert bvh.intersect(ORIGINS, DIRECTIONS, out=out) is out
    for part, known in zip(out, expected, strict=True):
        np.testing.assert_array_equal(part, known)
    arrays = tuple(scribbled(expected))
    assert bvh.intersect(ORIGINS, DIRECTIONS, reorder=True, out=arrays) is arrays
    np.testing.assert_array_equal(arrays[1], expected.face)


QUERIES = {
    "occluded": lambda bvh, **out: bvh.occluded(ORIGINS, DIRECTIONS, **out),
    "count_hits": lambda bvh, **out: bvh.count_hits(ORIGINS, DIRECTIONS, **out),
    "distance": lambda bvh, **out: bvh.distance(ORIGINS, **out),
    "signed_distance": lambda bvh, **out: bvh.signed_distance(ORIGINS, **out),
    "contains": lambda bvh, **out: bvh.contains(ORIGINS, **out),
    "winding_number": lambda bvh, **out: bvh.winding_number(ORIGINS, **out),
}


@pytest.mark.parametrize("query", QUERIES)
def test_answers_are_written_to_a_given_array(bvh, query):
    expected = QUERIES[query](bvh)
    out = ~expected if expected.dtype == bool else expected + 1
    assert QUERIES[query](bvh, out=out) is out
    np.testing.assert_array_equal(out, expected)


@pytest.mark.parametrize("tree", ["bvh", "far"])
def test_nearest_points_are_written_to_given_arrays(tree, request):
    bvh = request.getfixturevalue(tree)
    points = ORIGINS + bvh.offset
    expected = bvh.closest_point(points)
    out = scribbled(expected)
    assert bvh.closest_point(points, out=out) is out
    for part, known in zip(out, expected, strict=True):
        np.testing.assert_array_equal(part, known)


def test_tensors_on_the_cpu_will_do(bvh):
    torch = pytest.importorskip("torch")
    expected = bvh.distance(ORIGINS)
    out = torch.zeros(SHAPE)
    assert bvh.distance(ORIGINS, out=out) is out
    np.testing.assert_array_equal(out.numpy(), expected)


def test_arrays_that_do_not_fit_are_refused(bvh):
    def occluded(out):
        return bvh.occluded(ORIGINS, DIRECTIONS, out=out)

    with pytest.raises(TypeError, match="out must hold bool, not uint8"):
        occluded(np.empty(SHAPE, np.uint8))
    with pytest.raises(ValueError, match=r"out must have shape \(20, 30\), not \(600,\)"):
        occluded(np.empty(600, bool))
    with pytest.raises(ValueError, match="out must be contiguous in C order"):
        occluded(np.empty(SHAPE[::-1], bool).T)
    frozen = np.empty(SHAPE, bool)
    frozen.flags.writeable = False
    with pytest.raises(ValueError, match="out must be aligned and writeable"):
        occluded(frozen)
    with pytest.raises(TypeError, match="out must be a numpy array or a tensor"):
        occluded([[False] * 30] * 20)


def test_answers_of_several_arrays_name_the_one_that_does_not_fit(bvh):
    good = bvh.intersect(ORIGINS, DIRECTIONS)
    with pytest.raises(TypeError, match=r"out.face must hold int32, not int64"):
        bvh.intersect(ORIGINS, DIRECTIONS, out=good._replace(face=good.face.astype(np.int64)))
    with pytest.raises(TypeError, match=r"out must be 4 arrays \(t, face, u, v\)"):
        bvh.intersect(ORIGINS, DIRECTIONS, out=good.t)
    with pytest.raises(TypeError, match="one of them is None"):
        bvh.intersect(ORIGINS, DIRECTIONS, out=good._replace(u=None))
    with pytest.raises(TypeError, match=r"out must be 5 arrays \(point, distance, face, u, v\)"):
        bvh.closest_point(ORIGINS, out=good)
