"""From the command line's texts to meshes, views and sizes."""

from __future__ import annotations

import re
from typing import Any

import treelet

Vector = tuple[float, float, float]

_MOST_PIXELS = 1 << 28


def load_subject(mesh: str, triangles: int | None = None, seed: int = 0) -> Any:
    """The scene or mesh file called `mesh`, as `treelet.mesh.Mesh` with float32 vertices.

    All that a command says and draws is about the rounded mesh; it is warned of once, here.
    """
    from treelet import scenes

    return scenes.load(mesh, triangles=triangles, seed=seed).rounded()


def use_threads(count: int) -> None:
    """Set the number of threads for this run; 0 means all cores."""
    treelet.set_thread_count(count)


def choose_view(mesh: Any, wanted: str | None, aspect: float = 1.6) -> Any:
    """The view named or numbered `wanted`; else the mesh's first, or a computed one where it has none."""
    from treelet.view import automatic_view

    if wanted == "automatic" or (wanted is None and not mesh.views):
        return automatic_view(mesh.vertices, mesh.faces, aspect=aspect)
    if wanted is None:
        return mesh.views[0]
    for index, view in enumerate(mesh.views):
        if wanted in (view.name, str(index)):
            return view
    known = [view.name or str(index) for index, view in enumerate(mesh.views)]
    raise ValueError(f"{mesh.name} has no view '{wanted}': choose from {', '.join([*known, 'automatic'])}")


def parse_size(text: str) -> tuple[int, int]:
    """'1280x800' to (1280, 800)."""
    match = re.fullmatch(r"\s*(\d+)\s*[xX×]\s*(\d+)\s*", text)
    if match is None:
        raise ValueError(f"--size is '{text}', but it must be width x height in pixels, such as 1280x800")
    width, height = int(match[1]), int(match[2])
    if min(width, height) < 1 or width * height > _MOST_PIXELS:
        raise ValueError(f"--size is {width}x{height}, but pictures have from 1 to {_MOST_PIXELS} pixels")
    return width, height


def parse_vector(option: str, text: str) -> Vector:
    """'1,2,3' to (1.0, 2.0, 3.0)."""
    try:
        x, y, z = (float(part) for part in text.split(","))
    except ValueError:
        raise ValueError(
            f"{option} is '{text}', but it must be three numbers with commas, such as 1,2.5,-3"
        ) from None
    return x, y, z
