"""Every array that means numbers is taken, every other one refused with words that help."""

import re
import warnings

import numpy as np
import pytest
from sample_meshes import TRIANGLE_FACES, TRIANGLE_VERTICES, grid, random_triangles

import treelet
from treelet import _inputs

DOWN = (0, 0, -1)
INFINITE = np.inf


def says(text):
    """Matches exactly this message."""
    return f"^{re.escape(text)}$"


@pytest.fixture(scope="module")
def bvh():
    return treelet.build(TRIANGLE_VERTICES, TRIANGLE_FACES)


def layouts(array):
    """The same values in other memory."""
    wide = np.zeros((2 * array.shape[0], array.shape[1] + 2), array.dtype)
    wide[::2, 1:-1] = array
    read_only = array.copy()
    read_only.flags.writeable = False
    unaligned = np.frombuffer(b"x" + array.tobytes(), np.uint8)[1:].view(array.dtype).reshape(array.shape)
    return {
        "fortran": np.asfortranarray(array),
        "strided": wide[::2, 1:-1],
        "negative strides": array[::-1, ::-1].copy()[::-1, ::-1],
        "read-only": read_only,
        "unaligned": unaligned,
        "big-endian": array.astype(array.dtype.newbyteorder(">")),
        "list": array.tolist(),
        "tuple": tuple(map(tuple, array.tolist())),
    }


LAYOUTS = list(layouts(TRIANGLE_VERTICES))


@pytest.mark.parametrize("layout", LAYOUTS)
def test_any_memory_layout(layout):
    vertices, faces = random_triangles(60)
    expected_hits = treelet.build(vertices, faces).intersect(vertices - np.float32(0.1), [0.1, 0.2, 0.3])
    rays = layouts(vertices - np.float32(0.1))[layout]
    bvh = treelet.build(layouts(vertices)[layout], layouts(faces)[layout], validate=True)
    hits = bvh.intersect(rays, [0.1, 0.2, 0.3])
    for ours, others in zip(hits, expected_hits, strict=True):
        np.testing.assert_array_equal(ours, others)
    assert (hits.face >= 0).any()
    assert bvh.validate(vertices, faces) == []


@pytest.mark.parametrize("layout", LAYOUTS)
def test_arguments_are_not_written_to(layout):
    vertices, faces = layouts(TRIANGLE_VERTICES)[layout], layouts(TRIANGLE_FACES)[layout]
    treelet.build(vertices, faces).intersect(vertices, DOWN)
    np.testing.assert_array_equal(vertices, TRIANGLE_VERTICES)
    np.testing.assert_array_equal(faces, TRIANGLE_FACES)


@pytest.mark.parametrize("dtype", ["f2", "f4", "f8", "i1", "u1", "i2", "i4", "i8", "u8", np.longdouble])
def test_any_real_numbers(bvh, dtype):
    vertices = TRIANGLE_VERTICES.astype(dtype)
    hits = treelet.build(vertices, TRIANGLE_FACES).intersect(
        np.array([0, 0, 1], dtype), np.array([0, 0, 2], dtype), np.array(-4, "f2"), np.array(4, dtype)
    )
    assert (hits.face, hits.t) == (0, -0.5)


@pytest.mark.parametrize("dtype", ["i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8"])
def test_any_integer_faces(dtype):
    vertices, faces = grid(4)
    bvh = treelet.build(vertices, faces.astype(dtype))
    assert bvh.validate(vertices, faces) == []


def test_what_the_compiled_part_reads_is_aligned():
    for array in (
        _inputs.as_vertices(layouts(TRIANGLE_VERTICES)["unaligned"]).array,
        _inputs.as_faces(layouts(TRIANGLE_FACES.astype(np.uint32))["unaligned"], 3),
        *_inputs.as_rays(layouts(TRIANGLE_VERTICES)["unaligned"], DOWN, 0, 1).arguments[1:],
    ):
        assert array.flags.c_contiguous
        assert array.flags.aligned


def test_arrays_that_fit_are_not_copied():
    assert np.shares_memory(_inputs.as_vertices(TRIANGLE_VERTICES).array, TRIANGLE_VERTICES)
    faces = TRIANGLE_FACES.astype(np.uint32)
    assert np.shares_memory(_inputs.as_faces(faces, 3), faces)
    rays = _inputs.as_rays(TRIANGLE_VERTICES, DOWN, 0, 1).arguments
    assert np.shares_memory(rays[1], TRIANGLE_VERTICES)
    assert rays[2].shape == (1, 3)


def test_views_of_structured_arrays_and_memory(tmp_path):
    np.save(tmp_path / "vertices.npy", TRIANGLE_VERTICES)
    mapped = np.load(tmp_path / "vertices.npy", mmap_mode="r")
    structured = np.zeros(3, [("position", "f4", 3), ("colour", "u1")])
    structured["position"] = TRIANGLE_VERTICES
    for vertices in (mapped, structured["position"], memoryview(TRIANGLE_VERTICES)):
        assert treelet.build(vertices, TRIANGLE_FACES).occluded([0.2, 0.2, 1], DOWN)


def test_results_of_a_query_are_rays_of_the_next(bvh):
    hits = bvh.intersect([0.2, 0.2, 1], DOWN)
    assert hits.t.shape == ()
    assert bvh.intersect([0.2, 0.2, 1], DOWN, t_max=hits.t).face == 0


# Refused


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        (np.zeros((3, 2)), TRIANGLE_FACES, "vertices must have shape (V, 3), not (3, 2)"),
        (np.zeros((1, 3, 3)), TRIANGLE_FACES, "vertices must have shape (V, 3), not (1, 3, 3)"),
        (np.zeros(9), TRIANGLE_FACES, "vertices must have shape (V, 3), not (9,)"),
        (1.5, TRIANGLE_FACES, "vertices must have shape (V, 3), not ()"),
        (TRIANGLE_VERTICES, [0, 1, 2], "faces must have shape (F, 3), not (3,)"),
        (TRIANGLE_VERTICES, [[0, 1]], "faces must have shape (F, 3), not (1, 2)"),
        (
            TRIANGLE_VERTICES,
            [[0, 1, 2, 0]],
            "faces must have shape (F, 3), not (1, 4): triangulate the polygons first",
        ),
        (TRIANGLE_VERTICES, [[0, 1, 3]], "face 0 refers to vertex 3, but the mesh has vertices 0 to 2"),
        (
            TRIANGLE_VERTICES,
            [[0, 1, 2], [0, -1, 7]],
            "face 1 refers to vertex -1, but the mesh has vertices 0 to 2",
        ),
        (
            TRIANGLE_VERTICES,
            [[0, 1, 2], [2, 1, 2**32], [9, 9, 9]],
            "face 1 refers to vertex 4294967296, but the mesh has vertices 0 to 2",
        ),
        (
            TRIANGLE_VERTICES,
            np.array([[0, 1, 2**64 - 1]], np.uint64),
            "face 0 refers to vertex 18446744073709551615, but the mesh has vertices 0 to 2",
        ),
        (
            TRIANGLE_VERTICES,
            np.array([[-128, 1, 2]], np.int8),
            "face 0 refers to vertex -128, but the mesh has vertices 0 to 2",
        ),
        ([], [[0, 0, 0]], "face 0 refers to vertex 0, but the mesh has no vertices"),
    ],
)
def test_values_that_are_refused(bvh, vertices, faces, message):
    with pytest.raises(ValueError, match=says(message)):
        treelet.build(vertices, faces)
    with pytest.raises(ValueError, match=says(message)):
        treelet.intersect_brute_force(vertices, faces, [0, 0, 1], DOWN)
    with pytest.raises(ValueError, match=says(message)):
        bvh.validate(vertices, faces)


@pytest.mark.parametrize(
    ("numbers", "dtype"),
    [
        (np.ones((3, 3), bool), "bool"),
        (np.ones((3, 3), complex), "complex128"),
        (np.ones((3, 3), object), "object"),
        ([["a", "b", "c"]], "<U1"),
        (np.ones((3, 3), "M8[s]"), "datetime64[s]"),
        (None, "object"),
    ],
)
def test_types_that_are_refused(bvh, numbers, dtype):
    vertices, faces, origins = TRIANGLE_VERTICES, TRIANGLE_FACES, [0, 0, 1]
    with pytest.raises(TypeError, match=says(f"vertices must hold real numbers, not {dtype}")):
        treelet.build(numbers, faces)
    with pytest.raises(TypeError, match=says(f"faces must hold integers, not {dtype}")):
        treelet.build(vertices, numbers)
    for query in (bvh.intersect, bvh.occluded, bvh.traversal_cost):
        with pytest.raises(TypeError, match=says(f"origins must hold real numbers, not {dtype}")):
            query(numbers, DOWN)
        with pytest.raises(TypeError, match=says(f"directions must hold real numbers, not {dtype}")):
            query(origins, numbers)
        with pytest.raises(TypeError, match=says(f"t_min must hold real numbers, not {dtype}")):
            query(origins, DOWN, numbers)
        with pytest.raises(TypeError, match=says(f"t_max must hold real numbers, not {dtype}")):
            query(origins, DOWN, 0, numbers)


@pytest.mark.parametrize("dtype", ["float16", "float32", "float64"])
def test_faces_must_not_be_floats(dtype):
    with pytest.raises(TypeError, match=says(f"faces must hold integers, not {dtype}")):
        treelet.build(TRIANGLE_VERTICES, TRIANGLE_FACES.astype(dtype))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([0, 0], DOWN), "origins must have shape (..., 3), not (2,)"),
        ((np.zeros((3, 4)), DOWN), "origins must have shape (..., 3), not (3, 4)"),
        ((1.0, DOWN), "origins must have shape (..., 3), not ()"),
        (([0, 0, 1], 2), "directions must have shape (..., 3), not ()"),
        (([0, 0, 1], np.zeros((3, 0))), "directions must have shape (..., 3), not (3, 0)"),
        (
            (np.zeros((2, 3)), np.zeros((4, 3))),
            "origins (2, 3), directions (4, 3), t_min () and t_max () cannot be broadcast against each other",
        ),
        (
            (np.zeros((2, 3)), DOWN, np.zeros(3), np.zeros((5, 1))),
            "origins (2, 3), directions (3,), t_min (3,) and t_max (5, 1) "
            "cannot be broadcast against each other",
        ),
    ],
)
def test_rays_that_are_refused(bvh, arguments, message):
    for query in (bvh.intersect, bvh.occluded, bvh.traversal_cost):
        with pytest.raises(ValueError, match=says(message)):
            query(*arguments)


def test_an_empty_array_must_have_its_shape_too(bvh):
    with pytest.raises(ValueError, match=says("vertices must have shape (V, 3), not (0, 2)")):
        treelet.build(np.zeros((0, 2)), [])
    with pytest.raises(ValueError, match=says("origins must have shape (..., 3), not (0,)")):
        bvh.intersect([], DOWN)


# Rounding to float32


def test_rounding_that_shows_is_warned_of():
    vertices, faces = random_triangles(10)
    far = vertices + np.array([500_000.3, 5_400_000.7, 100])  # metres, as in UTM
    message = (
        r"^rounding the vertices to float32 moves them by up to 0\.2\d*, in a mesh of extent \d\.?\d*: "
        r"subtract an offset nearer to the mesh from vertices and ray origins first$"
    )
    with pytest.warns(treelet.PrecisionWarning, match=message) as caught:
        treelet.Mesh(far, faces).rounded()
    assert caught[0].filename == __file__
    assert treelet.build(far, faces).report.vertex_rounding < 1e-6  # an offset is subtracted first


def test_large_integers_are_rounded_too():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]]) + 2**24 + 1
    with pytest.warns(treelet.PrecisionWarning):
        treelet.Mesh(vertices, TRIANGLE_FACES).rounded()


def test_rounding_that_does_not_show_is_not_warned_of():
    vertices, faces = random_triangles(10)
    precise = vertices.astype(np.float64) + 1e-9
    assert issubclass(treelet.PrecisionWarning, UserWarning)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        rounding = treelet.build(precise, faces).report.vertex_rounding
        assert 0 < rounding < 1e-7
        assert treelet.build(precise * 1e6, faces).report.vertex_rounding < 0.1
        assert treelet.build(vertices.astype(np.float64), faces).report.vertex_rounding == 0
        treelet.build(vertices + np.float32(1e6), faces)  # nobody rounds float32


def test_numbers_beyond_float32_are_infinite(bvh):
    vertices, faces = random_triangles(4)
    large = vertices.astype(np.float64)
    large[0, 0] = 1e39
    assert treelet.build(large, faces).report.left_out_non_finite == 1
    assert bvh.intersect([0.2, 0.2, 1e39], DOWN).face == -1
    assert bvh.intersect([0.2, 0.2, 1], DOWN, -1e39, 1e39).face == 0
    assert bvh.intersect([0.2, 0.2, 1], DOWN, 1e39, INFINITE).face == -1
