"""Nearest points, inside and outside, of points in device memory. Runs on a GPU, or on the emulated one."""

import numpy as np
import pytest
from device_arrays import build, on_device

import treelet
from treelet import _host_blocks, cuda, scenes

pytestmark = pytest.mark.skipif(not cuda.is_available(), reason="no CUDA device")

RECIPES = ["lbvh > bvh2", "lbvh > bvh8", "presplit(budget=80) > lbvh > cwbvh"]
QUERIES = ("distance", "signed_distance", "contains")


@pytest.fixture(scope="module")
def sphere():
    """A closed mesh."""
    mesh = scenes.load("sphere", triangles=1000).rounded()
    return mesh.vertices, mesh.faces.astype(np.uint32)


@pytest.fixture(scope="module")
def points(sphere):
    """Inside of, around, far from and on the sphere, and two that are none."""
    random, size = np.random.default_rng(7), np.abs(sphere[0]).max()
    near, far = random.uniform(-1.5, 1.5, (200, 3)), random.uniform(-90, 90, (40, 3))
    bad = [[np.nan, 0, 0], [0, np.inf, 0]]
    return (np.concatenate([near, far, sphere[0][:60] / size, bad]) * size).astype(np.float32)


def assert_same(ours, expected):
    assert type(ours) is type(expected)
    for values, others in zip(ours, expected, strict=True):
        found = values.numpy() if isinstance(values, cuda.Array) else values
        assert (found.dtype, found.shape) == (others.dtype, others.shape)
        np.testing.assert_array_equal(found, others)


@pytest.mark.parametrize("recipe", RECIPES)
def test_answers_are_those_of_the_cpu(sphere, points, recipe):
    bvh, host = build(sphere, recipe), treelet.build(*sphere, recipe)
    given = on_device(points)
    assert 0 < host.contains(points).sum() < len(points)
    assert_same(bvh.closest_point(given), host.closest_point(points))
    for query in QUERIES:
        assert_same([getattr(bvh, query)(given)], [getattr(host, query)(points)])


def test_shapes_and_largest_distances_are_those_of_the_cpu(sphere, points):
    bvh, host = build(sphere), treelet.build(*sphere)
    some = points[:240].reshape(12, 20, 3)
    radii = np.linspace(-1, 30, 240, dtype=np.float32).reshape(12, 20)
    assert_same(bvh.closest_point(on_device(some), on_device(radii)), host.closest_point(some, radii))
    assert_same(bvh.closest_point(on_device(some), 0.25), host.closest_point(some, 0.25))
    assert_same(bvh.closest_point(on_device(some[0, 0])), host.closest_point(some[0, 0]))
    assert_same(
        bvh.closest_point(on_device(points[0]), on_device(radii)), host.closest_point(points[0], radii)
    )


def test_no_points_and_no_mesh(sphere, points):
    none = np.empty((0, 3), np.float32)
    bvh, empty = build(sphere), build((none, none.astype(np.uint32)))
    assert bvh.closest_point(on_device(none)).point.shape == (0, 3)
    assert bvh.contains(none).shape == (0,)
    assert_same(
        empty.closest_point(on_device(points)), treelet.build(none, none.astype(int)).closest_point(points)
    )
    assert not empty.contains(on_device(points)).numpy().any()


@pytest.mark.parametrize("block", [2**28, 2000], ids=["one block", "some blocks"])
def test_points_of_the_host_are_answered_in_numpy_arrays(sphere, points, monkeypatch, block):
    monkeypatch.setattr(_host_blocks, "STREAMED_BYTES", block)
    bvh, host = build(sphere), treelet.build(*sphere)
    radii = np.linspace(0, 30, len(points))
    assert_same(bvh.closest_point(points, radii), host.closest_point(points, radii))
    assert_same(bvh.closest_point(points[0].tolist(), radii), host.closest_point(points[0], radii))
    for query in QUERIES:
        assert_same([getattr(bvh, query)(points)], [getattr(host, query)(points)])


def test_trees_with_an_offset(sphere, points):
    offset = np.array([5e5, 4e6, 10.0])
    host = treelet.build(sphere[0] + offset, sphere[1])
    bvh, places = host.to("cuda"), points + offset
    assert_same(bvh.closest_point(places), host.closest_point(places))
    assert_same([bvh.signed_distance(places)], [host.signed_distance(places)])
    for query in ("closest_point", *QUERIES):
        with pytest.raises(ValueError, match=r"query bvh\.local"):
            getattr(bvh, query)(on_device(points))
    local = (places - bvh.offset).astype(np.float32)
    assert_same([bvh.local.distance(on_device(local))], [host.distance(places)])


def test_what_is_refused(sphere, points):
    bvh = build(sphere)
    with pytest.raises(TypeError, match="points must be float32 on the device"):
        bvh.contains(on_device(points, "float64"))
    with pytest.raises(ValueError, match=r"points must have shape \(\.\.\., 3\)"):
        bvh.distance(on_device(points[:, :2].copy()))
    with pytest.raises(TypeError, match="max_distance lies on a CUDA device and the points on the host"):
        bvh.closest_point(points, on_device(np.ones(len(points), np.float32)))
    with pytest.raises(
        TypeError, match="max_distance must be a number, or an array on the CUDA device as the points"
    ):
        bvh.closest_point(on_device(points), np.ones(len(points)))
    with pytest.raises(ValueError, match="cannot be broadcast"):
        bvh.closest_point(on_device(points), on_device(np.ones(7, np.float32)))
    with pytest.raises(TypeError, match="stream is for arrays on a CUDA device"):
        bvh.signed_distance(points, stream=0)


def test_queries_that_are_not_there_say_where_they_are(sphere):
    bvh = build(sphere)
    for query in ("stream_hits", "winding_number", "overlap_boxes", "overlap_spheres"):
        assert not hasattr(bvh, query)
        with pytest.raises(AttributeError, match=rf"on the CPU alone, bvh\.to\('cpu'\)\.{query}"):
            getattr(bvh, query)
        assert hasattr(bvh.to("cpu"), query)
    with pytest.raises(AttributeError, match=r"has no attribute 'nearest'$"):
        _ = bvh.nearest
