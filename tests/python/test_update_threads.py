"""Updates and other threads: one user at a time, and Python runs on meanwhile."""

import contextlib
import threading
import time

import numpy as np
import pytest
from other_threads import ticks_during
from sample_rays import as_bytes, mixed_rays

import treelet
from treelet import scenes


@pytest.fixture(scope="module")
def city():
    return scenes.make("city", 20_000)


def run_beside(work, attempt):
    """Runs work() in another thread; returns what attempt() raised while it ran, or None."""

    def work_unless_refused():
        with contextlib.suppress(RuntimeError):  # attempt() may be there first
            work()

    thread = threading.Thread(target=work_unless_refused)
    thread.start()
    try:
        while thread.is_alive():
            try:
                attempt()
            except RuntimeError as error:
                return str(error)
            time.sleep(0)
        return None
    finally:
        thread.join()


def until_refused(make_work, attempt):
    """The overlap depends on luck, so the work is made longer until there is one."""
    for size in (1, 4, 16, 64):
        if refusal := run_beside(make_work(size), attempt):
            return refusal
    return None


def test_an_update_beside_a_query_is_refused(city):
    bvh = treelet.build(city.vertices, city.faces, updatable=True)
    rays = mixed_rays(city, 20_000, seed=4)

    def query(size):
        many = [np.tile(array, (size, 1)) for array in rays]
        return lambda: bvh.intersect(*many)

    refusal = until_refused(query, lambda: bvh.refit(city.vertices))
    assert refusal == "another thread uses this tree: update it before or after"


def test_queries_and_updates_beside_an_update_are_refused(city):
    bvh = treelet.build(city.vertices, city.faces, updatable=True)

    def rebuild(size):
        return lambda: [bvh.rebuild(city.vertices) for _ in range(size)]

    attempts = {
        "intersect": lambda: bvh.intersect([0, 0, 9], [0, 0, -1]),
        "occluded": lambda: bvh.occluded([0, 0, 9], [0, 0, -1]),
        "traversal_cost": lambda: bvh.traversal_cost([0, 0, 9], [0, 0, -1]),
        "validate": bvh.validate,
        "bounds": lambda: bvh.bounds,
    }
    for attempt in attempts.values():
        with bvh._guard.update(), pytest.raises(RuntimeError, match=r"^another thread updates this tree"):
            attempt()
        attempt()  # and now it may
    with bvh._guard.update():
        with pytest.raises(RuntimeError, match=r"^another thread updates this tree"):
            _ = bvh.report.epo
        with pytest.raises(RuntimeError, match=r"^another thread uses this tree"):
            bvh.refit(city.vertices)
    with bvh._guard.query(), bvh._guard.query(), pytest.raises(RuntimeError):
        bvh.rebuild(city.vertices)
    refusal = until_refused(rebuild, attempts["intersect"])
    assert refusal == "another thread updates this tree: query it before or after"


def test_queries_may_overlap(city):
    bvh = treelet.build(city.vertices, city.faces, updatable=True)
    rays = mixed_rays(city, 5_000, seed=4)
    expected = as_bytes(bvh.intersect(*rays))
    answers = []
    threads = [
        threading.Thread(target=lambda: answers.append(as_bytes(bvh.intersect(*rays)))) for _ in range(4)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert answers == [expected] * 4


def test_other_python_threads_run_during_an_update(city):
    copies = [city.vertices + np.float32([100 * copy, 0, 0]) for copy in range(8)]
    faces = np.concatenate([city.faces + copy * len(city.vertices) for copy in range(8)])
    vertices = np.concatenate(copies)
    bvh = treelet.build(vertices, faces, updatable=True)
    for update in (bvh.refit, bvh.rebuild):
        for repeats in (1, 4, 16, 64):
            ticks = ticks_during(lambda update=update, n=repeats: [update(vertices) for _ in range(n)])
            if ticks >= 5:
                break
        assert ticks >= 5
