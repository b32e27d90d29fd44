"""The benchmark of the GPU on small inputs. Runs on a GPU, or on the emulated device."""

import importlib
import json
import sys
import time
from types import SimpleNamespace

import numpy as np
import pytest

from treelet import cuda
from treelet.bench.gpu import __main__ as command
from treelet.bench.gpu import calls, cases, queries, report, tasks, versus, workload
from treelet.bench.gpu.clock import Driver, EventClock, HostClock, find_driver, make_clock, time_copies
from treelet.bench.gpu.results import read_results

pytestmark = pytest.mark.skipif(not cuda.is_available(), reason="no CUDA device")

SMALL = ["--triangles", "1000", "--width", "16", "--repeats", "2", "--calls", "3"]
SMALL += ["--call-rays", "100", "--stream-rays", "100"]


class FakeLibrary:
    """CUDA's driver, in so far as it is asked: events have the time of the host."""

    def __init__(self):
        self.events = {}

    def cuEventCreate(self, event, flags):  # noqa: N802
        event._obj.value = len(self.events) + 1
        self.events[event._obj.value] = 0.0
        return 0

    def cuEventRecord(self, event, stream):  # noqa: N802
        self.events[event.value] = time.perf_counter()
        return 0

    def cuEventSynchronize(self, event):  # noqa: N802
        return 0 if self.events[event.value] else 1

    def cuEventElapsedTime(self, milliseconds, start, stop):  # noqa: N802
        milliseconds._obj.value = 1e3 * (self.events[stop.value] - self.events[start.value])
        return 0

    def cuMemcpyDtoDAsync_v2(self, to, source, count, stream):  # noqa: N802
        self.copied = count.value
        return 0


@pytest.fixture
def driver():
    return Driver(FakeLibrary())


def test_events_enclose_one_call_and_another_goes_ahead(driver):
    done = []
    clock = make_clock(driver)
    assert isinstance(clock, EventClock)
    seconds = clock.time(lambda: done.append(time.sleep(0.02)))
    assert len(done) == 2
    assert 0.02 <= seconds < 0.04


def test_the_host_is_the_clock_where_there_is_no_driver():
    clock = make_clock(None)
    assert isinstance(clock, HostClock)
    assert clock.time(lambda: time.sleep(0.01)) >= 0.01


def test_a_driver_that_does_not_answer_is_none(monkeypatch):
    broken = FakeLibrary()
    broken.cuEventCreate = lambda event, flags: 3
    assert find_driver(broken) is None
    assert find_driver(SimpleNamespace()) is None
    assert find_driver(FakeLibrary()) is not None
    waits = []
    monkeypatch.setattr(cuda, "synchronize", lambda: waits.append("made a context"))
    broken.cuEventCreate = lambda event, flags: 0 if waits else 201
    assert find_driver(broken) is not None
    broken.cuEventCreate = lambda event, flags: 3
    with pytest.raises(OSError, match="cuEventCreate failed with CUDA error 3"):
        Driver(broken).make_event()


def test_copies_move_each_byte_twice(driver):
    samples, moved = time_copies(driver, 3, 4096)
    assert moved == 2 * driver._library.copied == 8192
    assert len(samples) == 3


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    """The file that a run of all parts wrote, with a driver."""
    path = tmp_path_factory.mktemp("bench") / "gpu.jsonl"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tasks, "find_driver", lambda: Driver(FakeLibrary()))
        patch.setattr("treelet.bench.gpu.clock._COPY_BYTES", 4096)
        patch.setattr(versus, "PEERS", [FakePeer])
        options = ["--scenes", "sphere", "--output", str(path)]
        assert command.main([*SMALL, *options]) == 0
    return path


class FakePeer:
    """A tracer that answers as we do, by our own tree."""

    NAME, VARIANTS = "fake", ("a", "b")

    class Loaded:
        version = "fake 1"

        def synchronize(self):
            cuda.synchronize()

        def upload(self, vertices, faces):
            case = cases.Case("sphere", 1000)
            return lambda variant: case.reference

        def prepare(self, tree, rays):
            if rays.any_hit:
                raise NotImplementedError("no any-hit rays")
            return FakeTracer(tree, rays)

    load = Loaded


class FakeTracer:
    def __init__(self, tree, rays):
        self.tree, self.rays = tree, rays

    def __call__(self):
        self.hits = self.rays.trace(self.tree)

    def answers(self):
        return self.hits.t, self.hits.face


def test_every_part_measures_what_it_should(measured):
    results = read_results([measured])
    sphere = next(scene for scene in results.scenes if scene.name == "sphere")
    kinds = {kind for kind, _, _ in sphere.measurements}
    assert kinds >= {"build", "build_call", "refit", "rebuild", "primary", "diffuse", "ambient_occlusion"}
    assert kinds >= {
        "call_kernel",
        "call_enqueue",
        "call_overhead",
        "build_versus",
        "diffuse_versus",
        "stream",
    }
    assert kinds >= set(queries.KINDS)
    assert all(each.details["disagreements"] == 0 for kind in queries.KINDS for each in sphere.of_kind(kind))
    assert results.copy_rate > 0.0
    labels = {each.label.partition(",")[0] for each in sphere.of_kind("diffuse", "rays")}
    assert labels == {recipe.label for recipe in cases.list_recipes()}
    orders = {str(each.details["order"]) for each in sphere.of_kind("diffuse", "rays")}
    assert len(orders) == len(cases.order_arguments())
    assert {each.details["clock"] for each in sphere.of_kind("primary")} == {"events"}


def test_answers_are_the_cpus_and_work_is_counted(measured):
    [scene] = [scene for scene in read_results([measured]).scenes if scene.name == "sphere"]
    for kind in ("primary", "diffuse", "ambient_occlusion"):
        for each in scene.of_kind(kind, "rays"):
            assert each.details["disagreements"] == 0
            assert 0 < each.details["checked"] <= each.rays
            assert len(each.samples) == 2
            assert ("nodes_per_ray" in each.details) == (kind != "ambient_occlusion")
            assert each.details.get("nodes_per_ray", 1.0) > 0.5


def test_trees_of_the_cpu_are_marked(measured):
    [scene] = [scene for scene in read_results([measured]).scenes if scene.name == "sphere"]
    built = {each.label: each.details["built_on"] for each in scene.of_kind("build", "rays")}
    assert {label for label, place in built.items() if place == "cpu"} == {
        label for label in built if label.startswith(cases.HOST_BUILDERS) and label.endswith("(CPU)")
    }
    assert scene.find("build_call", "sweep > bvh2 (CPU)") is None


def test_peers_are_compared_with_the_cpus_hits(measured):
    [scene] = [scene for scene in read_results([measured]).scenes if scene.name == "sphere"]
    theirs = [each for each in scene.of_kind("diffuse_versus") if each.details["peer"]]
    assert {each.label for each in theirs} == {"fake a", "fake b"}
    assert all(each.details["same_hit"] == each.details["same_face"] == 1.0 for each in theirs)
    assert not [each for each in scene.of_kind("ambient_occlusion_versus") if each.details["peer"]]
    assert [each for each in scene.of_kind("ambient_occlusion_versus") if not each.details["peer"]]


def test_what_is_measured_is_not_measured_again(measured, capsys):
    before = measured.read_text()
    options = ["--scenes", "sphere", "--output", str(measured), "--parts", "rays,builds,calls"]
    assert command.main([*SMALL, *options]) == 0
    assert measured.read_text() == before
    assert capsys.readouterr().out == ""


def test_the_report_is_made_of_the_lines_alone(measured, tmp_path, capsys):
    pytest.importorskip("matplotlib")
    assert report.main([str(measured), "--plots", str(tmp_path)]) == 0
    text = capsys.readouterr().out
    headings = [
        "Measured on",
        "Goals",
        "Copies",
        "Builds",
        "Stages",
        "Updates",
        "Rays, Grays/s",
        "Bytes of rays",
    ]
    headings += ["Calls from Python", "Rays from the host", "Other tracers", "Effective performance, diffuse"]
    assert [heading for heading in headings if f"## {heading}" not in text] == []
    assert len(list(tmp_path.glob("effective-sphere-*.png"))) == 1
    for line in text.splitlines():
        assert not line.startswith("|") or line.endswith("|")


def test_a_run_out_of_time_says_what_is_left(tmp_path, capsys, monkeypatch):
    path = tmp_path / "gpu.jsonl"
    options = ["--parts", "builds", "--scenes", "sphere,soup", "-r", "lbvh > bvh2", "--output", str(path)]
    times = iter([0.0, 0.0, 100.0, 100.0])
    monkeypatch.setattr(tasks.time, "monotonic", lambda: next(times))
    assert command.main([*SMALL, *options, "--seconds", "150"]) == command.UNFINISHED
    assert "no time left for: builds soup-1000; run it again" in capsys.readouterr().err
    monkeypatch.undo()
    assert command.main([*SMALL, *options]) == 0
    done = {json.loads(line)["details"]["task"] for line in path.read_text().splitlines()}
    assert done == {"builds sphere-1000", "builds soup-1000"}


def test_a_wrong_answer_is_counted_and_ends_in_an_error(capsys, monkeypatch):
    trace = cases.DeviceBvh.intersect

    def lie(self, *arguments, **options):
        hits = trace(self, *arguments, **options)
        u = hits.u.numpy().copy()
        u[::2] += np.float32(1)
        return hits._replace(u=cuda.copy_to_device(u))

    monkeypatch.setattr(cases.DeviceBvh, "intersect", lie)
    options = ["--parts", "rays", "--scenes", "sphere", "-r", "lbvh > bvh2"]
    assert command.main([*SMALL, *options]) == 1
    printed = capsys.readouterr()
    lines = [json.loads(line) for line in printed.out.splitlines()]
    wrong = {line["details"]["disagreements"] for line in lines if line["kind"] == "primary"}
    assert wrong == {(16 * 10 + 1) // 2}
    assert "primary rays of lbvh > bvh2 are not the CPU's" in printed.err


def test_recipes_that_cannot_be_built_are_left_out(capsys):
    recipes = [cases.Recipe("sweep > bvh2"), cases.Recipe("dream > bvh2"), cases.Recipe("lbvh > bvh2")]
    settings = cases.Settings(repeats=1, width=16)
    found = list(tasks.measure_rays(cases.Case("sphere", 1000), recipes, settings, HostClock()))
    assert {each.label.partition(",")[0] for each in found} == {"lbvh > bvh2"}
    printed = capsys.readouterr().err
    assert "sphere-1000: sweep > bvh2 is left out" in printed
    assert "sphere-1000: dream > bvh2 is left out" in printed


def test_libraries_that_are_not_here_are_left_out(capsys, monkeypatch):
    def fail(values):
        raise RuntimeError("no GPU for numbers")

    libraries = {"treelet": cuda.copy_to_device, "json": fail, "no_such_library": fail}
    monkeypatch.setattr(calls, "LIBRARIES", libraries)
    settings = cases.Settings(calls=2, call_rays=10)
    case = cases.Case("sphere", 1000)
    found = list(calls.measure_calls(case, [cases.Recipe("lbvh > bvh2")], settings, HostClock()))
    assert [each.kind for each in found] == ["call_kernel", "call_enqueue", "call_overhead"]
    printed = capsys.readouterr().err
    assert "arrays of json are left out: no GPU for numbers" in printed
    assert "arrays of no_such_library are left out: it is not installed" in printed


def test_no_driver_no_peers_and_no_scenes_are_said(capsys, monkeypatch):
    monkeypatch.setattr(tasks, "find_driver", lambda: None)
    monkeypatch.setattr(versus, "PEERS", [importlib.import_module("treelet.bench.gpu.peers.torch_bvh")])
    monkeypatch.setitem(sys.modules, "torch", None)
    monkeypatch.delenv("TREELET_SCENES", raising=False)
    assert command.main([*SMALL, "--parts", "copy,versus", "--scenes", "sphere"]) == 0
    assert len(list(tasks.list_tasks(["rays"], (), (1000,)))) == 3
    printed = capsys.readouterr()
    assert printed.out == ""
    assert "copies are left out: there is no driver to ask" in printed.err
    assert "torchbvh is left out: ModuleNotFoundError" in printed.err
    assert "not in TREELET_SCENES, so left out: crytek_sponza, conference" in printed.err


def test_the_profilers_workload_asks_every_query(capsys):
    options = ["--scene", "sphere", "--triangles", "1000", "--width", "16"]
    assert workload.main(options) == 0
    recipes = [recipe for recipe in cases.list_recipes() if not recipe.host]
    assert f"{len(recipes) * 3 * len(cases.order_arguments())} queries" in capsys.readouterr().err
