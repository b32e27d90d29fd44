"""Arrays in device memory: in, out, and what is refused. Runs on a GPU, or on the emulated device."""

import numpy as np
import pytest
from sample_meshes import random_triangles

import treelet
from treelet import cuda

pytestmark = pytest.mark.skipif(not cuda.is_available(), reason="no CUDA device")


@pytest.fixture(scope="module")
def soup():
    return random_triangles(2000, seed=3)


@pytest.fixture(scope="module")
def rays():
    random = np.random.default_rng(5)
    origins = random.uniform(-1, 2, (500, 3)).astype(np.float32)
    return origins, (random.uniform(0, 1, (500, 3)) - origins).astype(np.float32)


def on_device(values, dtype=None):
    return cuda.copy_to_device(values, dtype)


def build(soup, recipe="lbvh > treelet > bvh2", **options):
    vertices, faces = soup
    return treelet.build(on_device(vertices), on_device(faces, "uint32"), recipe, **options)


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
    assert abs(work.triangles.numpy().sum() / expected.triangles.sum() - 1) < 0.01


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
    with pytest.raises(ValueError, match="'cpu' or 'cuda'"):
        device.to("gpu")


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


class Strided:
    """What a slice of another library's array says of itself."""

    def __init__(self, array):
        self._array = array

    @property
    def __cuda_array_interface__(self):
        return self._array.__cuda_array_interface__ | {"strides": (24, 4), "shape": (3, 3)}


def test_what_is_refused(soup, rays):
    vertices, faces = soup
    bvh = build(soup)
    origins, directions = map(on_device, rays)
    with pytest.raises(TypeError, match=r"origins must lie on a CUDA device.*bvh\.to\('cpu'\)"):
        bvh.intersect(rays[0], directions)
    with pytest.raises(TypeError, match="faces must lie on a CUDA device"):
        treelet.build(on_device(vertices), faces)
    with pytest.raises(TypeError, match="vertices must be float32"):
        treelet.build(on_device(vertices, "float64"), on_device(faces, "uint32"))
    with pytest.raises(TypeError, match="faces must hold integers"):
        treelet.build(on_device(vertices), on_device(faces, "float32"))
    with pytest.raises(ValueError, match=r"shape \(F, 3\)"):
        treelet.build(on_device(vertices), on_device(faces[:, :2].copy(), "uint32"))
    with pytest.raises(ValueError, match="C-contiguous"):
        bvh.intersect(Strided(origins), directions)
    with pytest.raises(ValueError, match="one row for all 500 rays"):
        bvh.intersect(on_device(rays[0][:7]), directions)
    with pytest.raises(RuntimeError, match="'sweep' runs on the CPU alone"):
        build(soup, "sweep > bvh2")


def test_an_empty_mesh_is_missed_by_every_ray(rays):
    empty = np.empty((0, 3), np.float32), np.empty((0, 3), np.uint32)
    bvh = treelet.build(on_device(empty[0]), on_device(empty[1]), "lbvh > bvh2")
    assert not bvh.occluded(*map(on_device, rays)).numpy().any()


def test_outputs_speak_dlpack(soup, rays):
    t = build(soup).intersect(*map(on_device, rays)).t
    assert t.__dlpack_device__()[0] == 2  # CUDA
    assert "dltensor" in repr(t.__dlpack__())
    assert t.__cuda_array_interface__["shape"] == (500,)


def test_any_stream_object(soup):
    class Stream:
        def __cuda_stream__(self):
            return (0, 0)

    bvh = build(soup)
    origin, direction = on_device(np.zeros((1, 3), np.float32)), on_device(np.ones((1, 3), np.float32))
    expected = bvh.intersect(origin, direction).t.numpy()
    for stream in (0, 1, Stream()):
        np.testing.assert_array_equal(bvh.intersect(origin, direction, stream=stream).t.numpy(), expected)
    with pytest.raises(TypeError, match="stream must be"):
        bvh.intersect(origin, direction, stream="fast")
