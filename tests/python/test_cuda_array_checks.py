"""What is checked of arrays in device memory before kernels read them, on a GPU or on the emulated device."""

from types import SimpleNamespace

import numpy as np
import pytest
from device_arrays import Foreign, build, on_device

import treelet
from treelet import cuda

pytestmark = pytest.mark.skipif(not cuda.is_available(), reason="no CUDA device")

SHAPES = [
    ((0, 3), (3,), ()),
    ((3,), (1, 3), ()),
    ((3,), (3,), (4,)),
    ((1, 3), (0, 3), (0,)),
    ((10, 5, 3), (1, 1, 3), (1,)),
    ((50, 3), (1, 50, 3), ()),
    ((2, 0, 3), (2, 0, 3), (1, 0)),
]


@pytest.mark.parametrize("shapes", SHAPES, ids=str)
def test_shapes_are_those_of_the_host(soup, rays, shapes):
    parts = [np.resize(part, shape) for part, shape in zip((*rays, np.float32(0.125)), shapes, strict=True)]
    hits = build(soup).intersect(*map(on_device, parts))
    expected = treelet.build(*soup).intersect(*parts)
    assert hits.t.shape == expected.t.shape
    np.testing.assert_array_equal(hits.t.numpy(), expected.t)


@pytest.mark.parametrize(
    ("shapes", "message"),
    [
        (((10, 5, 3), (50, 3)), r"origins \(10, 5, 3\), directions \(50, 3\).* cannot be broadcast"),
        (((10, 5, 3), (5, 3)), r"directions \(5, 3\) must have one row.*broadcast it on the device first"),
        (((5, 1, 3), (1, 5, 3)), r"origins \(5, 1, 3\) must have one row.*broadcast it on the device first"),
        (((5, 4), (5, 3)), r"origins must have shape \(\.\.\., 3\)"),
        (((), (5, 3)), r"origins must have shape \(\.\.\., 3\)"),
    ],
)
def test_shapes_that_are_refused(soup, shapes, message):
    with pytest.raises(ValueError, match=message):
        build(soup).intersect(*(on_device(np.zeros(shape, np.float32)) for shape in shapes))


NOT_VALID = [
    ({"shape": ...}, "it has no 'shape'"),
    ({"shape": None}, "NoneType"),
    ({"shape": (-1, 3)}, "negative"),
    ({"shape": ("1", 3)}, "str"),
    ({"typestr": ...}, "it has no 'typestr'"),
    ({"typestr": None}, "typestr must be text"),
    ({"typestr": "<x9"}, "<x9"),
    ({"data": ...}, "it has no 'data'"),
    ({"data": None}, "has no address"),
    ({"data": (None, False)}, "has no address"),
    ({"data": ()}, "range"),
    ({"data": ("0", False)}, "str"),
    ({"strides": (4,)}, "shorter"),
    ({"strides": 12}, "int"),
    ({"stream": "fast"}, "stream must be"),
]


@pytest.mark.parametrize(("changes", "reason"), NOT_VALID, ids=str)
def test_what_an_array_says_of_itself_is_checked(soup, rays, changes, reason):
    bvh, origins = build(soup), on_device(rays[0])
    with pytest.raises(ValueError, match=rf"origins: its __cuda_array_interface__ is not valid: .*{reason}"):
        bvh.occluded(Foreign(origins, **changes), origins)


def test_interface_that_is_none_is_not_valid(soup):
    with pytest.raises(ValueError, match="origins: its __cuda_array_interface__ is not valid"):
        build(soup).occluded(SimpleNamespace(__cuda_array_interface__=None), None)


def test_memory_that_cannot_be_read_is_refused(soup, rays):
    vertices, faces = on_device(soup[0]), on_device(soup[1], "int32")
    bvh, origins = build(soup), on_device(rays[0])
    address = origins.__cuda_array_interface__["data"][0]
    with pytest.raises(ValueError, match="origins must begin at a multiple of 4 bytes"):
        bvh.occluded(Foreign(origins, data=(address + 2, False), shape=(10, 3)), origins)
    with pytest.raises(ValueError, match="origins must not have a mask"):
        bvh.occluded(Foreign(origins, mask=origins), origins)
    with pytest.raises(TypeError, match="origins must be float32 on the device, not >f4"):
        bvh.occluded(Foreign(origins, typestr=">f4"), origins)
    with pytest.raises(TypeError, match="faces must hold integers of 32 or 64 bits on the device, not >i4"):
        treelet.build(vertices, Foreign(faces, typestr=">i4"))
    with pytest.raises(ValueError, match="vertices has 4294967296 rows, but at most 4294967295"):
        treelet.build(Foreign(vertices, shape=(2**32, 3)), faces)


def test_empty_arrays_need_no_address(soup, rays):
    empty = Foreign(on_device(np.empty((0, 3), np.float32)), data=(None, False))
    assert build(soup).occluded(empty, empty).shape == (0,)
    no_faces = Foreign(on_device(np.empty((0, 3), np.int32)), data=None)
    bvh = treelet.build(on_device(soup[0]), no_faces, "lbvh > bvh2")
    assert not bvh.occluded(*map(on_device, rays)).numpy().any()


def test_host_and_device_do_not_mix(soup, rays):
    vertices, faces = soup
    host, device = treelet.build(vertices, faces, updatable=True), build(soup, updatable=True)
    on_gpu = on_device(vertices)
    for name, call in {
        "origins": lambda: host.intersect(on_gpu, rays[1]),
        "directions": lambda: host.occluded(rays[0], on_gpu),
        "t_max": lambda: host.traversal_cost(*rays, t_max=on_gpu),
        "vertices": lambda: host.refit(on_gpu),
        "faces": lambda: treelet.build(vertices, on_device(faces, "int32")),
    }.items():
        with pytest.raises(TypeError, match=rf"{name} lies on a CUDA device.*bvh\.to\('cuda'\)"):
            call()
    with pytest.raises(TypeError, match=r"vertices lies on a CUDA device"):
        host.validate(on_gpu, faces)
    with pytest.raises(TypeError, match="faces must lie on the host, where validation runs"):
        device.validate(vertices, on_device(faces, "int32"))
    with pytest.raises(TypeError, match=r"vertices must lie on a CUDA device.*copy them there"):
        device.refit(vertices)
    with pytest.raises(TypeError, match=r"faces must lie on a CUDA device.*or the vertices to the host"):
        treelet.build(on_gpu, faces)
    with pytest.raises(TypeError, match="stream is for arrays on a CUDA device"):
        treelet.build(vertices, faces, stream=0)
    assert device.validate(vertices, faces) == []


@pytest.mark.parametrize("limit", [None, [1.0, 2.0], np.ones(500, np.float32), "far", True, 1j])
def test_limits_on_the_host_are_numbers(soup, rays, limit):
    with pytest.raises(TypeError, match="t_max must be a number, or an array on the CUDA device"):
        build(soup).occluded(*map(on_device, rays), t_max=limit)


def test_limits_beyond_float32_are_infinite(soup, rays):
    bvh, device_rays = build(soup), [on_device(part) for part in rays]
    far = bvh.intersect(*device_rays, t_min=np.int64(-5), t_max=1e300).t.numpy()
    expected = treelet.build(*soup).intersect(*rays, t_min=-5, t_max=1e300).t
    np.testing.assert_array_equal(far, expected)
