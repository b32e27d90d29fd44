"""Every query against every kind of bad input: it answers as documented, or says what is wrong and where."""

import re
from typing import NamedTuple

import numpy as np
import pytest
from sample_meshes import TRIANGLE_FACES, TRIANGLE_VERTICES, random_triangles, torus

import treelet

RAYS = ["intersect", "occluded", "intersect_all", "count_hits", "traversal_cost"]
POINTS = ["closest_point", "distance", "signed_distance", "contains", "winding_number"]
QUERIES = [*RAYS, *POINTS, "overlap_boxes", "overlap_spheres"]
LAYOUTS = ["lbvh > bvh2", "lbvh > bvh8", "lbvh > cwbvh"]
POINT = [0.25, 0.5, 1.0]


class Arguments(NamedTuple):
    """Two arguments that a query takes, the first of them (..., 3), and what it calls them."""

    names: tuple[str, str]
    values: tuple[object, object]
    vectors: int
    """How many of both are (..., 3); the other is (...)."""


def arguments_of(query: str) -> Arguments:
    if query in RAYS:
        return Arguments(("origins", "directions"), (POINT, [0, 0, -1]), 2)
    if query == "overlap_boxes":
        return Arguments(("lower", "upper"), ([0, 0, -1], [1, 1, 1]), 2)
    if query == "overlap_spheres":
        return Arguments(("centers", "radii"), (POINT, 2.0), 1)
    return Arguments(("points", ""), (POINT, None), 1)


def ask(bvh, query, first=None, second=None):
    names, (usual, other), _ = arguments_of(query)
    rest = () if not names[1] else (other if second is None else second,)
    return getattr(bvh, query)(usual if first is None else first, *rest)


def is_empty(query, answer) -> bool:
    """What the query documents for nothing: no hit, no face, infinitely far, outside."""
    if query in ("intersect", "closest_point"):
        return bool((answer.face == -1).all())
    if query == "traversal_cost":
        return bool((answer.triangles == 0).all())
    if query in ("intersect_all", "overlap_boxes", "overlap_spheres"):
        return len(answer.face) == 0 and not answer.offsets.any()
    if query in ("distance", "signed_distance"):
        return bool(np.isinf(answer).all())
    if query == "winding_number":
        return bool((np.isnan(answer) | (answer == 0)).all())
    return not np.any(answer)


def arrays_of(answer):
    return answer if isinstance(answer, tuple) else (answer,)


@pytest.fixture(scope="module", params=LAYOUTS)
def bvh(request):
    return treelet.build(TRIANGLE_VERTICES, TRIANGLE_FACES, request.param)


@pytest.mark.parametrize("query", QUERIES)
def test_the_usual_arguments_find_the_triangle(bvh, query):
    assert not is_empty(query, ask(bvh, query)) or query in ("contains", "winding_number")


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("query", QUERIES)
def test_points_that_are_not_finite_meet_nothing(bvh, query, axis, bad):
    point = np.array(POINT)
    point[axis] = bad
    if query == "overlap_boxes" and bad == -np.inf:  # a box may reach to infinity
        assert not is_empty(query, ask(bvh, query, np.minimum([0, 0, -1], point)))
    else:
        assert is_empty(query, ask(bvh, query, point))


@pytest.mark.parametrize(
    "direction", [[0, 0, 0], [-0.0, 0, 0], [np.nan, 0, -1], [0, 0, -np.inf], [1e-50, 0, 0]]
)
@pytest.mark.parametrize("query", RAYS)
def test_rays_without_a_direction_miss(bvh, query, direction):
    assert is_empty(query, ask(bvh, query, second=np.array(direction)))


@pytest.mark.parametrize(
    "limits", [(2, 1), (np.nan, 1), (0, np.nan), (np.inf, -np.inf), (1.5, np.inf), (0, 0.5)]
)
@pytest.mark.parametrize("query", [query for query in RAYS if query != "traversal_cost"])
def test_limits_that_hold_no_hit(bvh, query, limits):
    assert is_empty(query, getattr(bvh, query)(POINT, [0, 0, -1], *limits))


@pytest.mark.parametrize("radius", [-1, np.nan, -np.inf])
def test_radii_that_hold_nothing(bvh, radius):
    assert is_empty("overlap_spheres", bvh.overlap_spheres(POINT, radius))
    assert is_empty("closest_point", bvh.closest_point(POINT, radius))


@pytest.mark.parametrize("query", QUERIES)
@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize(
    ("vertices", "faces"),
    [
        ([], []),
        (TRIANGLE_VERTICES, np.zeros((0, 3), int)),
        (np.full((3, 3), np.nan), TRIANGLE_FACES),
        (np.array([[0, 0, 0], [np.inf, 0, 0], [0, 1, 0]]), TRIANGLE_FACES),
        (np.zeros((3, 3)), TRIANGLE_FACES),
        (TRIANGLE_VERTICES, [[0, 1, 1]]),
    ],
    ids=["nothing", "no faces", "NaN", "infinity", "a point", "a line"],
)
def test_meshes_of_nothing_are_met_by_nothing(query, layout, vertices, faces):
    bvh = treelet.build(vertices, faces, layout)
    assert is_empty(query, ask(bvh, query))
    assert bvh.validate() == []


@pytest.mark.parametrize(
    ("query", "which"), [(query, i) for query in QUERIES for i in range(arguments_of(query).vectors)]
)
@pytest.mark.parametrize("shape", [(), (2,), (4,), (3, 2), (0,)])
def test_wrong_shapes_are_named(bvh, query, which, shape):
    names = arguments_of(query).names
    message = f"{names[which]} must have shape (..., 3), not {shape}"
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        ask(bvh, query, **{("first", "second")[which]: np.zeros(shape)})


@pytest.mark.parametrize("query", [query for query in QUERIES if query not in POINTS])
def test_shapes_that_do_not_fit_are_named(bvh, query):
    names, _, vectors = arguments_of(query)
    second = np.ones((5, 3)) if vectors == 2 else np.ones(5)
    with pytest.raises(ValueError, match=rf"{names[0]}.*\(2.*{names[1]}.*\(5.* cannot be broadcast") as error:
        ask(bvh, query, np.ones((2, 3)), second)
    assert "against each other" in str(error.value)


@pytest.mark.parametrize(
    ("query", "which"), [(query, i) for query in QUERIES for i in (0, 1) if arguments_of(query).names[i]]
)
@pytest.mark.parametrize(
    "values",
    [[[True] * 3], [["a"] * 3], np.ones((1, 3), complex), np.ones((1, 3), object), np.ones((1, 3), "M8[s]")],
    ids=["bool", "text", "complex", "object", "date"],
)
def test_wrong_types_are_named(bvh, query, which, values):
    names = arguments_of(query).names
    message = f"{names[which]} must hold real numbers, not {np.asarray(values).dtype}"
    with pytest.raises(TypeError, match=f"^{re.escape(message)}$"):
        ask(bvh, query, **{("first", "second")[which]: values})


def in_other_memory(array):
    read_only = array.copy()
    read_only.flags.writeable = False
    return {
        "fortran": np.asfortranarray(array),
        "strided": np.repeat(array, 2, axis=0)[::2],
        "backwards": array[::-1].copy()[::-1],
        "read-only": read_only,
        "big-endian": array.astype(">f4"),
        "float64": array.astype(np.float64),
        "list": array.tolist(),
    }


@pytest.mark.parametrize("query", QUERIES)
@pytest.mark.parametrize("memory", list(in_other_memory(TRIANGLE_VERTICES)))
def test_memory_does_not_matter(query, memory):
    vertices, faces = torus(12, 8)
    bvh = treelet.build(vertices, faces)
    first = np.random.default_rng(1).uniform(-1.5, 1.5, (40, 3)).astype(np.float32)
    second = -first if arguments_of(query).vectors == 2 else None
    other = in_other_memory(first)[memory]
    expected, answer = ask(bvh, query, first, second), ask(bvh, query, other, second)
    for ours, theirs in zip(arrays_of(answer), arrays_of(expected), strict=True):
        np.testing.assert_array_equal(ours, theirs)
    np.testing.assert_array_equal(np.asarray(other, np.float32), first)


@pytest.mark.parametrize("scale", [1e-44, 1e-38, 1e19, 1e38])
@pytest.mark.parametrize("query", QUERIES)
@pytest.mark.parametrize("layout", LAYOUTS)
def test_extreme_sizes_answer_without_warnings(query, scale, layout):
    vertices, faces = random_triangles(50)
    vertices = (vertices.astype(np.float64) * scale).astype(np.float32)
    bvh = treelet.build(vertices, faces, layout)
    for first in (vertices, np.full(3, 3e38), np.full(3, 1e-45), [1e300, 0, 0], -vertices):
        ask(bvh, query, first)
    assert bvh.validate(vertices, faces) == []


@pytest.mark.parametrize("layout", LAYOUTS)
def test_duplicate_faces_count_each_and_the_first_wins(layout):
    bvh = treelet.build(TRIANGLE_VERTICES, np.repeat(TRIANGLE_FACES, 30, axis=0), layout)
    assert bvh.intersect(POINT, [0, 0, -1]).face == 0
    assert bvh.closest_point(POINT).face == 0
    assert bvh.count_hits(POINT, [0, 0, -1]) == 30
    for listed in (
        bvh.intersect_all(POINT, [0, 0, -1]),
        ask(bvh, "overlap_boxes"),
        ask(bvh, "overlap_spheres"),
    ):
        assert listed.face.tolist() == list(range(30))
    assert not bvh.contains([0.2, 0.2, 0.1])


@pytest.mark.parametrize(
    ("faces", "words"),
    [
        ([[0, 1, 3]], "face 0 refers to vertex 3, but the mesh has vertices 0 to 2"),
        ([[0, 1, 2], [0, -1, 2]], "face 1 refers to vertex -1, but the mesh has vertices 0 to 2"),
    ],
)
@pytest.mark.parametrize("use", [treelet.build, treelet.mesh_hash])
def test_indices_that_name_no_vertex(use, faces, words):
    with pytest.raises(ValueError, match=f"^{re.escape(words)}$"):
        use(TRIANGLE_VERTICES, faces)
