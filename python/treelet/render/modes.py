"""The render modes by name."""

from __future__ import annotations

import numpy as np

from treelet.render.arrays import device_of, to_host
from treelet.render.color import to_bytes
from treelet.render.features import render_ambient_occlusion, render_depth, render_normals
from treelet.render.heat import render_heat
from treelet.render.path import render_path
from treelet.render.settings import RenderSettings
from treelet.render.studio import Studio
from treelet.render.work import Progress

MODES = {
    "path": render_path,
    "ao": render_ambient_occlusion,
    "normals": render_normals,
    "depth": render_depth,
    "heat": render_heat,
}


def render(
    bvh,
    mesh,
    view,
    mode: str = "path",
    settings: RenderSettings | None = None,
    progress: Progress | None = None,
) -> np.ndarray:
    """A picture of `mesh` as display colours, (height, width, 3) uint8.

    `bvh` is the tree over mesh.vertices (V, 3) and mesh.faces (F, 3); `mode` one of MODES; progress(done,
    of) is called now and then. A `DeviceBvh` renders on its device with cupy; the mesh may lie there or on
    the host, and only the picture comes back. Raises ValueError for an unknown mode or a view without a
    direction, and ImportError where cupy is needed and missing.
    """
    if mode not in MODES:
        raise ValueError(f"unknown render mode '{mode}': choose one of {', '.join(MODES)}")
    with device_of(bvh):
        studio = Studio(bvh, mesh, view, settings or RenderSettings())
        colors = MODES[mode](studio, progress)
        return to_host(colors if colors.dtype == np.uint8 else to_bytes(colors))
