"""Where things are printed: tables and JSON on stdout, notes and progress on stderr."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import typer

Cell = str | tuple[str, str]  # plain, or with a rich style
_WIDTH_OF_FILES = 120  # columns where stdout is no terminal


def print_json(data: Any) -> None:
    """One JSON document on stdout."""
    typer.echo(json.dumps(data, indent=2, allow_nan=False))


def console(stderr: bool = False):
    """A rich console; it honours NO_COLOR and COLUMNS."""
    from rich.console import Console

    stream = sys.stderr if stderr else sys.stdout
    width = None if stream.isatty() or "COLUMNS" in os.environ else _WIDTH_OF_FILES
    return Console(stderr=stderr, width=width, highlight=False)


def note(text: str) -> None:
    """A line for people, on stderr."""
    console(stderr=True).print(text, markup=False, soft_wrap=True)


def print_table(
    title: str, columns: list[str | tuple[str, str]], rows: list[list[Cell]], caption: str = ""
) -> None:
    """A table on stdout. A column is its heading or (heading, "right").

    Title, caption and cells are shown as they are, names with brackets too; a cell may be (text, style).
    Figures keep to a line. The first column of a table without headings holds labels: there the values wrap.
    """
    from rich import box
    from rich.table import Table
    from rich.text import Text

    is_headed = any(column if isinstance(column, str) else column[0] for column in columns)
    table = Table(
        title=Text(title, "bold"),
        show_header=is_headed,
        caption=Text(caption, "dim") if caption else None,
        box=box.SIMPLE_HEAD,
        title_justify="left",
        caption_justify="left",
        pad_edge=False,
    )
    for column in columns:
        heading, justify = (column, "left") if isinstance(column, str) else column
        is_label = not is_headed and not table.columns
        is_figure = is_headed and justify == "right"
        table.add_column(heading, justify=justify, no_wrap=is_label or is_figure, overflow="fold")
    for row in rows:
        table.add_row(*(Text(*cell) if isinstance(cell, tuple) else Text(cell) for cell in row))
    console().print(table)


class ProgressBar:
    """One line on stderr; can be fed as progress(done, of) or step by step with a text."""

    def __init__(self, progress, task) -> None:
        self._progress, self._task = progress, task

    def at(self, done: int, of: int) -> None:
        """`done` of `of` parts are finished."""
        self._progress.update(self._task, completed=done, total=of)

    def begin(self, text: str) -> None:
        """The step before is finished, and `text` begins."""
        begun = self._progress.tasks[0].fields["begun"]
        self._progress.update(self._task, description=text, completed=begun, begun=begun + 1)


@contextmanager
def progress_bar(text: str, total: int | None = None) -> Iterator[ProgressBar]:
    """Show a bar for long work, on stderr and only in a terminal."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
    is_shown = sys.stderr.isatty()
    with Progress(*columns, console=console(stderr=True), transient=True, disable=not is_shown) as progress:
        yield ProgressBar(progress, progress.add_task(text, total=total, begun=0))
