"""What tools/fuzz.py tries: each case is a function of a random generator that does one thing to treelet.

A case passes when it ends, well or with one of the errors in ALLOWED; a wrong answer is an AssertionError.
"""

from __future__ import annotations

import copy
import pickle
import tempfile
from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any

import fuzz_files
import fuzz_values
import numpy as np

import treelet

_FOLDER = tempfile.TemporaryDirectory(prefix="treelet-fuzz-")
_BUILDERS = ("lbvh", "hploc", "ploc", "hlbvh", "gridsah", "binned", "sweep", "sbvh", "presplit > lbvh")
_OPTIMIZERS = (
    "",
    "",
    "",
    " > treelet",
    " > reinsert",
    " > insert(batches=2)",
    " > rotate(rounds=2)",
    " > atr(size=5)",
)
_LAYOUTS = ("bvh2", "bvh8", "cwbvh")
_PIECES = (
    ">",
    "(",
    ")",
    ",",
    "=",
    "-1",
    "0",
    "9",
    "99999999999999999999",
    "size",
    "rounds",
    "é",
    "\0",
    "",
    "  ",
    "x",
)


def read_mesh_file(random: Random) -> None:
    """A damaged mesh, which if it can be read can be built and queried too."""
    extension, content = fuzz_files.mesh_file(random)
    if random.random() < 0.1:
        extension = random.choice((".ply", ".obj", ".off", ".stl", ".npz", ".treelet", ".xyz"))
    if random.random() < 0.95:
        content = fuzz_values.damaged(random, content)
    else:
        content = random.randbytes(random.randrange(400))
    path = _write(f"mesh{extension}", content)
    mesh = treelet.load_mesh(path)
    assert mesh.faces.shape[1] == mesh.vertices.shape[1] == 3
    assert len(mesh.faces) > 0
    compare_with_brute_force(random, mesh.vertices, mesh.faces)


def read_tree_file(random: Random) -> None:
    """A damaged tree, its checksums mended or not; one that loads answers, whatever it answers."""
    tree = treelet.build(*fuzz_values.mesh(random), _recipe(random))
    content = tree.__reduce__()[1][0]
    if random.random() < 0.02:
        content = random.randbytes(random.randrange(1000))
    elif random.random() < 0.95:
        content = fuzz_values.damaged(random, content)
    if random.random() < 0.7:
        content = fuzz_files.resealed(content)
    if random.random() < 0.2:
        loaded = tree.__reduce__()[0](content)
    else:
        path = _write("tree.treelet", content)
        loaded = treelet.load(path, mmap=random.random() < 0.5, verify=random.random() < 0.2)
    use(random, loaded, np.zeros((1, 3), np.float32))


def build_arrays(random: Random) -> None:
    """Arrays that are nearly a mesh, or nothing of the kind."""
    vertices, faces = fuzz_values.mesh(random)
    if random.random() < 0.3:
        vertices = fuzz_values.anything(random)
    if random.random() < 0.3:
        faces = fuzz_values.anything(random)
    elif len(faces) and random.random() < 0.3:
        faces[random.randrange(len(faces))] = random.choice((0, 1, 2**31 - 1, len(vertices)))
    if random.random() < 0.3:
        treelet.mesh_hash(vertices, faces)
    treelet.build(vertices, faces, validate=random.random() < 0.5)


def check_answers(random: Random) -> None:
    """Odd rays at odd meshes hit what brute force says."""
    compare_with_brute_force(random, *fuzz_values.mesh(random))


def build_by_recipe(random: Random) -> None:
    """Text that may be a recipe; what is one builds."""
    text = _recipe(random)
    for _ in range(random.randrange(4)):
        at = random.randrange(len(text) + 1)
        text = text[:at] + random.choice(_PIECES) + text[at + random.randrange(4) :]
    if random.random() < 0.3:
        word = random.choice(treelet.recipe_words())
        values = [
            f"{each.name}={random.choice((each.minimum, each.maximum, each.maximum + 1))}"
            for each in word.parameters
        ]
        text = f"lbvh > {word.name}({', '.join(values)})"
    canonical = treelet.parse_recipe(text)
    assert treelet.parse_recipe(canonical) == canonical
    if "seed=" not in text and not any(len(digits) > 3 for digits in canonical.replace("=", " ").split()):
        vertices, faces = fuzz_values.mesh(random, 12)
        assert treelet.build(vertices, faces, canonical, validate=True).validate(vertices, faces) == []


def call_queries(random: Random) -> None:
    """Every query, with arguments of any kind."""
    vertices, faces = fuzz_values.mesh(random)
    use(random, treelet.build(vertices, faces, _recipe(random)), vertices)


def call_with_anything(random: Random) -> None:
    """One call with arguments that no documentation promises to take."""
    vertices, faces = fuzz_values.mesh(random, 8)
    tree = treelet.build(vertices, faces, updatable=random.random() < 0.5)
    names = [name for name in dir(tree) if not name.startswith("_") and callable(getattr(tree, name))]
    call: Callable[..., Any] = getattr(tree, random.choice(names))
    if random.random() < 0.2:
        call = random.choice(
            (treelet.build, treelet.load, treelet.load_mesh, treelet.parse_recipe, treelet.mesh_hash)
        )
    arguments = [fuzz_values.anything(random) for _ in range(random.randrange(4))]
    if random.random() < 0.3 and arguments:
        arguments[0] = vertices
    if (
        call.__name__ in ("save", "load", "load_mesh")
        and arguments
        and not isinstance(arguments[0], str | bytes)
    ):
        arguments[0] = random.choice((Path(_FOLDER.name) / "no" / "folder", Path(_FOLDER.name), "\0", ""))
    elif call.__name__ == "save":
        return
    answer = call(*arguments)
    if call.__name__ == "stream_hits":
        list(answer)


def update_trees(random: Random) -> None:
    """Refits and rebuilds, in any order; the tree and its copies are sound after each."""
    vertices, faces = fuzz_values.mesh(random, 20)
    tree = treelet.build(vertices, faces, _recipe(random), updatable=True)
    for _ in range(random.randrange(1, 5)):
        vertices = _moved(random, vertices)
        random.choice((tree.refit, tree.rebuild))(vertices)
        treelet.set_thread_count(random.choice((1, 2, 5)))
        for each in (tree, _copied(random, tree)):
            assert each.validate() == [], each.validate()
            repr(each)


def _copied(random: Random, tree: treelet.Bvh) -> treelet.Bvh:
    kind = random.randrange(3)
    if kind == 0:
        return copy.copy(tree)
    if kind == 1:
        return pickle.loads(pickle.dumps(tree))
    path = Path(_FOLDER.name) / "copy.treelet"
    tree.save(path)
    return treelet.load(path, mmap=random.random() < 0.5)


def compare_with_brute_force(random: Random, vertices: Any, faces: Any) -> None:
    """The same hits as every triangle tested, and a sound tree."""
    tree = treelet.build(vertices, faces, _recipe(random), validate=random.random() < 0.2)
    assert tree.validate(vertices, faces) == [], tree.validate(vertices, faces)
    shape = fuzz_values.shape(random)
    near = np.asarray(vertices)
    origins, directions = (fuzz_values.vectors(random, shape, near) for _ in range(2))
    limits = (
        (0.0, np.inf)
        if random.random() < 0.5
        else tuple(fuzz_values.numbers(random, shape) for _ in range(2))
    )
    hits = tree.intersect(origins, directions, *limits, reorder=random.random() < 0.2)
    expected = treelet.intersect_brute_force(vertices, faces, origins, directions, *limits)
    if not np.asarray(tree.offset).any():  # brute force chooses its own
        for name, ours, theirs in zip(hits._fields, hits, expected, strict=True):
            assert np.array_equal(ours, theirs), f"{name}: {ours} is not {theirs}"
    assert np.array_equal(tree.occluded(origins, directions, *limits), hits.face >= 0)


def use(random: Random, tree: treelet.Bvh, near: Any) -> None:
    """All queries of a tree; what two of them say together holds."""
    shape = fuzz_values.shape(random)
    origins, directions = (fuzz_values.vectors(random, shape, near) for _ in range(2))
    limits = fuzz_values.numbers(random, shape), fuzz_values.numbers(random, shape)
    assert np.array_equal(
        tree.occluded(origins, directions, *limits), tree.intersect(origins, directions, *limits).face >= 0
    )
    listed = tree.intersect_all(origins, directions, *limits, reorder=random.random() < 0.5)
    assert np.array_equal(np.diff(listed.offsets), tree.count_hits(origins, directions, *limits).ravel())
    chunks = list(tree.stream_hits(origins, directions, *limits, max_hits=random.choice((1, 5, 10**6))))
    assert sum(len(chunk.hits.t) for chunk in chunks) == len(listed.t)
    tree.traversal_cost(origins, directions, *limits)
    nearest = tree.closest_point(origins)
    assert np.array_equal(nearest.distance, tree.distance(origins))
    assert np.array_equal(np.abs(tree.signed_distance(origins)), nearest.distance)
    tree.closest_point(origins, limits[0])
    assert (
        tree.contains(origins).shape
        == tree.winding_number(origins, random.choice((1, 2, 1e9, np.inf))).shape
        == shape
    )
    boxes, balls = tree.overlap_boxes(origins, directions), tree.overlap_spheres(origins, limits[0])
    assert boxes.offsets[-1] == len(boxes.face)
    assert balls.offsets[-1] == len(balls.face)
    tree.validate()
    str(tree.report.stages), tree.report.recipe, tree.bounds, tree.mesh_hash, repr(tree)


def _moved(random: Random, vertices: Any) -> Any:
    moved = np.array(vertices)
    with np.errstate(all="ignore"):
        moved = (moved * random.choice((1, -1, 3, 1e-10, 1e10)) + random.choice((0, 1, 1e6))).astype(
            moved.dtype
        )
    if random.random() < 0.3:
        fuzz_values.put_nasty(random, moved)
    return moved


def _recipe(random: Random) -> str:
    return random.choice(_BUILDERS) + random.choice(_OPTIMIZERS) + " > " + random.choice(_LAYOUTS)


def _write(name: str, content: bytes) -> Path:
    path = Path(_FOLDER.name) / name
    path.unlink(missing_ok=True)  # who has the old one mapped keeps it
    path.write_bytes(content)
    return path


_ARGUMENTS = (ValueError, TypeError)
# What each case may end with: documented errors, and no other.
ALLOWED: dict[Callable[[Random], None], tuple[type[Exception], ...]] = {
    read_mesh_file: (ValueError, MemoryError),
    read_tree_file: (treelet.FileError,),
    build_arrays: _ARGUMENTS,
    check_answers: (),
    build_by_recipe: (ValueError,),
    call_queries: (),
    call_with_anything: (*_ARGUMENTS, OSError, RuntimeError),
    update_trees: (),
}
CASES = {case.__name__: case for case in ALLOWED}
