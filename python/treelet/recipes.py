"""Recipes: one line of text names a splitter if you like, a builder, optimizers and a layout."""

from __future__ import annotations

from typing import NamedTuple

from . import _core
from ._inputs import as_recipe


class Parameter(NamedTuple):
    """An argument of a recipe word; all are whole numbers."""

    name: str
    default: int
    minimum: int
    maximum: int
    summary: str


class RecipeWord(NamedTuple):
    """A stage that a recipe can name."""

    name: str
    kind: str
    """splitter, builder, optimizer or layout, in this order: at most one splitter, one builder, any
    optimizers, at most one layout."""
    summary: str
    parameters: list[Parameter]


def recipe_words() -> list[RecipeWord]:
    """All words of recipes, splitters first, then builders, optimizers, layouts."""
    return [
        RecipeWord(name, kind, summary, [Parameter(*parameter) for parameter in parameters])
        for name, kind, summary, parameters in _core.recipe_words()
    ]


def presets() -> dict[str, str]:
    """Names of recipes, quickest build first."""
    return {name: recipe for name, recipe, _ in _core.presets()}


def parse_recipe(text: str) -> str:
    """Write a recipe or preset out with every argument.

    Raises:
        ValueError: that says which word, argument or value is wrong and what there is.
        TypeError: for what is not text.
    """
    return _core.canonical_recipe(as_recipe(text))
