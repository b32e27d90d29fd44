"""Keeps updates of a tree from running beside its queries."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager


class UseGuard:
    """Many queries at a time or one update. Who would have to wait gets a RuntimeError instead: a query that
    may see either frame is a mistake, and waiting would hide it.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._queries = 0
        self._is_updating = False

    @contextmanager
    def query(self) -> Iterator[None]:
        """While something reads the tree."""
        with self._lock:
            if self._is_updating:
                raise RuntimeError("another thread updates this tree: query it before or after")
            self._queries += 1
        try:
            yield
        finally:
            with self._lock:
                self._queries -= 1

    @contextmanager
    def update(self) -> Iterator[None]:
        """While something changes the tree."""
        with self._lock:
            if self._is_updating or self._queries > 0:
                raise RuntimeError("another thread uses this tree: update it before or after")
            self._is_updating = True
        try:
            yield
        finally:
            with self._lock:
                self._is_updating = False
