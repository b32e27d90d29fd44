"""What watchtowers see of a mountain range: a viewshed, exact to the triangle.

    python examples/viewshed.py [PICTURE]

A point is seen when nothing lies between it and the eye. With the vector from point to eye as the direction
the eye is at `t` = 1, so `t_min` and `t_max` just inside 0 and 1 keep the ray off both ends.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import treelet
from treelet import scenes

TOWERS = np.array([[-0.57, 2.72], [3.86, -1.84], [-3.1, -1.58]])  # km from the middle of the map: peaks
TOWER_HEIGHT = 0.03  # km
CELLS = 440  # of the map, along a side
END = 1e-5  # share of a ray left out at either end


def ground_at(bvh: treelet.Bvh, xy: np.ndarray) -> np.ndarray:
    """The points (..., 3) of the ground at (..., 2): where rays from the sky meet it."""
    top = bvh.bounds[1, 2] + 1.0
    sky = np.concatenate([xy, np.full((*xy.shape[:-1], 1), top)], axis=-1)
    sky[..., 2] -= bvh.intersect(sky, [0, 0, -1]).t
    return sky


def count_towers(bvh: treelet.Bvh, ground: np.ndarray, eyes: np.ndarray) -> np.ndarray:
    """How many of the eyes (E, 3) see each point of the ground (..., 3)."""
    seen = np.zeros(ground.shape[:-1], dtype=int)
    for eye in eyes:
        seen += ~bvh.occluded(ground, eye - ground, t_min=END, t_max=1 - END)
    return seen


def main() -> None:
    """Count, say how much of the map is seen, and draw it."""
    mesh = scenes.make("terrain", 500_000)
    bvh = treelet.build(mesh.vertices, mesh.faces)
    half = 0.999 * bvh.bounds[1, 0]  # inside the edge of the map
    line = np.linspace(-half, half, CELLS)
    ground = ground_at(bvh, np.stack(np.meshgrid(line, line), axis=-1))
    eyes = ground_at(bvh, TOWERS)
    eyes[:, 2] += TOWER_HEIGHT
    seen = count_towers(bvh, ground, eyes)
    print(f"{seen.size * len(eyes):,} rays; {np.mean(seen > 0):.1%} of the map is seen from a tower")
    draw(seen, ground, half, sys.argv[1] if len(sys.argv) > 1 else "viewshed.png")


def draw(seen: np.ndarray, ground: np.ndarray, half: float, path: str) -> None:
    """The relief, lit from the north-west, with what is seen in colour."""
    slope_y, slope_x = 0.3 * np.array(np.gradient(ground[..., 2], 2 * half / (CELLS - 1)))  # flattened
    light = (1 + slope_x - slope_y) / np.sqrt(3 * (1 + slope_x**2 + slope_y**2))
    figure, axes = plt.subplots(figsize=(6.4, 5.4), dpi=80, layout="constrained")
    extent = (-half, half, -half, half)
    axes.imshow(light, extent=extent, origin="lower", cmap="gray", vmin=0, vmax=1)
    shown = np.ma.masked_equal(seen, 0)
    image = axes.imshow(shown, extent=extent, origin="lower", cmap="autumn", alpha=0.5, vmin=1, vmax=3)
    axes.plot(*TOWERS.T, "w^", markeredgecolor="k", label="tower")
    axes.set(title="How many towers see the ground", xlabel="km east", ylabel="km north")
    axes.legend(loc="lower right")
    figure.colorbar(image, ticks=[1, 2, 3], shrink=0.7, label="towers")
    figure.savefig(path)


if __name__ == "__main__":
    main()
