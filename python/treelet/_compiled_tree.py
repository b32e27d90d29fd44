"""What the query families of `Bvh` share: the compiled tree, and leave to read it."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Concatenate, ParamSpec, TypeVar

from ._core import Bvh as CompiledBvh
from ._offset import Offset

_Arguments = ParamSpec("_Arguments")
_Answer = TypeVar("_Answer")


class CompiledTree:
    """Base of the mixins that make up `Bvh`, which sets the attributes."""

    _core: CompiledBvh
    _reading: Callable[[], AbstractContextManager[None]]
    _offset: Offset
    _updates: int  # how many there were

    @property
    def face_count(self) -> int:
        """Faces that were given, left-out ones included."""
        raise NotImplementedError

    def _ask(
        self,
        query: Callable[Concatenate[CompiledBvh, _Arguments], _Answer],
        *arguments: _Arguments.args,
        **named: _Arguments.kwargs,
    ) -> _Answer:
        """What a function of the compiled part says of the tree, while no update may run."""
        with self._reading():
            return query(self._core, *arguments, **named)
