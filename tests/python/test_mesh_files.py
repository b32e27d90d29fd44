"""The readers of STL, PLY, OBJ and OFF, down to damaged files; every error by its words."""

import re
import struct

import numpy as np
import pytest

from treelet.mesh import load_mesh

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [-1, 0.5, 0]], dtype=np.float32)
FANS = [[0, 1, 2], [0, 2, 3], [4, 3, 2], [0, 1, 2], [0, 2, 3], [0, 3, 4]]
POLYGONS = [[0, 1, 2, 3], [4, 3, 2], [0, 1, 2, 3, 4]]


def load(tmp_path, name, content):
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return load_mesh(path)


def assert_refused(tmp_path, name, content, reason):
    path = tmp_path / name
    message = f"{path}: cannot be read as {path.suffix}: {reason}"
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        load(tmp_path, name, content)


def binary_ply(polygons, order="<", extra="", count=None):
    name = "little" if order == "<" else "big"
    header = (
        f"ply\nformat binary_{name}_endian 1.0\ncomment words\nelement vertex {len(CORNERS)}\n"
        "property float x\nproperty float y\nproperty float z\nproperty uchar red\n"
        f"element face {len(polygons) if count is None else count}\n"
        f"property list uchar int vertex_indices\n{extra}end_header\n"
    )
    body = b"".join(struct.pack(f"{order}3fB", *corner, 7) for corner in CORNERS)
    for polygon in polygons:
        body += struct.pack(f"{order}B{len(polygon)}i", len(polygon), *polygon)
        body += struct.pack(f"{order}f", 0.5) if extra else b""
    return header.encode() + body


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("extra", ["", "property float quality\n"])
def test_binary_ply_of_mixed_polygons(tmp_path, order, extra):
    mesh = load(tmp_path, "a.ply", binary_ply(POLYGONS, order, extra))
    np.testing.assert_array_equal(mesh.faces, FANS)
    np.testing.assert_array_equal(mesh.vertices, CORNERS)
    assert mesh.vertices.dtype == np.float32


@pytest.mark.parametrize("order", ["<", ">"])
def test_binary_ply_of_quads_and_of_triangles(tmp_path, order):
    quads = load(tmp_path, "a.ply", binary_ply([[0, 1, 2, 3], [4, 3, 2, 1]], order))
    np.testing.assert_array_equal(quads.faces, [[0, 1, 2], [0, 2, 3], [4, 3, 2], [4, 2, 1]])
    triangles = load(tmp_path, "a.ply", binary_ply([[0, 1, 2], [4, 3, 2]], order, "property float quality\n"))
    np.testing.assert_array_equal(triangles.faces, [[0, 1, 2], [4, 3, 2]])


@pytest.mark.parametrize("polygons", [POLYGONS, [[0, 1, 2], [4, 3, 2]]])
def test_binary_ply_that_announces_too_many_faces(tmp_path, polygons):
    reason = "damaged: it ends within the 900 rows of 'face' that it announces"
    assert_refused(tmp_path, "a.ply", binary_ply(polygons, count=900), reason)


def test_binary_ply_cut_off_in_its_vertices(tmp_path):
    content = binary_ply(POLYGONS)
    reason = f"damaged: it ends within the {len(CORNERS)} rows of 'vertex' that it announces"
    assert_refused(tmp_path, "a.ply", content[: content.index(b"end_header\n") + 20], reason)


TEXT_PLY = """ply
format ascii 1.0
element vertex {vertices}
property {type} x
property {type} y
property {type} z
element face 1
property list uchar int vertex_indices
end_header
0.1 0 0
1 0 0
0 1 0
3 0 1 2
"""


def test_text_ply_keeps_the_precision_it_names(tmp_path):
    double = load(tmp_path, "a.ply", TEXT_PLY.format(vertices=3, type="double"))
    assert double.vertices[0, 0] == np.float64(0.1)
    single = load(tmp_path, "a.ply", TEXT_PLY.format(vertices=3, type="float"))
    assert single.vertices.dtype == np.float32


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (
            TEXT_PLY.format(vertices=9, type="float"),
            "damaged: it ends within the 9 rows of 'vertex' that it announces",
        ),
        (TEXT_PLY.format(vertices=3, type="flaot"), "damaged: its header says 'property flaot x'"),
        (
            TEXT_PLY.format(vertices=-3, type="float"),
            "damaged: its header names no format, or a negative count",
        ),
        ("ply\nformat", "damaged: it has no whole header, from the word ply to end_header"),
        (TEXT_PLY.format(vertices=3, type="float").replace("float z", "float w"), "its vertices have no z"),
    ],
)
def test_damaged_text_ply(tmp_path, content, reason):
    assert_refused(tmp_path, "a.ply", content, reason)


def binary_stl(header=b"solid from an exporter", count=2):
    return header.ljust(80) + struct.pack("<I", count) + struct.pack("<12fH", *range(12), 0) * 2


def text_stl(name=b"part"):
    corners = b"".join(b"  vertex %s\n" % corner for corner in (b"0 0 0", b"1 0 0", b"0 1e0 -2.5"))
    facet = b"facet normal 0 0 1\n outer loop\n" + corners + b" endloop\nendfacet\n"
    return b"solid " + name + b"\n" + facet * 2 + b"endsolid\n"


def test_stl_binary_and_text(tmp_path):
    binary = load(tmp_path, "a.stl", binary_stl())
    np.testing.assert_array_equal(binary.vertices[3:], np.arange(3, 12).reshape(3, 3))
    np.testing.assert_array_equal(binary.faces, [[0, 1, 2], [3, 4, 5]])
    text = load(tmp_path, "a.stl", text_stl("Würfel".encode("latin-1")))
    np.testing.assert_array_equal(text.vertices[3:], [[0, 0, 0], [1, 0, 0], [0, 1, -2.5]])


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (
            binary_stl()[:-10].replace(b" ", b"\0"),
            "damaged: 2 triangles are announced, which take 184 bytes, but it has 174",
        ),
        (binary_stl()[:-10], "damaged: 2 triangles are announced, which take 184 bytes, but it has 174"),
        (text_stl()[:-30], "damaged: the text ends after 1 whole triangles, without an endsolid"),
        (text_stl()[:-9], "damaged: the text ends after 2 whole triangles, without an endsolid"),
        (b"\2" * 20, "damaged: it has 20 bytes, fewer than the header's 84"),
    ],
)
def test_cut_off_stl(tmp_path, content, reason):
    assert_refused(tmp_path, "a.stl", content, reason)


def test_obj_may_be_indented_and_marked_as_utf_8(tmp_path):
    mesh = load(tmp_path, "a.obj", "\ufeffv 0 0 0\n v 1 0 0\n\tv 0 1 0\r\n  f 1 2 \\\n 3\n")
    np.testing.assert_array_equal(mesh.vertices, [[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    np.testing.assert_array_equal(mesh.faces, [[0, 1, 2]])


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("v 0 0 0\nv 0 0\n", "line 2: a vertex has 2 coordinates, but needs 3"),
        ("v 0 0 0\n\nv 0 x 0\n", "line 3: '0 x 0' are not three numbers"),
        ("v 0 0 0\nf 1 \\\n 1 a\n", "line 3: 'a' is not a whole number"),
        ("v 0 0 0\nf 1 1 0\n", "line 2: a face names vertex 0, but OBJ counts from 1"),
    ],
)
def test_obj_errors_name_the_line(tmp_path, text, reason):
    assert_refused(tmp_path, "a.obj", text, reason)


@pytest.mark.parametrize("kind", ["OFF", "COFF", "NOFF", "CNOFF", "STOFF", "STCNOFF"])
def test_off_of_every_kind_with_three_dimensions(tmp_path, kind):
    rows = "".join(f"{x} {y} {z} 9 9 9 9\n" for x, y, z in CORNERS)
    mesh = load(tmp_path, "a.off", f"\ufeff{kind}\n5 1 0\n{rows}  4 0 1 2 3 255 0 0\n")
    np.testing.assert_array_equal(mesh.vertices, CORNERS)
    np.testing.assert_array_equal(mesh.faces, [[0, 1, 2], [0, 2, 3]])


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("4OFF\n1 0 0\n0 0 0 1\n", "it is of kind 4OFF, but only points of three dimensions can be read"),
        ("nOFF 3\n1 0 0\n0 0 0\n", "it is of kind nOFF, but only points of three dimensions can be read"),
        ("ST4OFF\n", "it is of kind ST4OFF, but only points of three dimensions can be read"),
        ("OFF BINARY\n", "it is a binary OFF, but only the text format can be read"),
        ("OFF\n3\n", "line 2: the numbers of vertices and faces must stand here"),
        ("OFF\n1 1 0\n0 0\n1 0\n", "line 3: a vertex has 2 coordinates, but needs 3"),
        ("OFF\n1 1 0\n0 0 0\n# words\n4 0 0 0\n", "line 5: a face of 4 corners names 3 vertices"),
        ("OFF\n1 1 0\n0 0 0\n-1 0 0 0\n", "line 4: a face of -1 corners names 3 vertices"),
        ("OFF\n1 1 0\n0 0 0\n3 0 0 0.5\n", "line 4: '0.5' is not a whole number"),
    ],
)
def test_off_errors_name_the_line(tmp_path, text, reason):
    assert_refused(tmp_path, "a.off", text, reason)


def test_directory_is_said_to_be_one(tmp_path):
    path = tmp_path / "dir.ply"
    path.mkdir()
    with pytest.raises(IsADirectoryError, match=f"^{re.escape(str(path))}: is a directory, not a mesh file$"):
        load_mesh(path)


@pytest.mark.parametrize("name", ["a.obj", "a.npz"])
def test_frame_of_what_is_no_animation(tmp_path, name):
    path = tmp_path / name
    if name == "a.npz":
        np.savez(path, vertices=CORNERS, faces=[[0, 1, 2]])
    else:
        path.write_text("v 0 0 0\nf 1 1 1\n")
    assert len(load_mesh(path, frame=0).faces) == 1
    with pytest.raises(ValueError, match=r"it is no animation, so there is no frame 7$"):
        load_mesh(path, frame=7)
