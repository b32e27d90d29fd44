"""What the measuring commands share: argument types whose errors are sentences, and output files."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TextIO


def whole_number(least: int, most: int | None = None) -> Callable[[str], int]:
    """An argument type: an integer from `least` on."""
    limits = f"of at least {least}" if most is None else f"from {least} to {most}"

    def read(text: str) -> int:
        try:
            number = int(text)
        except ValueError:
            number = least - 1
        if number < least or (most is not None and number > most):
            raise argparse.ArgumentTypeError(f"{text!r} is not a whole number {limits}")
        return number

    return read


def list_of(read: Callable[[str], object]) -> Callable[[str], list]:
    """An argument type: items of another with commas between them."""

    def read_all(text: str) -> list:
        return [read(part.strip()) for part in text.split(",")]

    return read_all


def open_output(parser: argparse.ArgumentParser, path: Path, mode: str) -> TextIO:
    """The file, or the command's end with a sentence where it cannot be written."""
    try:
        return path.open(mode, encoding="utf-8")
    except OSError as error:
        parser.error(f"cannot write {path}: {error.strerror}")
