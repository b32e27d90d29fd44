from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("PIL")

import treelet
from treelet import scenes
from treelet.mesh import Mesh
from treelet.render import MODES, Camera, RenderSettings, render, save_png
from treelet.render.color import cividis, inferno, srgb, tone_mapped
from treelet.render.denoise import denoise
from treelet.render.directions import cone_directions, cosine_directions, frame_around
from treelet.render.features import render_ambient_occlusion
from treelet.render.heat import cost_map, render_heat_pair
from treelet.render.image import round_ticks
from treelet.render.path import render_path
from treelet.render.rays import ambient_occlusion_rays, diffuse_rays, primary_rays
from treelet.render.sampling import Sampler, sobol_table
from treelet.render.studio import Studio
from treelet.render.surface import Triangles
from treelet.view import View

SMALL = RenderSettings(width=24, height=16, samples=4, bounces=2)
FRONT = View((0.0, -4.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 40.0)


@pytest.fixture(scope="module")
def ball():
    mesh = scenes.load("sphere", triangles=2000)
    return mesh, treelet.build(mesh.vertices, mesh.faces, recipe="fast")


@pytest.fixture(scope="module")
def ground():
    corners = np.array([[-50, -50, 0], [50, -50, 0], [50, 50, 0], [-50, 50, 0]], dtype=np.float32)
    mesh = Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32), "ground")
    return mesh, treelet.build(mesh.vertices, mesh.faces, recipe="fast")


def test_sobol_begins_as_published():
    expected = [[0.0, 0.0], [0.5, 0.5], [0.25, 0.75], [0.75, 0.25]]
    np.testing.assert_array_equal(sobol_table(4) / 2.0**32, expected)


@pytest.mark.parametrize("samples", [1, 2, 16, 64])
def test_samples_of_a_pixel_fill_every_stratum_once(samples):
    for numbers in Sampler(3, samples).pairs(np.full(samples, 77), np.arange(samples), 5):
        np.testing.assert_array_equal(np.sort((numbers * samples).astype(int)), np.arange(samples))


def test_dimensions_are_out_of_step():
    """Shuffled by xor alone, the strata of two dimensions would differ by one constant in all samples."""
    pixel, sample = np.divmod(np.arange(200 * 16), 16)
    strata = [(Sampler(0, 16).pairs(pixel, sample, dimension)[0] * 16).astype(int) for dimension in (1, 2)]
    differences = (strata[0] ^ strata[1]).reshape(200, 16)
    assert np.mean([len(set(row)) for row in differences.tolist()]) > 6.0


def test_numbers_depend_on_pixel_sample_dimension_and_seed_only():
    pixel, sample = np.arange(1000), np.arange(1000) % 8
    first, second = Sampler(1, 8).pairs(pixel, sample, 2)
    backwards = Sampler(1, 8).pairs(pixel[::-1], sample[::-1], 2)
    np.testing.assert_array_equal(first, backwards[0][::-1])
    assert not np.array_equal(first, second)
    for other in (Sampler(2, 8).pairs(pixel, sample, 2), Sampler(1, 8).pairs(pixel, sample, 3)):
        assert abs(np.corrcoef(first, other[0])[0, 1]) < 0.15
    assert first.min() >= 0.0
    assert first.max() < 1.0


@pytest.mark.parametrize("normal", [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0.6, -0.48, 0.64)])
def test_cosine_directions_follow_their_normal(normal):
    count = 4096
    normals = np.tile(np.array(normal, dtype=np.float32), (count, 1))
    directions = cosine_directions(
        normals, *Sampler(0, count).pairs(np.zeros(count, int), np.arange(count), 0)
    )
    cosines = np.einsum("ij,ij->i", directions, normals)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0, atol=1e-5)
    assert cosines.min() > -1e-6
    assert cosines.mean() == pytest.approx(2.0 / 3.0, abs=0.005)


def test_frames_are_orthonormal():
    normals = np.random.default_rng(0).standard_normal((500, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    frames = np.stack([*frame_around(normals), normals], axis=1)
    np.testing.assert_allclose(frames @ frames.transpose(0, 2, 1), np.tile(np.eye(3), (500, 1, 1)), atol=1e-6)


def test_cones_stay_inside_their_angle():
    axis = np.array([0.0, 0.6, 0.8], dtype=np.float32)
    numbers = Sampler(0, 256).pairs(np.zeros(256, int), np.arange(256), 0)
    angles = np.arccos(np.clip(cone_directions(axis, 0.1, *numbers) @ axis, -1.0, 1.0))
    assert angles.max() <= 0.1 + 1e-3
    assert angles.max() > 0.09


def test_camera_looks_where_the_view_says():
    camera = Camera(FRONT, 30, 20)
    origin, directions = camera.rays(np.array([10 * 30 + 15, 15]), np.zeros(2), np.zeros(2))
    np.testing.assert_array_equal(origin, FRONT.eye)
    np.testing.assert_allclose(
        directions[0], [0.0, 1.0, 0.0], atol=1e-6
    )  # the corner in the middle of the picture
    assert np.degrees(np.arccos(directions[1, 1])) == pytest.approx(
        20.0, abs=1e-3
    )  # the middle of the upper border
    assert directions[1, 2] > 0.0
    assert (
        camera.rays(np.array([0]), np.zeros(1), np.zeros(1))[1][0, 0] < 0.0
    )  # the left is -x, looking along +y


@pytest.mark.parametrize(("scale", "offset"), [(1.0, 0.0), (1e-6, 0.0), (1e6, 0.0), (1.0, 1e4)])
def test_rays_leaving_a_convex_surface_never_hit_it_again(ball, scale, offset):
    unit = ball[0]
    mesh = Mesh(unit.vertices * np.float32(scale) + np.float32(offset), unit.faces, "ball")
    bvh = treelet.build(mesh.vertices, mesh.faces, recipe="fast")
    middle = np.full(3, offset)
    view = View(tuple(middle - [0.0, 4.0 * scale, 0.0]), tuple(middle), (0.0, 0.0, 1.0), 28.0)
    primary = primary_rays(view, 64, 64)
    surface = Triangles(mesh.vertices, mesh.faces).surface(primary.trace(bvh), primary.directions)
    assert len(surface) > 3000
    assert not bvh.occluded(surface.origins, surface.normals).any()


def test_normals_face_the_ray_whatever_the_winding(ball):
    mesh, bvh = ball
    flipped = SimpleNamespace(vertices=mesh.vertices, faces=mesh.faces[:, ::-1])
    primary = primary_rays(FRONT, 16, 16)
    hits = primary.trace(bvh)
    for each in (mesh, flipped):
        surface = Triangles(each.vertices, each.faces).surface(hits, primary.directions)
        facing = np.einsum("ij,ij->i", surface.normals, primary.directions[surface.ray])
        assert (facing < 0.0).all()


@pytest.mark.parametrize("mode", [mode for mode in MODES if mode != "heat"])
def test_modes_give_pictures_that_do_not_depend_on_chunks(ball, mode):
    mesh, bvh = ball
    picture = render(bvh, mesh, FRONT, mode, SMALL)
    chunked = render(bvh, mesh, FRONT, mode, RenderSettings(24, 16, 4, 2, chunk=100))
    assert picture.shape == (16, 24, 3)
    assert picture.dtype == np.uint8
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 3
    np.testing.assert_array_equal(picture, chunked)


def test_seeds_change_the_noise_only(ball):
    mesh, bvh = ball
    noisy = [
        render(bvh, mesh, FRONT, "path", RenderSettings(24, 16, 4, 2, seed)).astype(int) for seed in (0, 1)
    ]
    assert (noisy[0] != noisy[1]).any()
    assert np.abs(noisy[0] - noisy[1]).mean() < 8.0


def test_normals_show_the_side_that_faces_the_camera(ball):
    mesh, bvh = ball
    middle = render(bvh, mesh, FRONT, "normals", SMALL)[8, 12]
    np.testing.assert_allclose(middle, [127, 0, 127], atol=24)


def test_near_things_are_light_in_depth(ball):
    mesh, bvh = ball
    picture = render(bvh, mesh, FRONT, "depth", RenderSettings(48, 32, 1)).astype(int)
    assert picture[16, 24].sum() > picture[16, 16].sum()


def test_nothing_occludes_a_plane_and_everything_the_inside_of_a_ball(ground, ball):
    above = View((0.0, 0.0, 5.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 40.0)
    open_sky = render_ambient_occlusion(Studio(ground[1], ground[0], above, SMALL))
    np.testing.assert_allclose(open_sky, 0.97, atol=1e-5)
    inside = View((0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), 40.0)
    far = RenderSettings(24, 16, 4, reach=2.0)
    np.testing.assert_array_equal(render_ambient_occlusion(Studio(ball[1], ball[0], inside, far)), 0.0)


@pytest.mark.parametrize("bounces", [1, 3])
def test_furnace_gives_back_the_albedo(ball, bounces):
    """Under an even sky a convex surface is as bright as its reflectance, however long the paths may get."""
    settings = RenderSettings(16, 16, 8, bounces, exposure=1.0, denoise=False)
    studio = Studio(ball[1], ball[0], FRONT, settings)
    studio.light.sky = lambda directions: np.ones_like(directions)
    studio.light.sunlight = lambda normals, to_sun: np.zeros_like(normals)
    studio.albedo = lambda points, normals: np.full_like(normals, 0.5)
    np.testing.assert_allclose(render_path(studio)[8, 8], tone_mapped(np.full(3, 0.5)), atol=1e-5)


def test_paths_that_find_no_sky_end_in_faint_light(ball):
    inside = View((0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), 40.0)
    settings = RenderSettings(8, 8, 2, 2, exposure=1.0)
    assert 0.02 < render_path(Studio(ball[1], ball[0], inside, settings)).min() < 0.5


def test_no_light_gives_a_black_picture_without_warnings(ball):
    inside = View((0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), 40.0)
    studio = Studio(ball[1], ball[0], inside, SMALL)
    studio.light.sky = lambda directions: np.zeros_like(directions)
    studio.albedo = lambda points, normals: np.zeros_like(normals)
    assert render_path(studio).max() < 0.01


def test_a_mesh_without_faces_is_all_backdrop():
    mesh = Mesh(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int32), "nothing")
    bvh = treelet.build(mesh.vertices, mesh.faces, recipe="fast")
    for mode in MODES:
        assert render(bvh, mesh, FRONT, mode, SMALL).shape[1:] == (24, 3)


def test_heat_pair_shares_one_scale(ball):
    mesh, bvh = ball
    settings = RenderSettings(120, 80, 1)
    pair = render_heat_pair([bvh, bvh], ["one", "other"], mesh, FRONT, settings)
    assert pair.dtype == np.uint8
    assert pair.shape[1] == 2 * 120 + 8
    assert pair.shape[0] > 80
    rows = slice(30, 80)
    np.testing.assert_array_equal(pair[rows, :120], pair[rows, 128:])
    assert cost_map(Studio(bvh, mesh, FRONT, settings)).mean >= 1.0


def test_progress_ends_complete(ball):
    mesh, bvh = ball
    calls = []
    render(bvh, mesh, FRONT, "normals", RenderSettings(24, 16, 1, chunk=50), lambda *call: calls.append(call))
    assert calls == [(done, 8) for done in range(1, 9)]


def test_primary_rays_are_the_pixels(ball):
    rays = primary_rays(FRONT, 10, 5, seed=4)
    assert rays.kind == "primary"
    assert len(rays) == 50
    np.testing.assert_array_equal(rays.directions, primary_rays(FRONT, 10, 5, seed=4).directions)


def test_diffuse_rays_leave_the_surface_they_start_from(ball):
    mesh, bvh = ball
    primary = primary_rays(FRONT, 32, 32)
    diffuse = diffuse_rays(bvh, mesh, primary, samples=2)
    outward = np.einsum("ij,ij->i", diffuse.origins, diffuse.directions)
    assert len(diffuse) == 2 * int((primary.trace(bvh).face >= 0).sum())
    assert (outward > -0.2).all()
    np.testing.assert_allclose(np.linalg.norm(diffuse.origins, axis=1), 1.0, atol=0.02)
    assert (diffuse.trace(bvh).face < 0).all()


def test_later_bounces_go_on_where_earlier_ones_hit(ball):
    mesh, bvh = ball
    inside = primary_rays(View((0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), 60.0), 16, 16)
    assert len(diffuse_rays(bvh, mesh, inside, bounces=3)) == 3 * 256


def test_ambient_occlusion_rays_end_at_a_share_of_the_scene(ball):
    mesh, bvh = ball
    rays = ambient_occlusion_rays(bvh, mesh, primary_rays(FRONT, 16, 16), reach=0.25)
    assert rays.any_hit
    assert rays.t_max == pytest.approx(0.25 * np.linalg.norm(np.diff(mesh.bounds, axis=0)), rel=1e-4)
    assert rays.trace(bvh).dtype == bool


def test_filter_keeps_even_pictures_and_edges_and_calms_noise():
    generator = np.random.default_rng(1)
    clean = np.full((40, 60, 3), 0.2, dtype=np.float32)
    clean[:, 30:] = 0.8
    normals = np.zeros_like(clean)
    normals[:, :30, 0] = normals[:, 30:, 1] = 1.0
    depth = np.ones((40, 60), dtype=np.float32)
    variance = np.full((40, 60), 0.01, dtype=np.float32)
    np.testing.assert_allclose(denoise(clean, variance, normals, depth), clean, atol=1e-5)
    noisy = clean + generator.normal(0.0, 0.1, clean.shape).astype(np.float32)
    calm = denoise(noisy, variance, normals, depth)
    assert (calm - clean).std() < 0.25 * (noisy - clean).std()
    np.testing.assert_allclose(denoise(clean, np.zeros_like(variance), normals, depth), clean, atol=1e-6)


def test_curves_of_colour():
    np.testing.assert_allclose(srgb(np.array([0.0, 0.0031308, 1.0])), [0.0, 0.04045, 1.0], atol=1e-4)
    assert (np.diff(tone_mapped(np.linspace(0.0, 4.0, 100))) > 0.0).all()
    for colors in (inferno, cividis):
        brightness = colors(np.linspace(0.0, 1.0, 64)) @ [0.2126, 0.7152, 0.0722]
        assert (np.diff(brightness) > 0.0).all()


@pytest.mark.parametrize("top", [0.013, 1.0, 9.7, 45.0, 143.0, 999.0])
def test_ticks_are_few_and_round(top):
    ticks = round_ticks(top)
    assert 4 <= len(ticks) <= 10
    assert ticks[0] == 0.0
    assert ticks[-1] <= top


def test_png_comes_back_as_it_was(tmp_path):
    from PIL import Image

    picture = np.arange(4 * 5 * 3, dtype=np.uint8).reshape(4, 5, 3)
    path = save_png(tmp_path / "new" / "picture.png", picture)
    with Image.open(path) as image:
        np.testing.assert_array_equal(np.asarray(image), picture)


def test_bad_settings_and_modes_are_named(ball):
    with pytest.raises(ValueError, match="samples is 0, but it must be at least 1"):
        RenderSettings(samples=0)
    with pytest.raises(ValueError, match="unknown render mode 'x': choose one of path"):
        render(ball[1], ball[0], FRONT, "x", SMALL)
