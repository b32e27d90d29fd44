"""Errors become one paragraph on stderr and an exit code."""

from __future__ import annotations

import functools
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import typer

from treelet.cli import INTERRUPTED

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
    """Wrap a command so that expected errors and Ctrl-C end it with a line, and warnings are a line each."""

    @functools.wraps(command)
    def wrapper(*arguments, **options) -> None:
        try:
            with _plain_warnings():
                command(*arguments, **options)
        except KeyboardInterrupt:
            typer.echo("interrupted", err=True)
            raise typer.Exit(INTERRUPTED) from None
        except _EXPECTED as error:
            if _tracebacks.wanted:
                raise
            typer.echo(f"treelet: {_paragraph(error)}", err=True)
            raise typer.Exit(BAD_INPUT) from None

    return wrapper


@contextmanager
def _plain_warnings() -> Iterator[None]:
    """Warnings for people: what is wrong, not which line of treelet noticed it."""
    with warnings.catch_warnings():
        warnings.simplefilter("default", UserWarning)
        warnings.showwarning = _show_warning
        yield


def _show_warning(message: Warning | str, *_: object, **__: object) -> None:
    typer.echo(f"treelet: warning: {' '.join(str(message).split())}", err=True)


def _paragraph(error: BaseException) -> str:
    if isinstance(error, OSError) and error.strerror and error.filename is not None:
        return f"{error.filename}: {error.strerror.lower()}"
    if isinstance(error, MemoryError):
        return "out of memory: use a smaller mesh, size or number of samples"
    return " ".join(str(error).split()) or type(error).__name__
