"""Sends arrays of the host to a device and brings answers back, for queries that are asked block by block."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from . import _core
from ._device_results import Array

STREAMED_BYTES = 2**28  # that a block takes on the device
_DEFAULT_STREAM = 0


class Block:
    """Arrays in the memory of one device, which stay there while the block does."""

    def __init__(self, device: int) -> None:
        self._device = device
        self._kept: list[_core.DeviceMemory] = []

    def send(self, array: np.ndarray[Any, Any]) -> int:
        """Copy an array there; its address."""
        memory = self._make(array.nbytes)
        if array.nbytes > 0:
            memory.copy_from_host(array.tobytes(), _DEFAULT_STREAM)
        return memory.address

    def make(self, shape: tuple[int, ...], dtype: str) -> tuple[int, Array]:
        """Room for answers: its address, and the array to fetch them from."""
        kind = np.dtype(dtype)
        memory = self._make(math.prod(shape) * kind.itemsize)
        return memory.address, Array(memory, 0, shape, kind, _DEFAULT_STREAM, self._device)

    def _make(self, size: int) -> _core.DeviceMemory:
        self._kept.append(_core.DeviceMemory(size, self._device, _DEFAULT_STREAM))
        return self._kept[-1]


def cut(ends: np.ndarray[Any, np.dtype[np.int64]], most: int) -> Iterator[tuple[int, int]]:
    """Ranges of items whose sizes add up to at most so many bytes, where one item has no more.

    Args:
        ends: (N + 1,) bytes of all items before each.
        most: bytes of a range.
    """
    begin, count = 0, len(ends) - 1
    while begin < count:
        end = int(np.searchsorted(ends, ends[begin] + most, side="right")) - 1
        end = min(max(end, begin + 1), count)
        yield begin, end
        begin = end


def rows(array: np.ndarray[Any, Any], begin: int, end: int) -> np.ndarray[Any, Any]:
    """Rows of an array that has one for all items or one each."""
    return array if len(array) == 1 else array[begin:end]
