"""Heat maps of traversal cost: how many tree nodes each pixel's rays visit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from treelet.render.arrays import Array, device_of, to_host
from treelet.render.color import inferno, to_bytes
from treelet.render.image import beside, colour_bar, stacked, titled
from treelet.render.settings import RenderSettings
from treelet.render.studio import Studio
from treelet.render.work import Progress

_MOST_SAMPLES = 8
_TOP_PERCENTILE = 99.5  # a few grazing rays must not darken all the others


@dataclass(frozen=True)
class CostMap:
    """Nodes visited a ray, averaged over each pixel."""

    nodes: np.ndarray  # (height, width) float32, on the host
    label: str

    @property
    def mean(self) -> float:
        """Nodes a ray over the whole picture."""
        return float(self.nodes.mean(dtype=np.float64))


def cost_map(studio: Studio, label: str = "", progress: Progress | None = None) -> CostMap:
    """Count the nodes that camera rays visit in `studio.bvh`."""

    def trace(sampler, pixel, sample) -> Array:
        origin, directions = studio.camera_rays(sampler, pixel, sample)
        return studio.bvh.traversal_cost(origin, directions, 0.0, np.inf).nodes[:, None]

    samples = min(studio.settings.samples, _MOST_SAMPLES)
    return CostMap(to_host(studio.average(trace, samples, 1, progress)[..., 0]), label)


def render_heat(studio: Studio, progress: Progress | None = None) -> Array:
    """One heat map with its colour bar, (height + bar, width, 3) uint8."""
    label = studio.bvh.report.recipe
    return heat_panels([cost_map(studio, label, progress)])


def render_heat_pair(
    bvhs: Sequence,
    labels: Sequence[str],
    mesh,
    view,
    settings: RenderSettings,
    progress: Progress | None = None,
) -> Array:
    """Heat maps of several trees over one mesh, side by side at one scale, uint8."""
    maps = []
    for index, (bvh, label) in enumerate(zip(bvhs, labels, strict=True)):
        with device_of(bvh):
            studio = Studio(bvh, mesh, view, settings)
            maps.append(cost_map(studio, label, _part(progress, index, len(bvhs))))
    return heat_panels(maps)


def heat_panels(maps: Sequence[CostMap]) -> Array:
    """Compose `maps` with titles and a shared colour bar, (height, width, 3) uint8."""
    top = max(float(np.percentile(each.nodes, _TOP_PERCENTILE)) for each in maps) or 1.0
    panels = [
        titled(to_bytes(inferno(each.nodes / top)), each.label, f"{each.mean:.1f} nodes a ray")
        for each in maps
    ]
    pictures = beside(panels)
    return stacked([pictures, colour_bar(inferno, top, "tree nodes visited a camera ray", pictures.shape[1])])


def _part(progress: Progress | None, index: int, parts: int) -> Progress | None:
    """Progress of one of several equal parts of a job."""
    if progress is None:
        return None
    return lambda done, of: progress(index * of + done, parts * of)
