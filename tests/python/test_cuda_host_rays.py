"""Rays in numpy arrays, answered on a device chunk by chunk. Runs on a GPU, or on the emulated device."""

import numpy as np
import pytest
from device_arrays import build, on_device

import treelet
from treelet import _device_queries, cuda

pytestmark = pytest.mark.skipif(not cuda.is_available(), reason="no CUDA device")


@pytest.fixture(params=[2**28, 20_000, 1000], ids=["one chunk", "some chunks", "many chunks"])
def streamed_bytes(request, monkeypatch):
    monkeypatch.setattr(_device_queries, "_STREAMED_BYTES", request.param)


def assert_same(ours, expected):
    assert type(ours) is type(expected)
    for values, others in zip(ours, expected, strict=True):
        assert isinstance(values, np.ndarray)
        assert (values.dtype, values.shape) == (others.dtype, others.shape)
        np.testing.assert_array_equal(values, others)


@pytest.mark.parametrize("reorder", [False, True])
@pytest.mark.usefixtures("streamed_bytes")
def test_answers_are_those_of_the_cpu(soup, rays, reorder):
    bvh, host = build(soup), treelet.build(*soup)
    assert_same(bvh.intersect(*rays, reorder=reorder), host.intersect(*rays))
    assert_same([bvh.occluded(*rays, reorder=reorder)], [host.occluded(*rays)])
    work, device_work = bvh.traversal_cost(*rays, reorder=reorder), bvh.traversal_cost(*map(on_device, rays))
    for counts, expected in zip(work, device_work, strict=True):
        assert counts.dtype == np.uint32
        np.testing.assert_array_equal(counts, expected.numpy())


@pytest.mark.usefixtures("streamed_bytes")
def test_shapes_and_limits_are_those_of_the_host(soup, rays):
    bvh, host = build(soup), treelet.build(*soup)
    origins, directions = rays
    t_max = np.linspace(0, 1, 500, dtype=np.float32)
    for arguments in (
        (origins[0], directions),
        (origins.reshape(10, 50, 3), directions.reshape(10, 50, 3), 0.25),
        (origins, directions, 0, t_max),
        (origins[:10, None], directions[None, :20], -1.0, 1e300),
        (origins.astype(np.float64), directions.tolist()),
        (origins[::2], directions[::2]),
        (origins[0], directions[0]),
        (np.empty((0, 3)), directions[:1]),
    ):
        assert_same(bvh.intersect(*arguments), host.intersect(*arguments))
        assert bvh.occluded(*arguments).shape == host.occluded(*arguments).shape


def test_memory_mapped_files(soup, rays, tmp_path, monkeypatch):
    monkeypatch.setattr(_device_queries, "_STREAMED_BYTES", 10_000)
    mapped = []
    for name, part in zip(("origins", "directions"), rays, strict=True):
        np.save(tmp_path / name, part)
        mapped.append(np.load(tmp_path / f"{name}.npy", mmap_mode="r"))
    assert_same(build(soup).intersect(*mapped), treelet.build(*soup).intersect(*rays))


def test_moved_trees(soup, rays):
    host = treelet.build(*soup, "sweep > bvh8")
    assert_same(host.to("cuda").intersect(*rays), host.intersect(*rays))
    bvh, moved = build(soup, updatable=True), soup[0] + np.float32(0.25)
    bvh.rebuild(on_device(moved))
    assert_same(bvh.intersect(*rays), treelet.build(moved, soup[1]).intersect(*rays))


def test_what_is_refused(soup, rays):
    bvh = build(soup)
    origins, directions = map(on_device, rays)
    limit = on_device(np.ones(500, np.float32))
    with pytest.raises(TypeError, match="directions lies on a CUDA device and the origins on the host"):
        bvh.intersect(rays[0], directions)
    with pytest.raises(TypeError, match="t_max lies on a CUDA device and the origins on the host"):
        bvh.occluded(*rays, t_max=limit)
    with pytest.raises(TypeError, match=r"directions must lie on a CUDA device.*or the origins to the host"):
        bvh.occluded(origins, rays[1])
    with pytest.raises(TypeError, match="t_max must be a number, or an array on the CUDA device"):
        bvh.traversal_cost(origins, directions, t_max=np.ones(500, np.float32))
    with pytest.raises(
        TypeError, match="stream is for arrays on a CUDA device, and the rays lie on the host"
    ):
        bvh.intersect(*rays, stream=0)
    with pytest.raises(ValueError, match=r"origins \(7, 3\), directions \(500, 3\).* cannot be broadcast"):
        bvh.intersect(rays[0][:7], rays[1])
    with pytest.raises(TypeError, match="origins must hold real numbers"):
        bvh.intersect("here", rays[1])
