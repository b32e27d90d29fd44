"""A table that terminals, Markdown and web pages can show."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from treelet.bench.compare.results import means
from treelet.bench.gpu.results import table as markdown_table


@dataclass(frozen=True)
class Column:
    """A heading; figures keep to the right. `better` marks the best: "high", "low" or nothing."""

    heading: str
    is_text: bool = False
    better: str = ""


@dataclass(frozen=True)
class Cell:
    """What is shown, and the number that is sorted by and compared, where there is one."""

    text: str
    value: float | None = None


@dataclass(frozen=True)
class Table:
    """Rows under a title; `summary` rows below them are means, kept last and not compared."""

    key: str
    title: str
    note: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...]
    summary: tuple[tuple[Cell, ...], ...] = ()
    across: bool = False  # whether the best of a row is marked, not the best of a column

    def best(self) -> set[tuple[int, int]]:
        """Row and column of each cell to mark: the best figure, unless all are alike."""
        lines = self._lines_across() if self.across else self._lines_down()
        return {place for line in lines for place in line}

    def _lines_down(self) -> Iterable[list[tuple[int, int]]]:
        for number, column in enumerate(self.columns):
            places = [(row, number) for row in range(len(self.rows))]
            yield self._winners(places, column.better)

    def _lines_across(self) -> Iterable[list[tuple[int, int]]]:
        numbers = [number for number, column in enumerate(self.columns) if column.better]
        for row in range(len(self.rows)):
            better = self.columns[numbers[0]].better if numbers else ""
            yield self._winners([(row, number) for number in numbers], better)

    def _winners(self, places: Sequence[tuple[int, int]], better: str) -> list[tuple[int, int]]:
        values = {
            (row, number): value
            for row, number in places
            if (value := self.rows[row][number].value) is not None
        }
        if not better or len(set(values.values())) < 2:
            return []
        winner = (max if better == "high" else min)(values.values())
        return [place for place, value in values.items() if value == winner]


def text(words: str) -> Cell:
    """A cell of words."""
    return Cell(words)


def figure(value: float | None, show: Callable[[float], str]) -> Cell:
    """A cell of a number, empty where there is none."""
    return Cell("", None) if value is None else Cell(show(value), value)


def geometric(values: Iterable[float | None]) -> Cell:
    """A cell of the geometric mean of those that are there."""
    found = means(values)
    return figure(found.geometric if found else None, times)


def percent(value: float) -> str:
    """0.9713 -> '97.1'."""
    return f"{100.0 * value:.1f}"


def times(value: float) -> str:
    """Three digits: 0.0523 -> '0.052', 12.34 -> '12.3'."""
    return f"{value:.3f}" if value < 0.1 else f"{value:.2f}" if value < 10.0 else f"{value:.1f}"


def whole(value: float) -> str:
    """12345.6 -> '12,346'."""
    return f"{value:,.0f}"


def tenths(value: float) -> str:
    """12.345 -> '12.3'."""
    return f"{value:,.1f}"


def hundredths(value: float) -> str:
    """12.345 -> '12.35'."""
    return f"{value:,.2f}"


def to_markdown(table: Table) -> list[str]:
    """Title, note and rows, the best figures in bold; nothing without rows."""
    if not table.rows:
        return []
    best = table.best()
    rows = [
        [f"**{cell.text}**" if (number, place) in best else cell.text for place, cell in enumerate(row)]
        for number, row in enumerate(table.rows)
    ]
    rows += [[f"**{cell.text}**" if cell.text else "" for cell in row] for row in table.summary]
    headings = [column.heading for column in table.columns]
    left = next((n for n, column in enumerate(table.columns) if not column.is_text), len(headings))
    escaped = [[cell.replace("|", "\\|") for cell in row] for row in rows]
    lines = [f"## {table.title}", ""]
    lines += [table.note, ""] if table.note else []
    return [*lines, *markdown_table(headings, escaped, left), ""]
