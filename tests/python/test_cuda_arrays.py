"""Trees over arrays in device memory: answers and updates. Runs on a GPU, or on the emulated device."""

import numpy as np
import pytest
from device_arrays import Foreign, build, on_device

import treelet
from treelet import cuda

pytestmark = pytest.mark.skipif(not cuda.is_available(), reason="no CUDA device")


@pytest.mark.parametrize("recipe", ["lbvh > treelet > bvh2", "fast", "balanced"])
def test_answers_are_those_of_the_cpu(soup, rays, recipe):
    bvh = build(soup, recipe)
    host = treelet.build(*soup, recipe)
    hits = bvh.intersect(*map(on_device, rays))
    for device_values, host_values in zip(hits, host.intersect(*rays), strict=True):
        np.testing.assert_array_equal(device_values.numpy(), host_values)
        assert device_values.dtype == host_values.dtype
    occluded = bvh.occluded(*map(on_device, rays)).numpy()
    np.testing.assert_array_equal(occluded, host.occluded(*rays))
    assert bvh.report.sah == host.report.sah
    assert bvh.report.epo == host.report.epo
    assert bvh.report.leaf_histogram == host.report.leaf_histogram
    assert bvh.validate() == []
    np.testing.assert_array_equal(bvh.bounds, host.bounds)


def test_leading_shapes_and_shared_rows(soup, rays):
    origins, directions = rays
    bvh, host = build(soup), treelet.build(*soup)
    hits = bvh.intersect(on_device(origins[0]), on_device(directions.reshape(10, 50, 3)))
    expected = host.intersect(origins[0], directions.reshape(10, 50, 3))
    assert hits.t.shape == (10, 50)
    np.testing.assert_array_equal(hits.face.numpy(), expected.face)


def test_limits_as_numbers_and_as_arrays(soup, rays):
    bvh, host = build(soup), treelet.build(*soup)
    device_rays = [on_device(part) for part in rays]
    t_max = np.linspace(0, 1, 500, dtype=np.float32)
    hits = bvh.intersect(*device_rays, t_min=0.25, t_max=on_device(t_max))
    np.testing.assert_array_equal(hits.t.numpy(), host.intersect(*rays, t_min=0.25, t_max=t_max).t)
    empty = bvh.intersect(*device_rays, t_min=2.0, t_max=1.0)
    assert not np.isfinite(empty.t.numpy()).any()


def test_work_is_counted(soup, rays):
    work = build(soup).traversal_cost(*map(on_device, rays))
    expected = treelet.build(*soup, "lbvh > treelet > bvh2").traversal_cost(*rays)
    assert abs(work.nodes.numpy().sum() / expected.nodes.sum() - 1) < 0.01
    assert abs(work.triangles.numpy().sum() / expected.triangles.sum() - 1) < 0.02  # other leaves come first


def test_reordered_rays_have_the_same_answers(soup, rays):
    bvh, device_rays = build(soup), [on_device(part) for part in rays]
    for query in (bvh.intersect, bvh.traversal_cost):
        for given, reordered in zip(query(*device_rays), query(*device_rays, reorder=True), strict=True):
            np.testing.assert_array_equal(reordered.numpy(), given.numpy())
    occluded = bvh.occluded(*device_rays, reorder=True)
    np.testing.assert_array_equal(occluded.numpy(), bvh.occluded(*device_rays).numpy())


def test_answers_outlive_each_other_and_the_tree(soup, rays):
    face = build(soup).intersect(*map(on_device, rays)).face
    on_device(np.zeros(4000, np.float32))  # takes memory that was given back
    np.testing.assert_array_equal(face.numpy(), treelet.build(*soup).intersect(*rays).face)
    face.numpy()[:] = 0  # a copy, to be written to


def test_answers_begin_where_wide_loads_may(soup, rays):
    for count in (1, 7, 500):
        hits = build(soup).intersect(*(on_device(part[:count]) for part in rays))
        addresses = [values.__cuda_array_interface__["data"][0] for values in hits]
        assert all(address % 16 == 0 for address in addresses)
        assert np.diff(addresses).min() >= 4 * count


def test_faces_of_64_bits(soup):
    vertices, faces = soup
    narrow = build(soup).report
    wide = treelet.build(on_device(vertices), on_device(faces, "int64"), "lbvh > treelet > bvh2").report
    assert wide.sah == narrow.sah


@pytest.mark.parametrize("dtype", ["int32", "int64"])
def test_bad_indices_are_named(soup, dtype):
    vertices, faces = soup
    for bad in (-1, len(vertices)):
        wrong = faces.astype(np.int64)
        wrong[7, 2] = bad
        with pytest.raises(ValueError, match="face 7 refers to vertex"):
            treelet.build(on_device(vertices), on_device(wrong, dtype), "lbvh > bvh2")


def test_there_and_back(soup, rays):
    host = treelet.build(*soup, "sweep > bvh8")
    device = host.to("cuda")
    np.testing.assert_array_equal(device.intersect(*map(on_device, rays)).t.numpy(), host.intersect(*rays).t)
    back = device.to("cpu")
    np.testing.assert_array_equal(back.intersect(*rays).t, host.intersect(*rays).t)
    assert back.report.recipe == host.report.recipe
    assert device.to("cuda") is device
    for tree in (host, device):
        assert tree.to("cuda:0").device == "cuda:0"
        for name in ("gpu", "cuda:", "cuda:x", None):
            with pytest.raises(ValueError, match="'cpu' or 'cuda'"):
                tree.to(name)
        with pytest.raises(ValueError, match="not 'cuda:7'"):
            tree.to("cuda:7")


def test_moved_trees_cannot_be_updated(soup):
    host = treelet.build(*soup, updatable=True).to("cuda")
    device = build(soup, updatable=True).to("cpu")
    for update in (host.refit, host.rebuild, device.refit, device.rebuild):
        with pytest.raises(RuntimeError, match="a moved tree cannot be updated"):
            update(soup[0])


def test_rebuild_and_refit_follow_the_mesh(soup, rays):
    vertices, faces = soup
    moved = vertices + np.float32(0.2) * np.sin(7 * vertices[:, ::-1])
    bvh = build(soup, updatable=True)
    expected = treelet.build(moved, faces).intersect(*rays)
    device_rays = [on_device(part) for part in rays]
    bvh.refit(on_device(moved))
    np.testing.assert_array_equal(bvh.intersect(*device_rays).t.numpy(), expected.t)
    bvh.rebuild(on_device(vertices))
    bvh.rebuild(on_device(moved))
    bvh.check()
    np.testing.assert_array_equal(bvh.intersect(*device_rays).t.numpy(), expected.t)
    assert bvh.report.sah == treelet.build(moved, faces, "lbvh > treelet > bvh2").report.sah


def test_only_updatable_trees_are_updated(soup):
    bvh = build(soup)
    with pytest.raises(RuntimeError, match="updatable=True"):
        bvh.refit(on_device(soup[0]))
    with pytest.raises(ValueError, match="vertices"):
        build(soup, updatable=True).rebuild(on_device(soup[0][:-1]))


def test_what_is_refused(soup, rays):
    vertices, faces = soup
    bvh = build(soup)
    origins, directions = map(on_device, rays)
    with pytest.raises(TypeError, match=r"directions must lie on a CUDA device.*or the origins to the host"):
        bvh.intersect(origins, rays[1])
    with pytest.raises(TypeError, match="faces must lie on a CUDA device"):
        treelet.build(on_device(vertices), faces)
    with pytest.raises(TypeError, match="vertices must be float32"):
        treelet.build(on_device(vertices, "float64"), on_device(faces, "uint32"))
    with pytest.raises(TypeError, match="faces must hold integers"):
        treelet.build(on_device(vertices), on_device(faces, "float32"))
    with pytest.raises(ValueError, match=r"shape \(F, 3\)"):
        treelet.build(on_device(vertices), on_device(faces[:, :2].copy(), "uint32"))
    with pytest.raises(ValueError, match="C-contiguous"):
        bvh.intersect(Foreign(origins, strides=(24, 4), shape=(3, 3)), directions)
    with pytest.raises(ValueError, match=r"origins \(7, 3\), directions \(500, 3\).* cannot be broadcast"):
        bvh.intersect(on_device(rays[0][:7]), directions)
    with pytest.raises(RuntimeError, match="'sweep' runs on the CPU alone"):
        build(soup, "sweep > bvh2")


def test_an_empty_mesh_is_missed_by_every_ray(rays):
    empty = np.empty((0, 3), np.float32), np.empty((0, 3), np.uint32)
    bvh = treelet.build(on_device(empty[0]), on_device(empty[1]), "lbvh > bvh2")
    assert not bvh.occluded(*map(on_device, rays)).numpy().any()
