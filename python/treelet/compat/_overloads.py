"""Methods that take one set of arguments or another."""

from __future__ import annotations

from collections.abc import Callable
from inspect import signature
from typing import Any


def choose_overload(
    name: str, functions: tuple[Callable[..., Any], ...], arguments: tuple[Any, ...], named: dict[str, Any]
) -> Callable[..., Any]:
    """The function that takes these arguments; where none does, a TypeError about the method of this name."""
    for function in functions:
        try:
            signature(function).bind(*arguments, **named)
        except TypeError:
            continue
        return function
    forms = " or ".join(f"({', '.join(signature(function).parameters)})" for function in functions)
    given = ", ".join([*(type(each).__name__ for each in arguments), *(f"{each}=..." for each in named)])
    raise TypeError(f"{name} takes {forms}, not ({given})")
