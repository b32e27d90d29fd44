"""All hits of rays in device memory, or sent there. Runs on a GPU, or on the emulated device."""

import numpy as np
import pytest
from device_arrays import build, on_device

import treelet
from treelet import _host_blocks, cuda

pytestmark = pytest.mark.skipif(not cuda.is_available(), reason="no CUDA device")

RECIPES = ["lbvh > bvh2", "lbvh > bvh8", "presplit(budget=80) > lbvh > cwbvh"]


def fetch(hits):
    return [values.numpy() if isinstance(values, cuda.Array) else values for values in hits]


def assert_same(ours, expected):
    assert type(ours) is type(expected)
    for values, others in zip(fetch(ours), expected, strict=True):
        assert (values.dtype, values.shape) == (others.dtype, others.shape)
        np.testing.assert_array_equal(values, others)


@pytest.mark.parametrize("recipe", RECIPES)
def test_hits_are_those_of_the_cpu(soup, rays, recipe):
    bvh, host = build(soup, recipe), treelet.build(*soup, recipe)
    device_rays = [on_device(part) for part in rays]
    assert len(host.intersect_all(*rays).t) > 500
    for reorder in (False, True):
        assert_same(bvh.intersect_all(*device_rays, reorder=reorder), host.intersect_all(*rays))
        counts = bvh.count_hits(*device_rays, reorder=reorder).numpy()
        np.testing.assert_array_equal(counts, host.count_hits(*rays))
        assert counts.dtype == np.int64
    for limit in (1, 2, 10**12):
        assert_same(bvh.intersect_all(*device_rays, limit=limit), host.intersect_all(*rays, limit=limit))


def test_shapes_and_limits_are_those_of_the_cpu(soup, rays):
    bvh, host = build(soup), treelet.build(*soup)
    origins, directions = rays[0].reshape(10, 50, 3), rays[1].reshape(10, 50, 3)
    t_max = np.linspace(0, 1, 500, dtype=np.float32).reshape(10, 50)
    given = on_device(origins), on_device(directions)
    assert_same(
        bvh.intersect_all(*given, -0.5, on_device(t_max)),
        host.intersect_all(origins, directions, -0.5, t_max),
    )
    counts = bvh.count_hits(*given, -0.5, on_device(t_max))
    np.testing.assert_array_equal(counts.numpy(), host.count_hits(origins, directions, -0.5, t_max))
    one = bvh.count_hits(on_device(origins[0, 0]), on_device(directions[0, 0]))
    assert one.shape == ()


def test_no_rays_and_no_mesh_have_no_hits(soup, rays):
    none = np.empty((0, 3), np.float32)
    bvh, empty = build(soup), build((none, none.astype(np.uint32)))
    assert_same(
        bvh.intersect_all(on_device(none), on_device(none)), treelet.build(*soup).intersect_all(none, none)
    )
    assert bvh.count_hits(on_device(none), on_device(none)).shape == (0,)
    assert_same(bvh.intersect_all(none, none), treelet.build(*soup).intersect_all(none, none))
    hits = empty.intersect_all(*map(on_device, rays))
    assert hits.offsets.numpy().tolist() == [0] * 501
    assert hits.t.shape == (0,)


def test_bad_rays_have_no_hits(soup, rays):
    origins, directions = (part[:4].copy() for part in rays)
    origins[0, 1], directions[1] = np.nan, 0
    t_min = np.array([0, 0, np.nan, 0], np.float32)
    counts = build(soup).count_hits(*map(on_device, (origins, directions, t_min))).numpy()
    assert counts[:3].tolist() == [0, 0, 0]
    assert counts[3] == treelet.build(*soup).count_hits(origins[3], directions[3])


@pytest.mark.parametrize("block", [2**28, 4000, 100], ids=["one block", "some blocks", "a ray a block"])
def test_rays_of_the_host_are_answered_in_numpy_arrays(soup, rays, monkeypatch, block):
    monkeypatch.setattr(_host_blocks, "STREAMED_BYTES", block)
    some = [part[:60] for part in rays]
    for recipe in ("lbvh > bvh8", "presplit(budget=80) > lbvh > bvh2"):
        bvh, host = build(soup, recipe), treelet.build(*soup, recipe)
        for arguments in (
            some,
            (some[0][0], some[1]),
            (some[0].reshape(6, 10, 3), some[1].reshape(6, 10, 3), -1),
        ):
            for limit in (None, 2):
                hits = bvh.intersect_all(*arguments, limit=limit)
                assert all(isinstance(values, np.ndarray) for values in hits)
                assert_same(hits, host.intersect_all(*arguments, limit=limit))
            np.testing.assert_array_equal(bvh.count_hits(*arguments), host.count_hits(*arguments))


def test_what_is_refused(soup, rays):
    bvh, device_rays = build(soup), [on_device(part) for part in rays]
    for limit, error in ((0, ValueError), (True, TypeError), (1.5, TypeError)):
        with pytest.raises(error, match="limit must be"):
            bvh.intersect_all(*device_rays, limit=limit)
    with pytest.raises(TypeError, match="stream is for arrays on a CUDA device"):
        bvh.intersect_all(*rays, stream=0)
    with pytest.raises(TypeError, match="stream is for arrays on a CUDA device"):
        bvh.count_hits(*rays, stream=0)
    with pytest.raises(TypeError, match="reorder must be True or False"):
        bvh.count_hits(*device_rays, reorder=1)
    far = treelet.build(soup[0] + np.array([5e5, 4e6, 0]), soup[1]).to("cuda")
    for query in (far.intersect_all, far.count_hits):
        with pytest.raises(ValueError, match=r"query bvh\.local"):
            query(*device_rays)
