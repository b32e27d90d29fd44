"""What `make wheel` finds wrong with a wheel."""

import zipfile

import pytest
from test_tools import load_tool

check_wheel = load_tool("check_wheel")
GOOD = [
    "treelet/__init__.py",
    "treelet/_core.abi3.so",
    "treelet/_core.pyi",
    "treelet/py.typed",
    "treelet-1.0.dist-info/METADATA",
    "treelet-1.0.dist-info/licenses/LICENSE",
    "treelet-1.0.dist-info/licenses/NOTICE",
    "treelet-1.0.dist-info/licenses/LICENSES/nanobind.txt",
]


def make_wheel(folder, names, size=10):
    path = folder / "treelet-1.0-cp310-abi3-any.whl"
    with zipfile.ZipFile(path, "w") as archive:
        for name in names:
            archive.writestr(name, bytes(size))
    return path


def test_accepts_a_wheel_that_has_everything(tmp_path):
    assert check_wheel.check_files(make_wheel(tmp_path, GOOD)) == []


@pytest.mark.parametrize("missing", GOOD[1:4] + GOOD[5:])
def test_misses_what_is_not_there(tmp_path, missing):
    wheel = make_wheel(tmp_path, [name for name in GOOD if name != missing])
    [problem] = check_wheel.check_files(wheel)
    assert problem.startswith("no file ")


def test_finds_what_should_not_be_there(tmp_path):
    assert check_wheel.check_files(make_wheel(tmp_path, [*GOOD, "tests/test_x.py"])) == [
        "unexpected tests/test_x.py"
    ]


def test_finds_what_is_too_large(tmp_path, monkeypatch):
    monkeypatch.setattr(check_wheel, "MOST_BYTES", 1000)
    [problem] = check_wheel.check_files(make_wheel(tmp_path, GOOD, size=1000))
    assert "more than 1,000" in problem
