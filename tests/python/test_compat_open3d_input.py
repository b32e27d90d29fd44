"""Cameras of the drop-in for Open3D's RaycastingScene, and what it refuses in words that help."""

from __future__ import annotations

import re

import numpy as np
import pytest
from sample_meshes import TRIANGLE_FACES, TRIANGLE_VERTICES

from treelet.compat.open3d import RaycastingScene


def triangle():
    scene = RaycastingScene()
    scene.add_triangles(TRIANGLE_VERTICES, TRIANGLE_FACES)
    return scene


def test_camera_rays_from_matrices():
    intrinsic = [[100, 0, 32], [0, 110, 24], [0, 0, 1]]
    extrinsic = np.array([[0, 1, 0, 1], [-1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]])
    rays = RaycastingScene.create_rays_pinhole(intrinsic, extrinsic, width_px=64, height_px=48)
    assert (rays.shape, rays.dtype) == ((48, 64, 6), np.float32)
    in_camera = (
        np.stack([rays[..., :3], rays[..., :3] + rays[..., 3:]]) @ extrinsic[:3, :3].T + extrinsic[:3, 3]
    )
    assert np.allclose(in_camera[0], 0, atol=1e-6)
    pixels = in_camera[1] @ np.array(intrinsic).T
    row, column = np.meshgrid(np.arange(48) + 0.5, np.arange(64) + 0.5, indexing="ij")
    assert np.allclose(pixels, np.stack([column, row, np.ones_like(row)], axis=-1), atol=1e-4)


def test_camera_rays_from_a_view():
    view = {"fov_deg": 90, "center": [0, 0, 0], "eye": [-2, 0, 0], "up": [0, 0, 3]}
    rays = RaycastingScene.create_rays_pinhole(**view, width_px=4, height_px=2)
    assert rays.shape == (2, 4, 6)
    assert (rays[..., :3] == [-2, 0, 0]).all()
    across = [-0.75, -0.25, 0.25, 0.75]  # from right to left: the picture is turned by 180 degrees
    expected = [[[1, y, z] for y in across] for z in (-0.25, 0.25)]
    assert np.allclose(rays[..., 3:], expected)


def camera(**changes):
    view = {
        "fov_deg": 60,
        "center": [0, 0, 1],
        "eye": [0, 0, 0],
        "up": [0, 1, 0],
        "width_px": 4,
        "height_px": 2,
    }
    return lambda: RaycastingScene.create_rays_pinhole(**{**view, **changes})


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: triangle().cast_rays(np.zeros((2, 5))), ValueError, r"rays must have shape \(..., 6\)"),
        (lambda: triangle().cast_rays(1.0), ValueError, r"rays must have shape \(..., 6\), not \(\)"),
        (lambda: triangle().compute_distance([[0, 1]]), ValueError, "points must have shape"),
        (lambda: triangle().compute_occupancy([[0, 0, 0]], nsamples=2), ValueError, "nsamples must be odd"),
        (
            lambda: triangle().compute_signed_distance([[0, 0, 0]], nsamples=-1),
            ValueError,
            "nsamples must be odd",
        ),
        (lambda: RaycastingScene(device="CUDA:0"), ValueError, "device must be the CPU, not CUDA:0"),
        (lambda: RaycastingScene().add_triangles([[0, 0, 0]], [[0, 0, 1]]), ValueError, "names vertex 1"),
        (
            lambda: RaycastingScene().add_triangles([[0, 0]], [[0, 0, 0]]),
            ValueError,
            "vertices must have shape",
        ),
        (lambda: RaycastingScene().add_triangles("cube"), TypeError, "mesh must have vertices and triangles"),
        (camera(up=[0, 0, 2]), ValueError, "up must not be parallel"),
        (camera(center=[0, 0, 0]), ValueError, "center must differ from eye"),
        (camera(fov_deg=180), ValueError, "fov_deg must lie between 0 and 180, not be 180"),
        (camera(up=[0, 1]), ValueError, r"up must have shape \(3,\), not \(2,\)"),
        (
            lambda: RaycastingScene.create_rays_pinhole(np.zeros((3, 3)), np.eye(4), 2, 2),
            ValueError,
            "intrinsic_matrix must have an inverse",
        ),
        (camera(width_px=0), ValueError, "^width_px must be at least 1, not 0$"),
        (camera(height_px=-3), ValueError, "^height_px must be at least 1, not -3$"),
        (camera(width_px=2.5), TypeError, "^width_px must be a whole number, not float$"),
        (
            lambda: RaycastingScene.create_rays_pinhole(np.eye(3), np.eye(4), 4, 0),
            ValueError,
            "^height_px must be at least 1, not 0$",
        ),
        (
            lambda: RaycastingScene.create_rays_pinhole(60, [0, 0, 1], width_px=4),
            TypeError,
            re.escape(
                "create_rays_pinhole takes (intrinsic_matrix, extrinsic_matrix, width_px, height_px) or "
                "(fov_deg, center, eye, up, width_px, height_px), not (int, list, width_px=...)"
            ),
        ),
        (
            lambda: RaycastingScene().add_triangles(np.zeros((3, 3)), faces=[[0, 1, 2]]),
            TypeError,
            re.escape(
                "add_triangles takes (mesh) or (vertex_positions, triangle_indices), not (ndarray, faces=...)"
            ),
        ),
    ],
)
def test_bad_input_is_named(call, error, message):
    with pytest.raises(error, match=message):
        call()


def test_a_bad_mesh_leaves_the_scene_as_it_was():
    scene = triangle()
    with pytest.raises(ValueError, match="names vertex 9"):
        scene.add_triangles(TRIANGLE_VERTICES, [[0, 1, 9]])
    assert scene.add_triangles(TRIANGLE_VERTICES, TRIANGLE_FACES) == 1
