"""Mesh and load_mesh: every format, face by face, and every error by its words."""

import re
import subprocess
import sys

import numpy as np
import pytest

import treelet
from treelet.mesh import Mesh, load_mesh

VERTICES = np.array(
    [[0, 0, 0], [1, 0, 0.5], [1.25, 1, 0], [0, 1, -2], [0.1, 0.2, 3], [7, 7, 7]], dtype=np.float32
)
# Out of order, an edge shared, one face twice, one degenerate: nothing of it may be tidied up.
FACES = np.array([[3, 1, 0], [0, 1, 2], [4, 2, 3], [0, 1, 2], [4, 4, 1]], dtype=np.int32)


def assert_same_triangles(mesh, vertices=VERTICES, faces=FACES):
    np.testing.assert_array_equal(mesh.vertices[mesh.faces], vertices[faces])


def export(path, vertices=VERTICES, faces=FACES):
    trimesh = pytest.importorskip("trimesh")
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    if path.suffix != ".gltf":
        mesh.export(path)
        return path
    files = trimesh.exchange.gltf.export_gltf(trimesh.Scene(mesh))
    for name, content in files.items():
        (path if name == "model.gltf" else path.parent / name).write_bytes(content)
    return path


@pytest.mark.parametrize("extension", ["ply", "obj", "off", "glb", "gltf"])
def test_round_trip_keeps_vertices_and_faces(tmp_path, extension):
    mesh = load_mesh(export(tmp_path / f"scene.{extension}"))
    np.testing.assert_array_equal(mesh.rounded().vertices, VERTICES)
    np.testing.assert_array_equal(mesh.faces, FACES)
    assert mesh.vertices.dtype == (np.float64 if extension in ("obj", "off") else np.float32)
    assert mesh.faces.dtype == np.int32
    assert mesh.name == "scene"


@pytest.mark.parametrize("extension", ["stl", "STL"])
def test_stl_keeps_order_and_does_not_weld(tmp_path, extension):
    mesh = load_mesh(export(tmp_path / f"scene.{extension}"))
    assert mesh.vertices.shape == (3 * len(FACES), 3)
    assert_same_triangles(mesh)


def test_npz_needs_numpy_alone(tmp_path):
    path = tmp_path / "scene.npz"
    np.savez(path, vertices=VERTICES.astype(np.float64), faces=FACES.astype(np.uint64))
    mesh = load_mesh(str(path))
    np.testing.assert_array_equal(mesh.faces, FACES)
    assert_same_triangles(mesh)


def test_npz_animation_has_frames(tmp_path):
    path = tmp_path / "scene.npz"
    np.savez(path, vertices=np.stack([VERTICES, VERTICES + 1]), faces=FACES)
    assert_same_triangles(load_mesh(path))
    assert_same_triangles(load_mesh(path, frame=1), VERTICES + 1)
    with pytest.raises(
        ValueError, match=r"cannot be read as \.npz: it has 2 frames, so there is no frame 2$"
    ):
        load_mesh(path, frame=2)


OBJ = """# a comment
mtllib missing.mtl
v 0 0 0
v 1 0 0 1
v 1 1 0
vn 0 0 1
vt 0.5 0.5
usemtl red
f 1//1 2//1 3//1
v 0 1 0
v -1e-1 +5E-1 0
usemtl blue
f 1/1/1 2/1/1 3/1/1 4/1/1   # a quad
o thing
g other
usemtl red
f -1 -2 -3
f 1 2 \\
  3 4 5
l 1 2
"""


def test_obj_keeps_order_over_materials_and_fans_polygons(tmp_path):
    path = tmp_path / "scene.obj"
    path.write_text(OBJ)
    mesh = load_mesh(path)
    np.testing.assert_array_equal(
        mesh.faces, [[0, 1, 2], [0, 1, 2], [0, 2, 3], [4, 3, 2], [0, 1, 2], [0, 2, 3], [0, 3, 4]]
    )
    np.testing.assert_array_equal(mesh.vertices, [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [-0.1, 0.5, 0]])


@pytest.mark.parametrize("header", ["OFF\n5 3 0\n", "# words\n\nOFF 5 3 0\n", "COFF\n5 3\n"])
def test_off_fans_polygons_in_order(tmp_path, header):
    path = tmp_path / "scene.off"
    path.write_text(
        header + "0 0 0\n1 0 0\n1 1 0 # corner\n0 1 0\n-1 0.5 0\n4 0 1 2 3\n3 4 3 2 255 0 0\n5 0 1 2 3 4\n"
    )
    np.testing.assert_array_equal(
        load_mesh(path).faces, [[0, 1, 2], [0, 2, 3], [4, 3, 2], [0, 1, 2], [0, 2, 3], [0, 3, 4]]
    )


PLY = """ply
format ascii 1.0
element vertex 5
property double x
property double y
property double z
element face {count}
property list uchar int {name}
end_header
0 0 0
1 0 0
1 1 0
0 1 0
-1 0.5 0
"""


@pytest.mark.parametrize("name", ["vertex_indices", "vertex_index"])
def test_ascii_ply_fans_polygons_in_order(tmp_path, name):
    path = tmp_path / "scene.ply"
    path.write_text(PLY.format(count=3, name=name) + "4 0 1 2 3\n3 4 3 2\n5 0 1 2 3 4\n")
    np.testing.assert_array_equal(
        load_mesh(path).faces, [[0, 1, 2], [0, 2, 3], [4, 3, 2], [0, 1, 2], [0, 2, 3], [0, 3, 4]]
    )
    path.write_text(PLY.format(count=2, name=name) + "4 0 1 2 3\n4 4 3 2 1\n")
    np.testing.assert_array_equal(load_mesh(path).faces, [[0, 1, 2], [0, 2, 3], [4, 3, 2], [4, 2, 1]])


def test_glb_places_each_part(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    part = trimesh.Trimesh(VERTICES, FACES, process=False)
    scene = trimesh.Scene()
    scene.add_geometry(part, node_name="first", geom_name="part")
    mirror = np.diag([-1.0, 1.0, 1.0, 1.0])
    mirror[:3, 3] = (0, 0, 10)
    scene.graph.update(frame_to="second", matrix=mirror, geometry="part")
    scene.export(tmp_path / "scene.glb")
    mesh = load_mesh(tmp_path / "scene.glb")
    assert len(mesh.faces) == 2 * len(FACES)
    halves = [mesh.vertices[mesh.faces[:5]], mesh.vertices[mesh.faces[5:]]]
    plain, mirrored = sorted(halves, key=lambda triangles: triangles[..., 2].mean())
    np.testing.assert_allclose(plain, VERTICES[FACES])
    np.testing.assert_allclose(mirrored, (VERTICES * [-1, 1, 1] + [0, 0, 10])[FACES[:, [0, 2, 1]]])


def test_missing_file(tmp_path):
    path = tmp_path / "nowhere.ply"
    with pytest.raises(FileNotFoundError, match=f"^{re.escape(str(path))}: there is no such mesh file$"):
        load_mesh(path)


def test_unknown_extension(tmp_path):
    path = tmp_path / "scene.fbx"
    known = ".ply, .obj, .stl, .off, .glb, .gltf, .npz"
    with pytest.raises(
        ValueError,
        match=f"^{re.escape(f'{path}: unknown mesh extension {chr(39)}.fbx{chr(39)}; known are {known}')}$",
    ):
        load_mesh(path)


NO_FACES_PLY = PLY.format(count=0, name="vertex_indices")


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.obj", "v 0 0 0\nv 1 0 0\n"),
        ("a.obj", "v 0 0 0\nv 1 0 0\nf 1 2\n"),
        ("a.off", "OFF\n0 0 0\n"),
        ("a.ply", NO_FACES_PLY),
    ],
)
def test_file_without_triangles(tmp_path, name, text):
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(ValueError, match=f"^{re.escape(str(path))}: holds no triangles$"):
        load_mesh(path)


@pytest.mark.parametrize(
    ("name", "content", "reason"),
    [
        ("a.obj", b"v 0 0 0\nf 1 1 9\n", "face 0 names vertex 8, but there are 1 vertices"),
        ("a.obj", b"v 0 0 0\nf 1 1 -2\n", "face 0 names vertex -1, but there are 1 vertices"),
        ("a.off", b"PLY\n", "its first word is not OFF"),
        ("a.off", b"OFF\n2 1 0\n0 0 0\n", "2 vertices and 1 faces are announced, but only 1 lines follow"),
        ("a.npz", b"not a zip", None),
        ("a.glb", b"glTF\x02\x00", None),
        ("a.gltf", b"{", None),
    ],
)
def test_damaged_file_is_named_with_the_reason(tmp_path, name, content, reason):
    if name.endswith(("glb", "gltf")):
        pytest.importorskip("trimesh")
    path = tmp_path / name
    path.write_bytes(content)
    words = ".+" if reason is None else re.escape(reason)
    with pytest.raises(
        ValueError, match=f"^{re.escape(str(path))}: cannot be read as {re.escape(path.suffix)}: {words}$"
    ):
        load_mesh(path)


@pytest.mark.parametrize("missing", ["vertices", "faces"])
def test_npz_without_an_array(tmp_path, missing):
    path = tmp_path / "a.npz"
    np.savez(
        path, **{key: value for key, value in (("vertices", VERTICES), ("faces", FACES)) if key != missing}
    )
    with pytest.raises(ValueError, match=f"cannot be read as .npz: it has no array '{missing}'$"):
        load_mesh(path)


@pytest.mark.parametrize("extension", ["ply", "stl", "glb"])
def test_truncated_binary_file(tmp_path, extension):
    path = export(tmp_path / f"whole.{extension}")
    path.write_bytes(path.read_bytes()[:-20])
    with pytest.raises(ValueError, match=f"{re.escape(str(path))}: cannot be read as"):
        load_mesh(path)


def test_trimesh_missing_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "trimesh", None)
    (tmp_path / "a.glb").write_bytes(b"glTF")
    with pytest.raises(
        ImportError, match=r"^reading \.glb files needs trimesh: pip install treelet\[mesh\]$"
    ):
        load_mesh(tmp_path / "a.glb")


def test_import_loads_numpy_alone():
    modules = ("trimesh", "scipy", "PIL")
    code = f"import sys, treelet.mesh, treelet.scenes; print([m for m in {modules} if m in sys.modules])"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout == "[]\n"


def test_mesh_converts_and_checks():
    mesh = Mesh(VERTICES.astype(np.float16), FACES.astype(np.int64)[:, ::1], "box")
    assert mesh.vertices.dtype == np.float64
    mesh = Mesh(VERTICES, FACES.astype(np.int64), "box")
    assert mesh.vertices.dtype == np.float32
    assert mesh.rounded() is mesh
    assert mesh.faces.dtype == np.int32
    assert repr(mesh) == "Mesh('box', 5 triangles, 6 vertices, 0 views)"
    np.testing.assert_array_equal(mesh.bounds, [VERTICES.min(axis=0), VERTICES.max(axis=0)])
    np.testing.assert_array_equal(Mesh(np.zeros((0, 3)), np.zeros((0, 3), int)).bounds, np.zeros((2, 3)))


def test_float64_is_kept_for_trees_and_rounding_it_warns(tmp_path):
    path = tmp_path / "far.npz"
    far = VERTICES.astype(np.float64) + 5e6 + 0.1
    np.savez(path, vertices=far, faces=FACES)
    mesh = load_mesh(path)
    np.testing.assert_array_equal(mesh.vertices, far)
    assert mesh.bounds.dtype == np.float64
    message = r"^rounding the vertices to float32 moves them by up to 0\.[12]\d*, in a mesh of extent 9: "
    with pytest.warns(treelet.PrecisionWarning, match=message):
        mesh.rounded()
    assert treelet.build(mesh.vertices, mesh.faces).report.vertex_rounding < 1e-6
    near = Mesh(mesh.vertices - 5e6, mesh.faces, views=mesh.views).rounded()
    np.testing.assert_allclose(near.vertices, VERTICES + 0.1, atol=1e-6)


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        (VERTICES[:, :2], FACES, r"vertices must have shape \(n, 3\), not \(6, 2\)"),
        (VERTICES, FACES[0], r"faces must have shape \(n, 3\), not \(3,\)"),
        (VERTICES, FACES.astype(float), "faces must be integers, not float64"),
        (VERTICES[:4], FACES, "face 2 names vertex 4, but there are 4 vertices"),
        (VERTICES, FACES - 1, "face 0 names vertex -1, but there are 6 vertices"),
    ],
)
def test_mesh_rejects(vertices, faces, message):
    with pytest.raises(ValueError, match=f"^{message}$"):
        Mesh(vertices, faces)
