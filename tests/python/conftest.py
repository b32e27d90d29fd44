"""Fixtures of all Python tests.

Snapshots lie in snapshots/. After a change that is meant, write them anew and look at the difference:

    pytest --update-snapshots && git diff tests/python/snapshots
"""

from __future__ import annotations

from pathlib import Path

import pytest
from device_arrays import random_rays
from sample_meshes import random_triangles

SNAPSHOTS = Path(__file__).parent / "snapshots"


def pytest_addoption(parser):
    parser.addoption("--update-snapshots", action="store_true", help="write tests/python/snapshots anew")


class Snapshots:
    """Compares text with a stored file."""

    def __init__(self, is_updating: bool) -> None:
        self._is_updating = is_updating

    def check(self, name: str, text: str) -> None:
        path = SNAPSHOTS / f"{name}.txt"
        text = "\n".join(line.rstrip() for line in text.strip().splitlines()) + "\n"
        if self._is_updating:
            path.parent.mkdir(exist_ok=True)
            path.write_text(text, encoding="utf-8")
        assert path.exists(), f"there is no snapshot {path.name}: run pytest --update-snapshots"
        assert text == path.read_text(encoding="utf-8"), (
            f"{path.name} differs: see conftest.py for how to update it"
        )


@pytest.fixture
def snapshots(request) -> Snapshots:
    return Snapshots(request.config.getoption("--update-snapshots"))


@pytest.fixture(scope="session")
def soup():
    """(vertices, faces) of 2000 triangles, for trees on devices."""
    return random_triangles(2000, seed=3)


@pytest.fixture(scope="session")
def rays():
    """(origins, directions) of 500 rays at `soup`."""
    return random_rays()
