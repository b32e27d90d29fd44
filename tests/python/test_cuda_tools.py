"""What surrounds CUDA: the list of kernels' resources, requirements said twice, tests and measurements."""

import importlib.util
import json
import re
import sys
import time
from fnmatch import fnmatchcase
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import ClassVar

import pytest

from treelet.bench.gpu import __main__ as bench
from treelet.bench.gpu import workload
from treelet.bench.gpu.builds import STAGE_BYTES, stage_details
from treelet.bench.gpu.tasks import PART_NAMES
from treelet.bench.machine import source_commit

ROOT = Path(__file__).resolve().parents[2]
SOURCE = "src/treelet/core/cuda_device.cu"  # logs of files that are no more are left out

LOG = """\
ptxas info    : 28 bytes gmem
ptxas info    : Compiling entry function '{kernel}' for 'sm_90'
ptxas info    : Function properties for {kernel}
    16 bytes stack frame, {spill} bytes spill stores, 4 bytes spill loads
ptxas info    : Used 79 registers, used 1 barriers, 47104 bytes smem, 352 bytes cmem[0]
ptxas info    : Function properties for _ZN7treelet4cuda7forwardEPf
    8 bytes stack frame, 0 bytes spill stores, 0 bytes spill loads
ptxas info    : Compiling entry function 'plain' for 'sm_90'
ptxas info    : Function properties for plain
    0 bytes stack frame, 0 bytes spill stores, 0 bytes spill loads
ptxas info    : Used 10 registers, used 0 barriers
"""


def load_tool(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, ROOT / "tools" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # where dataclasses look for their annotations
    spec.loader.exec_module(module)
    return module


keep_output = load_tool("keep_output")
kernel_resources = load_tool("kernel_resources")
gpu = load_tool("gpu")


@pytest.fixture
def build(tmp_path):
    """A folder as a build leaves it."""
    log = tmp_path / "CMakeFiles" / "treelet_kernels.dir" / f"{SOURCE}.o.log"
    log.parent.mkdir(parents=True)
    log.write_text(LOG.format(kernel="_ZN7treelet4cuda4sortIjEEvPT_", spill=12))
    return tmp_path


def test_reads_what_each_function_uses():
    sort, forward, plain = kernel_resources.parse_log(LOG.format(kernel="sort", spill=12), "a.cu")
    assert (sort.name, sort.architecture, sort.is_kernel) == ("sort", "sm_90", True)
    assert (sort.registers, sort.spill_stores, sort.spill_loads, sort.stack, sort.shared) == (
        79,
        12,
        4,
        16,
        47104,
    )
    assert (forward.is_kernel, forward.stack, forward.spills) == (False, 8, False)
    assert (plain.registers, plain.shared, plain.spills) == (10, 0, False)


def test_spilling_fails_unless_allowed(build, capsys):
    assert kernel_resources.main([str(build)]) == 1
    printed = capsys.readouterr()
    assert "sort" in printed.err
    assert "plain" in printed.out
    [name] = {
        kernel_resources.short_name(each.name) for each in kernel_resources.read_build(build) if each.spills
    }
    assert kernel_resources.main([str(build), "--allow-spill", "other", name]) == 0
    assert kernel_resources.main([str(build), "--allow-spill", "sor*"]) == 0


def test_table_is_aligned_markdown(build, capsys):
    kernel_resources.main([str(build)])
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 2 + 3
    assert len({len(line) for line in lines}) == 1
    assert {line.count("|") for line in lines} == {8}


def test_json_has_a_line_a_function(build, capsys):
    kernel_resources.main([str(build), "--json"])
    records = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert {record["source"] for record in records} == {"core/cuda_device.cu"}
    assert sorted(record["registers"] for record in records) == [0, 10, 79]


def test_a_build_without_kernels_is_an_error(tmp_path, capsys):
    assert kernel_resources.main([str(tmp_path)]) == 2
    assert "make cuda" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "short"),
    [
        ("treelet::cuda::(anonymous namespace)::refit(treelet::Span<int>, unsigned int)", "refit"),
        ("void treelet::cuda::form<(treelet::Kind)1, 7>(float*)", "form<(Kind)1, 7>"),
        ("void cub::CUB_1::detail::Sort<cub::CUB_1::policy<unsigned int, true>, int>(int*)", "cub Sort<...>"),
        ("_Zmangled", "_Zmangled"),
    ],
)
def test_names_are_shortened(name, short):
    assert kernel_resources.short_name(name) == short


def test_output_is_kept_beside_the_object_and_the_rest_is_shown(tmp_path, capsys):
    made = tmp_path / "a.cu.o"
    says = LOG.format(kernel="sort", spill=0) + "a.cu(3): warning: unused\n"
    command = [sys.executable, "-c", f"print({says!r}, end=''); raise SystemExit(3)", "-o", str(made)]
    assert keep_output.main(command) == 3
    assert (tmp_path / "a.cu.o.log").read_text() == says
    assert capsys.readouterr().err == "a.cu(3): warning: unused\n"


def test_one_cuda_toolkit_is_required_everywhere():
    requirement = "cuda-toolkit[nvcc,cccl]==13.0.*"
    assert (ROOT / "pyproject.toml").read_text().count(f'"{requirement};') == 2
    assert f'"{requirement}"' in (ROOT / "cmake" / "TreeletCuda.cmake").read_text()


@pytest.fixture
def steps(monkeypatch):
    """A step of make gpu that prints a measurement, one that cannot run, one that has no time."""

    def cannot(run):
        raise gpu.CannotRunError("there is no such thing")

    def echo(run):
        run(sys.executable, "-c", "print('heard')", save="heard.txt")

    def leave(run):
        run(sys.executable, "-c", f"raise SystemExit({gpu.UNFINISHED})")

    slices = {"talk": {"echo": echo}, "rest": {"cannot": cannot, "bench-leave": leave}}
    monkeypatch.setattr(gpu, "SLICES", slices)
    monkeypatch.setattr(gpu, "STEPS", {name: step for each in slices.values() for name, step in each.items()})


def outcomes(folder: Path) -> list[str]:
    return [json.loads(line)["outcome"] for line in (folder / "steps.jsonl").read_text().splitlines()]


def test_results_go_where_they_are_wanted(steps, tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("OUT", str(tmp_path / "variable"))
    assert gpu.main([]) == gpu.UNFINISHED
    assert gpu.main(["talk", "--out", str(tmp_path / "option")]) == 0
    assert outcomes(tmp_path / "variable") == ["passed", "skipped", "unfinished"]
    assert outcomes(tmp_path / "option") == ["passed"]
    assert (tmp_path / "option" / "heard.txt").read_text() == "heard\n"
    assert "heard" in (tmp_path / "option" / "gpu.log").read_text()
    assert "run it again" in capsys.readouterr().out


def test_slices_can_be_taken_one_by_one_and_resumed(steps, tmp_path):
    folder = ["--out", str(tmp_path)]
    assert gpu.main(["talk", *folder]) == 0
    assert gpu.main(["rest", *folder]) == gpu.UNFINISHED
    assert gpu.main(["--resume", *folder]) == gpu.UNFINISHED
    assert outcomes(tmp_path) == ["passed", "skipped", "unfinished", "skipped", "unfinished"]
    assert gpu.main(["echo", *folder]) == 0
    assert outcomes(tmp_path)[-1] == "passed"


def test_a_step_without_time_is_skipped_and_an_unknown_one_named(steps, tmp_path, capsys):
    assert gpu.main(["echo", "--out", str(tmp_path), "--budget", "-1"]) == 0
    assert outcomes(tmp_path) == ["skipped"]
    with pytest.raises(SystemExit):
        gpu.main(["ecko", "--out", str(tmp_path)])
    assert "no such step: ecko; there are talk, rest, echo, cannot, bench-leave" in capsys.readouterr().err


def test_a_step_that_fails_shows_what_it_said(steps, tmp_path, monkeypatch, capsys):
    def fail(run):
        run(sys.executable, "-c", "print('it hurts'); raise SystemExit(7)")

    def hang(run):
        run(sys.executable, "-c", "import time; time.sleep(60)")

    def miss(run):
        run("no-such-program")

    monkeypatch.setattr(gpu, "STEPS", {"fail": fail, "hang": hang, "miss": miss})
    monkeypatch.setattr(gpu, "SLICES", {})
    assert gpu.main(["fail", "miss", "hang", "--out", str(tmp_path), "--budget", "0.5"]) == 1
    printed = capsys.readouterr().out
    assert "    it hurts" in printed
    assert "exit code 7" in printed
    assert "no-such-program: No such file" in printed
    assert outcomes(tmp_path)[:2] == ["failed", "failed"]


def test_a_folder_that_cannot_be_made_is_an_error(steps, tmp_path, capsys):
    (tmp_path / "file").write_text("")
    with pytest.raises(SystemExit) as end:
        gpu.main(["--out", str(tmp_path / "file" / "folder")])
    assert end.value.code == 2
    assert "cannot write to" in capsys.readouterr().err


@pytest.fixture
def runner(tmp_path, monkeypatch):
    """Keeps commands instead of running them; a build with tests, the package and kernels is there."""

    class Recorder(gpu.Runner):
        commands: ClassVar[list] = []

        def __call__(self, *command, save="", **environment):
            self.commands.append([str(part) for part in command])
            if save:
                (self.folder / save).write_text("## Goals\n\n| a goal |\n\n## More\n")

    Recorder.commands = []
    build = tmp_path / "build"
    (build / "site" / "treelet").mkdir(parents=True)
    (build / "treelet_gpu_tests").write_text("")
    (build / "a.cu.o.log").write_text("")
    monkeypatch.setattr(gpu, "BUILD", build)
    monkeypatch.setattr(gpu, "SITE", build / "site")
    monkeypatch.setattr(gpu, "TESTS", build / "treelet_gpu_tests")
    monkeypatch.setattr(gpu.shutil, "which", lambda name: name)
    monkeypatch.setattr(gpu, "has_module", lambda name: True)
    monkeypatch.setattr(gpu, "googletest_options", list)
    (tmp_path / "gpu.log").write_text("")
    return Recorder(tmp_path / "gpu.log", time.monotonic() + 100.0)


def test_every_step_is_a_command_that_can_be_given(runner, capsys):
    for name, step in gpu.STEPS.items():
        if name != "build-package":  # copies the package
            before = len(runner.commands)
            step(runner)
            assert len(runner.commands) > before, name
    [rays] = [command for command in runner.commands if "--parts=copy,calls,rays,stream" in command]
    seconds = next(int(part.partition("=")[2]) for part in rays if part.startswith("--seconds"))
    assert 60 < seconds <= 80  # of the 100, so that it ends by itself
    assert capsys.readouterr().out == "| a goal |\n"


def test_measurements_name_the_commit_that_the_package_is_made_of(runner, monkeypatch):
    told = []
    monkeypatch.setattr(type(runner), "__call__", lambda self, *command, **named: told.append(named))
    monkeypatch.setenv("TREELET_COMMIT", "0123abc")
    gpu.STEPS["bench-rays"](runner)
    assert told[0]["TREELET_COMMIT"] == "0123abc"
    source_commit.cache_clear()
    assert source_commit() == "0123abc"
    monkeypatch.delenv("TREELET_COMMIT")
    source_commit.cache_clear()
    expected = source_commit() or ""
    assert gpu.source_commit() == expected
    monkeypatch.setenv("PATH", "")
    assert gpu.source_commit() == ""


def test_parts_of_the_benchmark_are_those_that_there_are(runner):
    for slices in ("rays", "builds", "versus"):
        for step in gpu.SLICES[slices].values():
            step(runner)
    named = [part for command in runner.commands for part in command if part.startswith("--parts=")]
    parts = {part for each in named for part in each.partition("=")[2].split(",")}
    assert parts == set(PART_NAMES)


def test_what_is_not_there_is_skipped(runner, monkeypatch):
    monkeypatch.setattr(gpu.shutil, "which", lambda name: None)
    monkeypatch.setattr(gpu, "has_module", lambda name: False)
    monkeypatch.setattr(gpu, "googletest_options", lambda: None)
    for name in ("memcheck", "counters", "build-package", "build-tests", "test-python"):
        with pytest.raises(gpu.CannotRunError):
            gpu.STEPS[name](runner)
    for path in (gpu.TESTS, gpu.BUILD / "a.cu.o.log"):
        path.unlink()
    (gpu.SITE / "treelet").rmdir()
    for name in ("test", "memcheck", "resources", "bench-rays", "import", "write-report"):
        with pytest.raises(gpu.CannotRunError):
            gpu.STEPS[name](runner)


def test_the_sanitizers_check_tests_that_there_are():
    text = "".join(path.read_text() for path in (ROOT / "tests" / "cuda").glob("*_test.cpp"))
    pairs = re.findall(r"^TEST(?:_P|_F)?\((\w+),\s*(\w+)\)", text, re.MULTILINE)
    names = [f"{suite}.{test}" for suite, test in pairs]
    for pattern in gpu.CHECKED_TESTS:
        assert [name for name in names if fnmatchcase(name, pattern)], pattern


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        (["--scenes", "city,citty"], "unknown scene 'citty'; did you mean 'city'?"),
        (["--triangles", "10000,0"], "'0' is not a whole number from 1000 to 50000000"),
        (["--triangles", ""], "'' is not a whole number"),
        (["--repeats", "0"], "'0' is not a whole number of at least 1"),
        (["--width", "-3"], "'-3' is not a whole number of at least 16"),
        (["--parts", "rays,waves"], "unknown part 'waves': choose from copy, "),
        (["--layouts", "bvh3"], "unknown layout 'bvh3': choose from bvh2, "),
        (["-r", "lbwh > bvh2"], "lbwh"),
        (["--output", "no/such/folder/x.jsonl"], "cannot write no/such/folder/x.jsonl: No such"),
    ],
)
def test_bad_arguments_of_the_benchmark_end_with_a_sentence(capsys, arguments, what):
    with pytest.raises(SystemExit) as end:
        bench.main(arguments)
    assert end.value.code == 2
    assert what in capsys.readouterr().err.splitlines()[-1]


def test_a_file_of_something_else_is_not_appended_to(tmp_path, capsys, monkeypatch):
    path = tmp_path / "notes.txt"
    path.write_text("dear diary\n")
    monkeypatch.setattr(bench.cuda, "is_available", lambda: True)
    with pytest.raises(SystemExit):
        bench.main(["--output", str(path)])
    assert "line 1 is not a measurement" in capsys.readouterr().err
    assert path.read_text() == "dear diary\n"


@pytest.mark.parametrize("module", [bench, workload])
def test_without_a_gpu_the_benchmark_says_why(module, capsys, monkeypatch):
    monkeypatch.setattr(module.cuda, "is_available", lambda: False)
    monkeypatch.setattr(module.cuda, "why_unavailable", lambda: "it is somewhere else")
    assert module.main([]) == 1
    assert capsys.readouterr().err == "it is somewhere else\n"


def test_the_workload_is_run_under_the_profiler(tmp_path, capsys, monkeypatch):
    output = tmp_path / "counters.csv"
    monkeypatch.setattr(workload.shutil, "which", lambda name: None)
    assert workload.main(["--counters", str(output)]) == 1
    assert "Nsight Compute (ncu) is not on the PATH" in capsys.readouterr().err
    monkeypatch.undo()
    commands = []
    monkeypatch.setattr(workload.shutil, "which", lambda name: name)
    run = lambda command, check: commands.append(command) or SimpleNamespace(returncode=5)  # noqa: E731
    monkeypatch.setattr(workload.subprocess, "run", run)
    assert workload.main(["--scene", "soup", "--counters", str(output)]) == 5
    [command] = commands
    assert command[0] == "ncu"
    assert f"--log-file={output}" in command
    assert command[-3:] == ["--scene=soup", "--triangles=1000000", "--width=1600"]
    assert any(part.startswith("--metrics=gpu__time_duration.sum,") for part in command)


def test_stages_that_nothing_is_known_of_have_no_bandwidth():
    report = SimpleNamespace(faces=10, references=13, bytes=100, sah=1.0, nodes=1, depth=1)
    samples = [
        {"survey the mesh": 2.0, "pack bvh8": seconds, "collapse": 0.0, "dream": 1.0} for seconds in (1, 2, 3)
    ]
    details = stage_details(samples, report)
    survey, pack, collapse, dream = details["stages"]
    assert survey["bytes"] == 18 * 10
    assert pack["bytes"] == (64 + 32 + 18) * 13 + 100
    assert pack["bytes_per_second"] == pack["bytes"] / 2
    assert collapse == {"name": "collapse", "seconds": 0.0}
    assert dream == {"name": "dream", "seconds": 1.0}
    assert details["million_triangles_per_second"] == 10 / 5 / 1e6
    still = stage_details([{"collapse": 0.0}], report)
    assert still["million_triangles_per_second"] == 0.0


def test_every_stage_of_a_device_build_has_its_bytes():
    sources = (ROOT / "src" / "treelet" / "pipeline").glob("*.cu")
    names = {name for source in sources for name in re.findall(r'begin\("([^"]+)"\)', source.read_text())}
    assert len(names) > 8
    assert names == set(STAGE_BYTES)
