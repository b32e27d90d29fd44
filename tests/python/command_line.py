"""Running the command line program inside a test."""

from __future__ import annotations

import pytest

pytest.importorskip("rich")
pytest.importorskip("typer")

from typer.testing import CliRunner

import treelet
from treelet.cli.app import app


@pytest.fixture(autouse=True)
def plain_terminal(monkeypatch):
    monkeypatch.setenv("COLUMNS", "160")
    monkeypatch.setenv("NO_COLOR", "1")
    monkeypatch.setenv("TERM", "dumb")
    monkeypatch.delenv("TREELET_SCENES", raising=False)
    monkeypatch.delenv("FORCE_COLOR", raising=False)
    threads = treelet.thread_count()
    yield
    treelet.set_thread_count(threads)


def run_cli(*arguments: str, code: int = 0):
    result = CliRunner().invoke(app, list(arguments), prog_name="treelet")
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    assert result.exit_code == code, result.output
    return result
