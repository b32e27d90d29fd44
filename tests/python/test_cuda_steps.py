"""The steps of `make gpu`: what they run, what becomes of them, and where it is written down."""

import json
import re
import sys
import time
from fnmatch import fnmatchcase
from pathlib import Path
from typing import ClassVar

import pytest
from loaded_tools import ROOT, load_tool

from treelet.bench.gpu.tasks import PART_NAMES
from treelet.bench.machine import source_commit

gpu_steps = load_tool("gpu_steps")
gpu = load_tool("gpu")


@pytest.fixture
def steps(monkeypatch):
    """A step of make gpu that prints a measurement, one that cannot run, one that has no time."""

    def cannot(run):
        raise gpu_steps.CannotRunError("there is no such thing")

    def echo(run):
        run(sys.executable, "-c", "print('heard')", save="heard.txt")

    def leave(run):
        run(sys.executable, "-c", f"raise SystemExit({gpu_steps.UNFINISHED})")

    slices = {"talk": {"echo": echo}, "rest": {"cannot": cannot, "bench-leave": leave}}
    monkeypatch.setattr(gpu_steps, "SLICES", slices)
    monkeypatch.setattr(
        gpu_steps, "STEPS", {name: step for each in slices.values() for name, step in each.items()}
    )


def outcomes(folder: Path) -> list[str]:
    return [json.loads(line)["outcome"] for line in (folder / "steps.jsonl").read_text().splitlines()]


def test_results_go_where_they_are_wanted(steps, tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("OUT", str(tmp_path / "variable"))
    assert gpu.main([]) == gpu_steps.UNFINISHED
    assert gpu.main(["talk", "--out", str(tmp_path / "option")]) == 0
    assert outcomes(tmp_path / "variable") == ["passed", "skipped", "unfinished"]
    assert outcomes(tmp_path / "option") == ["passed"]
    assert (tmp_path / "option" / "heard.txt").read_text() == "heard\n"
    assert "heard" in (tmp_path / "option" / "gpu.log").read_text()
    assert "run it again" in capsys.readouterr().out


def test_slices_can_be_taken_one_by_one_and_resumed(steps, tmp_path):
    folder = ["--out", str(tmp_path)]
    assert gpu.main(["talk", *folder]) == 0
    assert gpu.main(["rest", *folder]) == gpu_steps.UNFINISHED
    assert gpu.main(["--resume", *folder]) == gpu_steps.UNFINISHED
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

    monkeypatch.setattr(gpu_steps, "STEPS", {"fail": fail, "hang": hang, "miss": miss})
    monkeypatch.setattr(gpu_steps, "SLICES", {})
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

    class Recorder(gpu_steps.Runner):
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
    monkeypatch.setattr(gpu_steps, "BUILD", build)
    monkeypatch.setattr(gpu_steps, "SITE", build / "site")
    monkeypatch.setattr(gpu_steps, "TESTS", build / "treelet_gpu_tests")
    monkeypatch.setattr(gpu_steps.shutil, "which", lambda name: name)
    monkeypatch.setattr(gpu_steps, "has_module", lambda name: True)
    monkeypatch.setattr(gpu_steps, "googletest_options", list)
    (tmp_path / "gpu.log").write_text("")
    return Recorder(tmp_path / "gpu.log", time.monotonic() + 100.0)


def test_every_step_is_a_command_that_can_be_given(runner, capsys):
    for name, step in gpu_steps.STEPS.items():
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
    gpu_steps.STEPS["bench-rays"](runner)
    assert told[0]["TREELET_COMMIT"] == "0123abc"
    source_commit.cache_clear()
    assert source_commit() == "0123abc"
    monkeypatch.delenv("TREELET_COMMIT")
    source_commit.cache_clear()
    expected = source_commit() or ""
    assert gpu_steps.source_commit() == expected
    monkeypatch.setenv("PATH", "")
    assert gpu_steps.source_commit() == ""


def test_parts_of_the_benchmark_are_those_that_there_are(runner):
    for slices in ("rays", "queries", "builds", "versus"):
        for step in gpu_steps.SLICES[slices].values():
            step(runner)
    named = [part for command in runner.commands for part in command if part.startswith("--parts=")]
    parts = {part for each in named for part in each.partition("=")[2].split(",")}
    assert parts == set(PART_NAMES)


def test_what_is_not_there_is_skipped(runner, monkeypatch):
    monkeypatch.setattr(gpu_steps.shutil, "which", lambda name: None)
    monkeypatch.setattr(gpu_steps, "has_module", lambda name: False)
    monkeypatch.setattr(gpu_steps, "googletest_options", lambda: None)
    for name in ("memcheck", "counters", "build-package", "build-tests", "test-python"):
        with pytest.raises(gpu_steps.CannotRunError):
            gpu_steps.STEPS[name](runner)
    for path in (gpu_steps.TESTS, gpu_steps.BUILD / "a.cu.o.log"):
        path.unlink()
    (gpu_steps.SITE / "treelet").rmdir()
    for name in ("test", "memcheck", "resources", "bench-rays", "import", "write-report"):
        with pytest.raises(gpu_steps.CannotRunError):
            gpu_steps.STEPS[name](runner)


def test_the_sanitizers_check_tests_that_there_are():
    text = "".join(path.read_text() for path in (ROOT / "tests" / "cuda").glob("*_test.cpp"))
    pairs = re.findall(r"^TEST(?:_P|_F)?\((\w+),\s*(\w+)\)", text, re.MULTILINE)
    names = [f"{suite}.{test}" for suite, test in pairs]
    for pattern in gpu_steps.CHECKED_TESTS:
        assert [name for name in names if fnmatchcase(name, pattern)], pattern
