"""A laser scanner drives through a city: points, ranges, and a picture of both.

    python examples/lidar.py [PICTURE]

Sixty-four lasers turn around the vertical axis, as those on cars do. Every beam is a ray: its `t` is the
range, since the directions have length one, and a miss (`t` = inf) is a beam that never comes back.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import treelet
from treelet import scenes

LASERS, STEPS = 64, 2048  # beams above each other, and around
LOWEST, HIGHEST = -25.0, 15.0  # degrees above the horizon
RANGE = 120.0  # metres
NOISE = 0.02  # metres, standard deviation
STOPS = np.arange(-150.0, 151.0, 15.0)  # metres along the street


def beams() -> np.ndarray:
    """Unit directions (LASERS, STEPS, 3), the highest beam first; z is up."""
    rise = np.radians(np.linspace(HIGHEST, LOWEST, LASERS))[:, None]
    turn = np.linspace(-np.pi, np.pi, STEPS, endpoint=False)[None, :]
    flat = np.cos(rise)
    return np.stack([flat * np.sin(turn), flat * np.cos(turn), np.sin(rise) + 0 * turn], axis=-1)


def scan(bvh: treelet.Bvh, position: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """Ranges (LASERS, STEPS) in metres as the scanner tells them; inf where nothing comes back."""
    hits = bvh.intersect(position, beams(), t_max=RANGE)
    return hits.t + generator.normal(0.0, NOISE, hits.t.shape)


def main() -> None:
    """Scan at every stop, then draw the last scan's ranges and all points from above."""
    mesh = scenes.make("city", 200_000)
    bvh = treelet.build(mesh.vertices, mesh.faces)
    generator = np.random.default_rng(1)
    clouds = []
    street = mesh.views[1].eye[0]  # the scene's second view stands on one
    for y in STOPS:
        position = np.array([street, y, 1.9])  # on the roof of a car
        ranges = scan(bvh, position, generator)
        returned = np.isfinite(ranges)
        clouds.append(position + ranges[returned, None] * beams()[returned])
    points = np.concatenate(clouds)
    print(f"{len(STOPS) * LASERS * STEPS:,} beams, {len(points):,} points")
    draw(ranges, points, sys.argv[1] if len(sys.argv) > 1 else "lidar.png")


def draw(ranges: np.ndarray, points: np.ndarray, path: str) -> None:
    """Ranges around the car above, the points of the whole drive below."""
    figure, (panorama, above) = plt.subplots(
        2, figsize=(9, 5), dpi=110, layout="constrained", height_ratios=[1, 1.6]
    )
    image = panorama.imshow(ranges, extent=(-180, 180, LOWEST, HIGHEST), aspect="auto", cmap="magma_r")
    panorama.set(title="The last scan", xlabel="degrees from straight ahead", ylabel="degrees up")
    figure.colorbar(image, label="range in m", pad=0.01)
    shown = points[np.argsort(points[:, 2])][::12]  # the highest last, on top
    dots = above.scatter(shown[:, 1], -shown[:, 0], c=shown[:, 2], s=0.1, cmap="turbo", vmin=-3, vmax=40)
    above.set(title="Points of the whole drive, from above", xlabel="metres along the street")
    above.set(xlim=(-230, 230), ylim=(-60, 60), aspect="equal")
    figure.colorbar(dots, label="height in m", pad=0.01)
    figure.savefig(path)


if __name__ == "__main__":
    main()
