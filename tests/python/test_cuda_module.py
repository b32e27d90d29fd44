"""`treelet.cuda` answers on every machine: with a GPU, without one, and built without CUDA."""

import os
import subprocess
import sys

import pytest

from treelet import cuda


def ask_in_new_process(question, **environment):
    code = f"from treelet import cuda; print({question})"
    result = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        env=os.environ | environment,
    )
    assert result.stderr == ""
    return result.stdout.strip()


def test_a_reason_is_given_exactly_where_cuda_is_unavailable():
    assert cuda.is_available() == (cuda.why_unavailable() == "")
    assert cuda.is_available() == bool(cuda.devices())


def test_answers_do_not_change():
    def answers():
        return cuda.is_available(), cuda.why_unavailable(), cuda.devices()

    assert answers() == answers()


def test_the_reason_is_one_line_that_says_what_to_do():
    reason = cuda.why_unavailable()
    if cuda.is_available():
        pytest.skip("CUDA is available")
    assert "\n" not in reason
    assert any(advice in reason for advice in ("install", "nvidia-smi", "update", "does not start"))


def test_without_cuda_code_the_reason_names_the_build_option():
    if cuda.is_compiled_in():
        pytest.skip("built with CUDA")
    assert not cuda.is_available()
    assert "TREELET_CUDA=ON" in cuda.why_unavailable()


def test_with_cuda_code_the_reason_is_the_machine():
    if not cuda.is_compiled_in():
        pytest.skip("built without CUDA")
    assert "TREELET_CUDA" not in cuda.why_unavailable()


def test_hidden_gpus_are_not_available():
    assert ask_in_new_process("cuda.devices()", CUDA_VISIBLE_DEVICES="") == "[]"
    if cuda.is_available():
        assert "CUDA_VISIBLE_DEVICES" in ask_in_new_process("cuda.why_unavailable()", CUDA_VISIBLE_DEVICES="")


def test_devices_are_described():
    if not cuda.is_available():
        pytest.skip(cuda.why_unavailable())
    for device in cuda.devices():
        assert device.name
        assert device.compute_capability >= (5, 0)
        assert device.memory_bytes > 1 << 28
        assert device.multiprocessors > 0


def test_importing_treelet_does_not_start_the_driver():
    """cuInit maps the driver's libraries, so their absence shows that nothing was asked."""
    maps = "any('libcuda.so' in line for line in open('/proc/self/maps'))"
    if not os.path.exists("/proc/self/maps"):
        pytest.skip("needs /proc")
    assert ask_in_new_process(maps) == "False"
