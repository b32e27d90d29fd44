"""View and the automatic camera."""

import numpy as np
import pytest

from treelet.view import View, automatic_view

BOX_FACES = np.array(
    [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4],
     [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5]]
)  # fmt: skip


def box(low, high):
    corners = np.array([[i & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)], dtype=np.float32)
    return np.asarray(low) + corners * np.subtract(high, low), BOX_FACES


def project(view, points, aspect=1.6):
    """Picture coordinates in [-1, 1] of the points, and their depth."""
    forward = np.array(view.direction)
    right = np.cross(forward, view.up)
    right /= np.linalg.norm(right)
    above = np.cross(right, forward)
    offset = np.asarray(points, dtype=np.float64) - view.eye
    depth = offset @ forward
    slope = np.tan(np.radians(view.fov_degrees) / 2)
    return offset @ right / (depth * slope * aspect), offset @ above / (depth * slope), depth


def fine_ball(seed=0, count=3000, centre=(0, 0, 0), radius=1.0):
    """Small triangles on a sphere."""
    generator = np.random.default_rng(seed)
    normals = generator.standard_normal((count, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    corners = normals[:, None] + 0.02 * generator.standard_normal((count, 3, 3))
    return (corners * radius + centre).reshape(-1, 3), np.arange(3 * count).reshape(-1, 3)


def joined(*parts):
    starts = np.cumsum([0] + [len(vertices) for vertices, _ in parts])
    return (
        np.concatenate([vertices for vertices, _ in parts]),
        np.concatenate([faces + start for (_, faces), start in zip(parts, starts, strict=False)]),
    )


def test_view_keeps_plain_floats():
    view = View(np.float32([1, 2, 3]), [0, 0, 0], (0, 0, 1), 40, "front")
    assert view.eye == (1.0, 2.0, 3.0)
    assert all(type(value) is float for value in (*view.eye, *view.look_at, *view.up, view.fov_degrees))
    assert np.linalg.norm(view.direction) == pytest.approx(1.0)
    assert view == View((1, 2, 3), (0, 0, 0), fov_degrees=40, name="front")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (((1e300, 5, 5), (1, 0, 0)), r"eye \(1e\+300, 5\.0, 5\.0\) is out of float32 range"),
        (((0, 0, 0), (0, -1e39, 0)), r"look_at \(0\.0, -1e\+39, 0\.0\) is out of float32 range"),
        (((0, 0), (1, 0, 0)), r"eye must be three finite numbers, not \(0, 0\)"),
        (((0, 0, np.nan), (1, 0, 0)), r"eye must be three finite numbers, not \(0, 0, nan\)"),
        (((1, 0, 0), (1, 0, 0)), r"eye and look_at are the same point \(1.0, 0.0, 0.0\)"),
        (((0, 0, 5), (0, 0, 0)), r"up \(0.0, 0.0, 1.0\) must not be zero or along the line of sight"),
        (
            ((1, 0, 0), (0, 0, 0), (0, 0, 0)),
            r"up \(0.0, 0.0, 0.0\) must not be zero or along the line of sight",
        ),
        (((1, 0, 0), (0, 0, 0), (0, 0, 1), 180), "fov_degrees must be between 0 and 180, not 180"),
    ],
)
def test_view_that_shows_nothing_is_an_error(arguments, message):
    with pytest.raises(ValueError, match=f"^{message}$"):
        View(*arguments)


@pytest.mark.parametrize("scale", [1e-20, 1e-3, 1.0, 1e6, 1e20])
@pytest.mark.parametrize("offset", [0.0, 100.0])
def test_automatic_view_frames_a_box(scale, offset):
    vertices, faces = box((0, 0, 0), (3, 1, 2))
    vertices = (vertices + offset) * scale
    view = automatic_view(vertices, faces)
    x, y, depth = project(view, vertices)
    assert (depth > 0).all()
    largest = max(np.abs(x).max(), np.abs(y).max())
    assert 0.7 < largest <= 1.0
    assert view.up == (0.0, 0.0, 1.0)
    assert view.direction[2] < 0


def test_automatic_view_ignores_the_stadium_around_the_teapot():
    teapot, stadium = fine_ball(), box((-500, -500, -1.1), (500, 500, 200))
    view = automatic_view(*joined(teapot, stadium))
    x, y, depth = project(view, teapot[0])
    assert (depth > 0).all()
    assert 0.6 < max(np.abs(x).max(), np.abs(y).max()) < 1.1


def test_automatic_view_goes_round_a_backdrop():
    teapot = fine_ball()
    backdrop = (
        np.array([[-9, -4, -9], [9, -4, -9], [9, -4, 9], [-9, -4, 9]]),
        np.array([[0, 1, 2], [0, 2, 3]]),
    )
    assert automatic_view(*joined(teapot, backdrop)).eye[1] > -4


def test_automatic_view_finds_the_floor():
    room = fine_ball(centre=(0, 0.6, 0), radius=0.5)
    floor = np.array([[-2, 0, -2], [-2, 0, 2], [2, 0, 2], [2, 0, -2]]), np.array([[0, 1, 2], [0, 2, 3]])
    vertices, faces = joined(room, floor)
    assert automatic_view(vertices, faces).up == (0.0, 1.0, 0.0)
    assert automatic_view(vertices[:, [2, 0, 1]], faces).up == (0.0, 0.0, 1.0)
    assert automatic_view(vertices, faces, up="x").up == (1.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("vertices", "faces"),
    [
        (np.zeros((0, 3)), np.zeros((0, 3), dtype=int)),
        (np.zeros((1, 3)), np.zeros((4, 3), dtype=int)),
        (np.full((3, 3), np.nan), [[0, 1, 2]]),
        (np.full((3, 3), 7.0), [[0, 1, 2]]),
        ([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]]),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [np.inf, 0, 0]], [[0, 1, 2], [0, 1, 3]]),
    ],
)
def test_automatic_view_of_nothing_much_is_still_a_view(vertices, faces):
    view = automatic_view(np.asarray(vertices), np.asarray(faces))
    assert np.isfinite([*view.eye, *view.look_at]).all()


def test_automatic_view_rejects_an_unknown_axis():
    with pytest.raises(ValueError, match=r"^up must be x, y or z, not 'w'$"):
        automatic_view(*box((0, 0, 0), (1, 1, 1)), up="w")
