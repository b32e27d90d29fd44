"""Reading TOML so that what is wrong is named: the file, the key, what it must be, the nearest known word."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from treelet.scenes.catalog import suggestion


class Keys:
    """One table of a TOML file, whose keys are taken one by one; `finish` refuses those nobody took."""

    def __init__(self, values: Mapping[str, Any], path: Path, place: str = "") -> None:
        self._values, self._path, self._place = values, path, place
        self._known: list[str] = []

    def error(self, text: str) -> ValueError:
        """An error that says where."""
        return ValueError(f"{self._path}: {self._place}{text}")

    @staticmethod
    def near(word: str, known: Sequence[str]) -> str:
        """'; did you mean ...? known are ...'"""
        return suggestion(word, list(known))

    def text(self, key: str, default: str | None = None) -> str:
        """A text that is not empty; needed where there is no default."""
        value = self._take(key, default)
        if not isinstance(value, str) or not value.strip():
            raise self._wrong(key, "a text", value)
        return value

    def whole(self, key: str, default: int | None, least: int = 0, most: int | None = None) -> Any:
        """A whole number, or None where it is not there and `default` is None."""
        if key not in self._values:
            self._known.append(key)
            return default
        value = self._take(key)
        is_whole = isinstance(value, int) and not isinstance(value, bool)
        if not is_whole or value < least or (most is not None and value > most):
            limits = f"of at least {least}" if most is None else f"from {least} to {most}"
            raise self._wrong(key, f"a whole number {limits}", value)
        return value

    def flag(self, key: str, *, default: bool) -> bool:
        """True or false."""
        value = self._take(key, default)
        if not isinstance(value, bool):
            raise self._wrong(key, "true or false", value)
        return value

    def texts(self, key: str, default: tuple[str, ...], among: Sequence[str] = ()) -> tuple[str, ...]:
        """A list of different texts, not empty; if `among` names some, of these."""
        if key not in self._values:
            self._known.append(key)
            return default
        value = self._take(key)
        if not isinstance(value, list) or not value or not all(isinstance(each, str) for each in value):
            raise self._wrong(key, "a list of texts", value)
        for each in value:
            if among and each not in among:
                raise self.error(f"{key}: unknown {each!r}{self.near(each, among)}")
        return tuple(dict.fromkeys(value))

    def table(self, key: str) -> Mapping[str, Any]:
        """A table with something in it."""
        value = self._take(key)
        if not isinstance(value, dict) or not value:
            raise self._wrong(key, "a table with something in it", value)
        return value

    def tables(self, key: str) -> list[Keys]:
        """Tables of a list, [[key]] each, one at least."""
        value = self._take(key)
        if not isinstance(value, list) or not value or not all(isinstance(each, dict) for each in value):
            raise self._wrong(key, f"one or more [[{key}]]", value)
        return [
            Keys(each, self._path, f"[[{key}]] number {number}: ")
            for number, each in enumerate(value, start=1)
        ]

    def finish(self) -> None:
        """Raises ValueError for the first key that nobody took."""
        for key in self._values:
            if key not in self._known:
                raise self.error(f"unknown key {key!r}{self.near(key, self._known)}")

    def _take(self, key: str, default: Any = None) -> Any:
        self._known.append(key)
        if key in self._values:
            return self._values[key]
        if default is None:
            raise self._missing(key)
        return default

    def _missing(self, key: str) -> ValueError:
        unknown = [each for each in self._values if suggestion(each, [key]).startswith("; did you mean")]
        return self.error(f"{key} is missing" + (f"; is {unknown[0]!r} meant to be it?" if unknown else ""))

    def _wrong(self, key: str, wanted: str, value: Any) -> ValueError:
        return self.error(f"{key} must be {wanted}, not {value!r}")


def read_toml(path: Path) -> Keys:
    """The top table. Raises ValueError for a file that is no TOML, OSError for none at all."""
    toml = _toml_module()
    try:
        return Keys(toml.loads(path.read_text(encoding="utf-8")), path)
    except (toml.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"{path}: is not TOML: {error}") from None


def _toml_module() -> Any:
    """Python's own, or what Python 3.10 has in its place."""
    try:
        return import_module("tomllib" if sys.version_info >= (3, 11) else "tomli")
    except ModuleNotFoundError as missing:
        raise ImportError("suites need tomli on Python 3.10: pip install 'treelet[compare]'") from missing
