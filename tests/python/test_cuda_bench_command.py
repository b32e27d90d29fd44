"""The commands that measure a GPU, where there is none: bad arguments, the profiler, bytes of stages."""

import re
from types import SimpleNamespace

import pytest
from loaded_tools import ROOT

from treelet.bench.gpu import __main__ as bench
from treelet.bench.gpu import workload
from treelet.bench.gpu.builds import STAGE_BYTES, stage_details


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
