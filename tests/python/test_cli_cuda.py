"""`treelet render --device cuda`: on a GPU, on the emulated device, and where something is missing."""

import json
import sys

import fake_cupy
import numpy as np
import pytest
from command_line import plain_terminal, run_cli

from treelet import cuda

_plain_terminal = plain_terminal
RENDER = ["render", "sphere", "--triangles", "1000", "--size", "24x16", "-s", "1"]


@pytest.fixture
def cupy(monkeypatch):
    if not cuda.is_available():
        pytest.skip("no CUDA device")
    if cuda.devices()[0].name.startswith("Emulated"):
        monkeypatch.setitem(sys.modules, "cupy", fake_cupy)
    pytest.importorskip("cupy")


@pytest.mark.usefixtures("cupy")
def test_pictures_of_both_devices_look_alike(tmp_path):
    image = pytest.importorskip("PIL.Image")
    pictures = []
    for device in ("cpu", "cuda"):
        path = tmp_path / f"{device}.png"
        facts = json.loads(run_cli(*RENDER, "-o", str(path), "--device", device, "--json").stdout)
        assert facts["device"] == device
        with image.open(path) as file:
            pictures.append(np.asarray(file).astype(int))
    assert np.mean(np.abs(pictures[0] - pictures[1]) > 2) < 0.01


@pytest.mark.usefixtures("cupy")
def test_a_recipe_for_the_cpu_alone_is_refused(tmp_path):
    path = tmp_path / "picture.png"
    result = run_cli(*RENDER, "-o", str(path), "--device", "cuda", "-r", "sweep > bvh8", code=2)
    assert "'sweep' runs on the CPU alone" in result.stderr
    assert not path.exists()


def test_a_missing_device_is_named(monkeypatch):
    monkeypatch.setattr(cuda, "is_available", lambda: False)
    monkeypatch.setattr(cuda, "why_unavailable", lambda: "there is no GPU: plug one in")
    result = run_cli(*RENDER, "--device", "cuda", code=2)
    assert result.stderr == "treelet: --device cuda: there is no GPU: plug one in\n"


def test_missing_cupy_is_named(monkeypatch):
    monkeypatch.setattr(cuda, "is_available", lambda: True)
    monkeypatch.setitem(sys.modules, "cupy", None)
    result = run_cli(*RENDER, "--device", "cuda", code=2)
    assert "needs cupy: pip install 'cupy-cuda13x[ctk]'" in result.stderr
