"""Trees are queried from many threads, and other Python threads run meanwhile."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from other_threads import ticks_during
from sample_rays import as_bytes, mixed_rays

import treelet
from treelet import scenes


@pytest.fixture(scope="module")
def mesh():
    return scenes.make("city", 20_000)


@pytest.fixture(scope="module")
def bvh(mesh):
    return treelet.build(mesh.vertices, mesh.faces)


@pytest.fixture(scope="module")
def rays(mesh):
    return mixed_rays(mesh, 20_000, seed=4)


@pytest.fixture(autouse=True)
def restore_threads():
    before = treelet.thread_count()
    yield
    treelet.set_thread_count(before)


def test_same_answers_for_any_number_of_threads(bvh, rays):
    answers = set()
    for threads in (1, 2, 4):
        treelet.set_thread_count(threads)
        answers.add(as_bytes([*bvh.intersect(*rays), bvh.occluded(*rays), *bvh.traversal_cost(*rays)]))
    assert len(answers) == 1


@pytest.mark.parametrize("threads", [1, 2])
def test_same_answers_from_many_callers_at_once(bvh, rays, threads):
    treelet.set_thread_count(threads)
    expected = as_bytes(bvh.intersect(*rays))
    with ThreadPoolExecutor(4) as pool:
        answers = list(pool.map(lambda _: as_bytes(bvh.intersect(*rays)), range(12)))
    assert answers == [expected] * 12


def test_trees_are_built_from_many_callers_at_once(mesh, bvh, rays):
    def build_and_trace(_):
        return as_bytes(treelet.build(mesh.vertices, mesh.faces).intersect(*rays))

    with ThreadPoolExecutor(4) as pool:
        assert set(pool.map(build_and_trace, range(8))) == {as_bytes(bvh.intersect(*rays))}


def test_threads_may_change_while_others_trace(bvh, rays):
    expected = as_bytes(bvh.intersect(*rays))
    with ThreadPoolExecutor(3) as pool:
        answers = [pool.submit(lambda: as_bytes(bvh.intersect(*rays))) for _ in range(12)]
        for count in (1, 3, 2, 4, 1):
            treelet.set_thread_count(count)
        assert all(answer.result() == expected for answer in answers)


def repeated(mesh, times):
    """Copies of a mesh side by side."""
    shift = np.float32([2, 0, 0]) * np.ptp(mesh.vertices, axis=0)
    vertices = np.concatenate([mesh.vertices + shift * np.float32(copy) for copy in range(times)])
    faces = np.concatenate([mesh.faces + copy * len(mesh.vertices) for copy in range(times)])
    return treelet.Mesh(vertices, faces)


def build_call(mesh, rays, size):
    larger = repeated(mesh, size)
    return lambda: treelet.build(larger.vertices, larger.faces, "sweep")


def query_call(name):
    def make(mesh, rays, size):
        bvh = treelet.build(mesh.vertices, mesh.faces)
        more = [np.tile(array, (20 * size, 1)) for array in rays]
        return lambda: getattr(bvh, name)(*more)

    return make


def brute_force_call(mesh, rays, size):
    some = [array[: 250 * size] for array in rays]
    return lambda: treelet.intersect_brute_force(mesh.vertices, mesh.faces, *some)


def epo_call(mesh, rays, size):
    larger = repeated(mesh, size)
    bvh = treelet.build(larger.vertices, larger.faces)
    return lambda: bvh.report.epo


def validate_call(mesh, rays, size):
    larger = repeated(mesh, 4 * size)
    bvh = treelet.build(larger.vertices, larger.faces)
    return lambda: bvh.validate(larger.vertices, larger.faces)


LONG_CALLS = {
    "build": build_call,
    "intersect": query_call("intersect"),
    "occluded": query_call("occluded"),
    "traversal_cost": query_call("traversal_cost"),
    "brute_force": brute_force_call,
    "epo": epo_call,
    "validate": validate_call,
}


@pytest.mark.parametrize("name", LONG_CALLS)
def test_other_python_threads_run_meanwhile(mesh, rays, name):
    """The same call is made longer until this thread ran often enough; against a held GIL it never does."""
    treelet.set_thread_count(1)
    size = 1
    while (ticks := ticks_during(LONG_CALLS[name](mesh, rays, size))) < 10 and size < 16:
        size *= 2
    assert ticks >= 10
