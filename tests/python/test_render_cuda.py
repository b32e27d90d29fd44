"""Pictures made on a CUDA device: with cupy on a GPU, with a stand-in for it on the emulated device."""

import inspect
import sys

import fake_cupy
import numpy as np
import pytest

pytest.importorskip("PIL")

import treelet
from treelet import cuda, scenes
from treelet.device_bvh import DeviceBvh
from treelet.mesh import Mesh
from treelet.render import MODES, RenderSettings, arrays, render, upload_mesh
from treelet.render.heat import cost_map, render_heat_pair
from treelet.render.path import render_path
from treelet.render.rays import ambient_occlusion_rays, diffuse_rays, primary_rays
from treelet.render.studio import Studio
from treelet.view import View

HAS_DEVICE = cuda.is_available()
IS_EMULATED = HAS_DEVICE and cuda.devices()[0].name.startswith("Emulated")
SETTINGS = RenderSettings(width=48, height=32, samples=4, bounces=3)
INSIDE = View((0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), 40.0)


@pytest.fixture
def cupy(monkeypatch):
    if not HAS_DEVICE:
        pytest.skip("no CUDA device")
    if not IS_EMULATED:
        return pytest.importorskip("cupy")
    monkeypatch.setitem(sys.modules, "cupy", fake_cupy)
    return fake_cupy


@pytest.fixture
def counts(cupy):
    if cupy is not fake_cupy:
        pytest.skip("only the stand-in counts")
    for name in vars(fake_cupy.counts):
        if name != "bytes_in_use":
            setattr(fake_cupy.counts, name, 0)
    return fake_cupy.counts


@pytest.fixture
def hosts_arithmetic(cupy, monkeypatch):
    """The sums of products in numpy's order, so that not even rounding differs."""
    if cupy is not fake_cupy:
        pytest.skip("a GPU rounds sines and powers in its own way")

    def dot(left, right):
        if right.ndim < left.ndim:
            return fake_cupy.run(np.matmul, left, right)
        return fake_cupy.run(np.einsum, "...i,...i->...", left, right)

    monkeypatch.setattr(arrays, "_dot_on_device", dot)


RECIPE = "lbvh > bvh2"  # host and device visit the same nodes: the host's bvh8 lets leaves wait


@pytest.fixture(scope="module")
def city():
    mesh = scenes.load("city", triangles=1500).rounded()
    return mesh, treelet.build(mesh.vertices, mesh.faces, RECIPE)


@pytest.fixture
def scene(city, cupy):
    """Mesh, view, tree on the host, mesh and tree on the device."""
    mesh, host = city
    uploaded = upload_mesh(mesh)
    return mesh, mesh.views[0], host, uploaded, treelet.build(uploaded.vertices, uploaded.faces, RECIPE)


def share_that_differs(first, second, tolerance):
    return np.mean(np.abs(first.astype(np.float64) - second) > tolerance)


@pytest.mark.parametrize("mode", [mode for mode in MODES if mode != "heat"])
@pytest.mark.usefixtures("hosts_arithmetic")
def test_pictures_are_those_of_the_host(scene, mode):
    mesh, view, host, uploaded, device = scene
    expected = render(host, mesh, view, mode, SETTINGS)
    picture = render(device, uploaded, view, mode, SETTINGS)
    assert type(picture) is np.ndarray
    assert len(np.unique(expected.reshape(-1, 3), axis=0)) > 8
    np.testing.assert_array_equal(picture, expected)


@pytest.mark.usefixtures("hosts_arithmetic")
def test_values_before_the_tone_map_are_those_of_the_host(scene):
    mesh, view, host, uploaded, device = scene
    pictures = [render_path(Studio(*each, view, SETTINGS)) for each in ((device, uploaded), (host, mesh))]
    np.testing.assert_array_equal(arrays.to_host(pictures[0]), pictures[1])


@pytest.mark.parametrize("mode", MODES)
def test_the_devices_own_rounding_is_hardly_seen(scene, mode):
    mesh, view, host, uploaded, device = scene
    expected = render(host, mesh, view, mode, SETTINGS)
    assert share_that_differs(render(device, uploaded, view, mode, SETTINGS), expected, tolerance=2) < 0.01


def test_heat_counts_what_the_host_counts(scene):
    mesh, view, host, uploaded, device = scene
    expected = cost_map(Studio(host, mesh, view, SETTINGS))
    found = cost_map(Studio(device, uploaded, view, SETTINGS))
    assert type(found.nodes) is np.ndarray
    assert found.mean == pytest.approx(expected.mean, rel=0.02)
    pair = render_heat_pair([device, device], ["one", "other"], mesh, view, RenderSettings(120, 80, 1))
    np.testing.assert_array_equal(pair[30:80, :120], pair[30:80, 128:])


@pytest.mark.usefixtures("hosts_arithmetic")
def test_rays_are_those_of_the_host(scene, cupy):
    mesh, view, host, uploaded, device = scene

    def batches(bvh, mesh, xp):
        primary = primary_rays(view, 30, 20, seed=3, xp=xp)
        diffuse = diffuse_rays(bvh, mesh, primary, bounces=2, samples=2)
        return primary, diffuse, ambient_occlusion_rays(bvh, mesh, primary)

    for rays, expected in zip(batches(device, uploaded, cupy), batches(host, mesh, np), strict=True):
        assert (rays.kind, rays.t_max) == (expected.kind, expected.t_max)
        np.testing.assert_array_equal(rays.origins.get(), expected.origins)
        np.testing.assert_array_equal(rays.directions.get(), expected.directions)
    np.testing.assert_array_equal(rays.trace(device).get(), expected.trace(host))


def test_waves_and_where_the_mesh_lies_do_not_matter(scene):
    mesh, view, _, uploaded, device = scene
    whole = render(device, uploaded, view, "path", SETTINGS)
    calls = []
    waves = RenderSettings(48, 32, 4, 3, chunk=1000)
    picture = render(device, mesh, view, "path", waves, lambda *call: calls.append(call))
    np.testing.assert_array_equal(picture, whole)
    assert calls == [(done, 7) for done in range(1, 8)]


@pytest.mark.parametrize("mode", MODES)
def test_an_empty_mesh_is_all_backdrop(cupy, mode):
    mesh = Mesh(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int32), "nothing")
    uploaded = upload_mesh(mesh)
    device = treelet.build(uploaded.vertices, uploaded.faces, "fast")
    host = treelet.build(mesh.vertices, mesh.faces, "fast")
    expected = render(host, mesh, INSIDE, mode, SETTINGS)
    assert share_that_differs(render(device, uploaded, INSIDE, mode, SETTINGS), expected, tolerance=1) == 0


def test_only_the_picture_comes_back(scene, counts):
    _, view, _, uploaded, device = scene
    picture = render(device, uploaded, view, "path", SETTINGS)
    assert picture.nbytes <= counts.bytes_to_host <= picture.nbytes + 8  # and two numbers for the exposure


def test_a_bounce_waits_three_times(scene, counts):
    """For how many rays missed, how many hit, and how many of those face the sun."""
    _, view, _, uploaded, device = scene
    waits = []
    for bounces in range(1, 5):
        counts.waits = 0
        render(device, uploaded, view, "path", RenderSettings(48, 32, 2, bounces, exposure=1.0))
        waits.append(counts.waits)
    np.testing.assert_array_equal(np.diff(waits), 3)
    assert waits[0] == 3 + 2 + 1  # the bounce, where its rays end, the picture


@pytest.mark.parametrize("mode", MODES)
def test_memory_is_512_bytes_a_ray_in_flight_and_a_pixel(cupy, counts, mode):
    """Where every ray hits, as inside a ball."""
    mesh = upload_mesh(scenes.load("sphere", triangles=1000))
    bvh = treelet.build(mesh.vertices, mesh.faces, "fast")
    for chunk in (512, 4096):
        counts.peak_bytes = before = counts.bytes_in_use
        render(bvh, mesh, INSIDE, mode, RenderSettings(32, 32, 4, 3, chunk=chunk))
        assert counts.peak_bytes - before < 512 * (chunk + 32 * 32)


@pytest.mark.parametrize("mode", MODES)
def test_every_query_is_asked_with_arrays_of_the_device(scene, cupy, monkeypatch, mode):
    """A device tree would answer rays of the host too, after copying them."""
    _, view, _, uploaded, device = scene
    asked = []

    def watch(name):
        query = getattr(DeviceBvh, name)

        def watched(bvh, origins, directions, *limits, **options):
            asked.append((type(origins), type(directions)))
            return query(bvh, origins, directions, *limits, **options)

        monkeypatch.setattr(DeviceBvh, name, watched)

    for name in ("intersect", "occluded", "traversal_cost"):
        watch(name)
    render(device, uploaded, view, mode, SETTINGS)
    assert len(asked) > 0
    assert set(asked) == {(cupy.ndarray, cupy.ndarray)}


def test_host_and_device_do_not_mix(scene, cupy):
    _, view, host, uploaded, device = scene
    with pytest.raises(TypeError):
        render(host, uploaded, view, "normals", SETTINGS)
    studio = Studio(device, uploaded, view, SETTINGS)
    rays = primary_rays(view, 8, 8)
    with pytest.raises(TypeError):
        device.intersect(rays.origins, cupy.asarray(rays.directions))
    with pytest.raises(TypeError):
        studio.light.sky(rays.directions)
    with pytest.raises(TypeError):
        studio.triangles.surface(rays.trace(host), rays.directions)


def test_the_stand_in_refuses_what_cupy_refuses(counts):
    array, values = fake_cupy.asarray(np.ones(3)), np.ones(3)
    for mix in (
        lambda: np.asarray(array),
        lambda: np.sqrt(array),
        lambda: np.where(array > 0.0, array, array),
        lambda: array + values,
        lambda: values + array,
        lambda: fake_cupy.maximum(array, values),
        lambda: array.__setitem__(0, values[0:1]),
        lambda: values.__setitem__(slice(None), array),
        lambda: fake_cupy.sqrt(array, where=array),
    ):
        with pytest.raises(TypeError):
            mix()
    assert counts.waits == 0
    assert (np.float32(2.0) * array).get().tolist() == [2.0, 2.0, 2.0]


def test_what_the_stand_in_has_cupy_has():
    cupy = pytest.importorskip("cupy")
    for name, keywords in fake_cupy.KEYWORDS.items():
        function = getattr(cupy, name)
        if isinstance(function, cupy.ufunc):
            assert set(keywords) <= {"out", "dtype"}
        else:
            parameters = inspect.signature(function).parameters
            assert set(keywords) <= set(parameters) or "kwargs" in parameters, name
    for name in fake_cupy.METHODS:
        assert hasattr(cupy.ndarray, name), name


def test_missing_cupy_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "cupy", None)
    with pytest.raises(ImportError, match=r"needs cupy: pip install 'cupy-cuda13x\[ctk\]'"):
        upload_mesh(Mesh(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int32), "nothing"))
