"""Trees with an offset on a device. Runs on a GPU, or on the emulated device."""

import pickle

import numpy as np
import pytest
from device_arrays import on_device

import treelet
from treelet import cuda

pytestmark = pytest.mark.skipif(not cuda.is_available(), reason="no CUDA device")

FAR = np.array([450_000.3, 5_400_000.7, 100.1])


@pytest.fixture
def host(soup):
    vertices, faces = soup
    return treelet.build(vertices + FAR, faces, "lbvh > treelet > bvh2")


@pytest.fixture
def far_rays(rays):
    origins, directions = rays
    return origins + FAR, directions


def assert_same(ours, expected):
    for values, others in zip(ours, expected, strict=True):
        np.testing.assert_array_equal(values, others)


def test_rays_of_the_host_are_in_the_mesh_s_coordinates(host, far_rays):
    device = host.to("cuda")
    assert (host.intersect(*far_rays).face >= 0).sum() > 100
    assert_same(device.intersect(*far_rays), host.intersect(*far_rays))
    np.testing.assert_array_equal(device.occluded(*far_rays), host.occluded(*far_rays))
    np.testing.assert_array_equal(device.bounds, host.bounds)
    np.testing.assert_array_equal(device.offset, host.offset)
    assert any(device.offset)
    assert device.report.vertex_rounding == host.report.vertex_rounding


def test_rays_on_the_device_are_local(host, far_rays):
    device = host.to("cuda")
    origins, directions = far_rays
    with pytest.raises(ValueError, match=r"query bvh.local, with float32\(origins - bvh.offset\)"):
        device.intersect(on_device(origins, "float32"), on_device(directions))
    local = on_device(origins - device.offset, "float32")
    hits = device.local.intersect(local, on_device(directions))
    assert_same([array.numpy() for array in hits], host.intersect(*far_rays))
    np.testing.assert_array_equal(device.local.offset, 0)


def test_a_tree_keeps_its_offset_there_and_back(host, far_rays, tmp_path):
    back = host.to("cuda").to("cpu")
    assert_same(back.intersect(*far_rays), host.intersect(*far_rays))
    np.testing.assert_array_equal(back.offset, host.offset)
    back.save(tmp_path / "a.treelet")
    loaded = treelet.load(tmp_path / "a.treelet")
    assert_same(loaded.to("cuda").intersect(*far_rays), host.intersect(*far_rays))
    assert loaded.mesh_hash == host.mesh_hash
    assert loaded.to("cuda").validate(None, None) == []


def test_trees_on_devices_are_not_pickled(host):
    with pytest.raises(TypeError, match=r"move it with bvh.to\('cpu'\) first"):
        pickle.dumps(host.to("cuda"))
