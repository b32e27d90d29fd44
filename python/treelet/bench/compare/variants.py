"""Recipes that differ in some arguments of one word only: treelets by size, by rounds, budgets of splits."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

_STEP = re.compile(r"\s*(?P<word>\w+)\s*(?:\((?P<arguments>[^)]*)\))?\s*")


@dataclass(frozen=True)
class Variant:
    """One recipe of a family, and its arguments that vary."""

    label: str
    arguments: dict[str, int]


@dataclass(frozen=True)
class Family:
    """Recipes alike but for some arguments of `word`."""

    word: str
    pattern: str  # the recipe, "..." in place of what varies
    variants: tuple[Variant, ...]


def read_steps(recipe: str) -> list[tuple[str, dict[str, int]]]:
    """Words and arguments of a canonical recipe. Raises ValueError for what is none."""
    steps = []
    for part in recipe.split(">"):
        match = _STEP.fullmatch(part)
        if match is None:
            raise ValueError(f"{recipe!r} is not a recipe with every argument written out")
        pairs = (pair.split("=") for pair in (match["arguments"] or "").split(",") if pair.strip())
        steps.append((match["word"], {name.strip(): int(value) for name, value in pairs}))
    return steps


def has_word(recipe: str, word: str) -> bool:
    """Whether a stage of the recipe is `word`."""
    return any(each == word for each, _ in read_steps(recipe))


def families(recipes: Mapping[str, str], word: str, names: Sequence[str], telling: str) -> list[Family]:
    """Families of `word` whose arguments `names` vary, in which `telling` has two values at least.

    recipes: canonical texts by label. Variants come in the order of their arguments.
    """
    groups: dict[str, list[Variant]] = {}
    for label, recipe in recipes.items():
        pattern, arguments = _blank(recipe, word, names)
        if arguments:
            groups.setdefault(pattern, []).append(Variant(label, arguments))
    return [
        Family(word, pattern, tuple(sorted(variants, key=lambda each: tuple(each.arguments.values()))))
        for pattern, variants in groups.items()
        if len({each.arguments.get(telling) for each in variants}) > 1
    ]


def _blank(recipe: str, word: str, names: Sequence[str]) -> tuple[str, dict[str, int]]:
    """The recipe with these arguments of the first such word blanked, and their values."""
    found: dict[str, int] = {}
    parts = []
    for each, arguments in read_steps(recipe):
        kept = dict(arguments)
        if each == word and not found:
            found = {name: kept.pop(name) for name in names if name in kept}
            parts.append(_text(each, kept.items(), is_open=bool(found)))
        else:
            parts.append(_text(each, kept.items(), is_open=False))
    return " > ".join(parts), found


def _text(word: str, arguments: Iterable[tuple[str, int]], *, is_open: bool) -> str:
    shown = [f"{name}={value}" for name, value in arguments] + (["..."] if is_open else [])
    return f"{word}({', '.join(shown)})" if shown else word
