"""Errors become one paragraph on stderr and an exit code."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass

import typer

CHECK_FAILED = 1
BAD_INPUT = 2

# What bad input, a full disk or a missing extra raise. Anything else is a defect and keeps its traceback.
_EXPECTED = (ValueError, TypeError, OSError, ImportError, MemoryError)


@dataclass
class _Tracebacks:
    wanted: bool = False


_tracebacks = _Tracebacks()


def show_tracebacks(wanted: bool) -> None:
    """Whether expected errors show where they came from; set once a run, by --debug."""
    _tracebacks.wanted = wanted


def reported(command: Callable[..., None]) -> Callable[..., None]:
    """Wrap a command so that expected errors end it with a message and exit code 2."""

    @functools.wraps(command)
    def wrapper(*arguments, **options) -> None:
        try:
            command(*arguments, **options)
        except _EXPECTED as error:
            if _tracebacks.wanted:
                raise
            typer.echo(f"treelet: {_paragraph(error)}", err=True)
            raise typer.Exit(BAD_INPUT) from None

    return wrapper


def _paragraph(error: BaseException) -> str:
    if isinstance(error, OSError) and error.strerror and error.filename is not None:
        return f"{error.filename}: {error.strerror.lower()}"
    if isinstance(error, MemoryError):
        return "out of memory: use a smaller mesh, size or number of samples"
    return " ".join(str(error).split()) or type(error).__name__
