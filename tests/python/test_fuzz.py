"""Random files, arrays, recipes and calls break nothing, and tools/fuzz.py would notice it if they did."""

import os
import struct
import subprocess
import sys
import time

import pytest
from loaded_tools import ROOT, load_tool
from sample_meshes import random_triangles

import treelet


@pytest.fixture(scope="module")
def fuzz():
    return load_tool("fuzz")


@pytest.fixture
def files(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "tools"))
    return load_tool("fuzz_files")


def test_seconds_of_fuzzing_find_nothing():
    command = [sys.executable, str(ROOT / "tools" / "fuzz.py"), "--minutes", "0.15", "--seed", "1"]
    told = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert told.returncode == 0, told.stdout + told.stderr
    assert "nothing found" in told.stdout


def test_a_mended_tree_has_the_checksums_that_it_was_saved_with(files):
    content = treelet.build(*random_triangles(30)).__reduce__()[1][0]
    assert files.resealed(content) == content
    damaged = bytearray(content)
    damaged[struct.unpack_from("<Q", content, 64 + 8)[0]] ^= 1  # the first fact, a coordinate of the bounds
    with pytest.raises(treelet.FileError, match="are damaged"):
        treelet.build([], []).__reduce__()[0](bytes(damaged))
    treelet.build([], []).__reduce__()[0](files.resealed(bytes(damaged)))


@pytest.mark.parametrize(
    ("error", "end"),
    [
        (None, "well"),
        (ValueError("what, where"), "ValueError"),
        (ValueError(""), "FOUND ValueError: "),
        (TypeError("f(): incompatible function arguments."), "FOUND TypeError: f(): incompatible"),
        (KeyError("x"), "FOUND KeyError: 'x'"),
        (AssertionError("wrong"), "FOUND AssertionError: wrong"),
    ],
)
def test_only_documented_errors_with_words_of_ours_pass(fuzz, error, end):
    def case(random):
        if error is not None:
            raise error

    assert fuzz.run_case(case, {case: (ValueError, TypeError)}, 1, 1).startswith(end)


@pytest.mark.skipif(os.name == "nt", reason="the worker's stand-in is a shell script")
@pytest.mark.parametrize(
    ("script", "finding"),
    [
        ("echo case kind:7; kill -SEGV $$", "kind:7 death of the process, code -11"),
        ("echo case kind:7; exec sleep 60", "kind:7 hang"),
        ("echo case kind:7; echo end FOUND KeyError: x", "kind:7 KeyError: x"),
    ],
)
def test_dead_and_hanging_workers_are_findings(fuzz, monkeypatch, tmp_path, script, finding):
    worker = tmp_path / "worker"
    worker.write_text(f"#!/bin/sh\n{script}\n")
    worker.chmod(0o755)
    monkeypatch.setattr(fuzz.sys, "executable", str(worker))
    monkeypatch.setattr(fuzz, "HANG_SECONDS", 2)
    tally = fuzz.Tally()
    assert fuzz.watch(1, 7, None, time.monotonic() + 60, tally) == 8
    assert [each.startswith(finding) for each in tally.findings] == [True]
    assert "kind: 1 cases: FOUND 1" in tally.table()
