"""Hours of direct sun on a city in the course of a day, as an architect asks for them.

    python examples/sun_hours.py [PICTURE]

Rays straight down find the ground and the roofs. From each point one ray for each position of the sun asks
whether anything is in its way: `occluded` ends at the first thing it meets, so it is faster than `intersect`.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import treelet
from treelet import scenes

LATITUDE = 48.0  # degrees north
DECLINATION = -11.0  # of the sun, in degrees: late October
MINUTES = 10  # between two positions of the sun
SPACING = 1.0  # metres between points on the map
LIFT = 0.01  # metres: a ray starts a little above the surface that it must not meet again


def sun_directions() -> np.ndarray:
    """Unit vectors (N, 3) to the sun while it is up; x is east, y north, z up."""
    latitude, declination = np.radians([LATITUDE, DECLINATION])
    hour_angle = np.radians(np.arange(-180, 180, MINUTES / 4))  # the earth turns a degree in four minutes
    east = -np.cos(declination) * np.sin(hour_angle)
    towards_pole = np.sin(declination) * np.ones_like(hour_angle)
    towards_equator = np.cos(declination) * np.cos(hour_angle)
    north = np.cos(latitude) * towards_pole - np.sin(latitude) * towards_equator
    up = np.sin(latitude) * towards_pole + np.cos(latitude) * towards_equator
    return np.stack([east, north, up], axis=1)[up > 0]


def surface_points(bvh: treelet.Bvh) -> np.ndarray:
    """What one sees from above: (rows, columns, 3), NaN where there is nothing."""
    (west, south, _), (east, north, top) = bvh.bounds
    x, y = np.meshgrid(np.arange(west, east, SPACING), np.arange(south, north, SPACING))
    sky = np.stack([x, y, np.full_like(x, top + 1)], axis=-1)
    depth = bvh.intersect(sky, [0, 0, -1]).t
    sky[..., 2] -= np.where(np.isfinite(depth), depth, np.nan)
    return sky


def main() -> None:
    """Count the hours at every point and draw the map."""
    mesh = scenes.make("city", 20_000)
    bvh = treelet.build(mesh.vertices, mesh.faces)
    points = surface_points(bvh)
    points[..., 2] += LIFT
    sun = sun_directions()
    hours = np.zeros(points.shape[:2])
    for direction in sun:
        hours += ~bvh.occluded(points, direction) * (MINUTES / 60)
    hours[np.isnan(points[..., 2])] = np.nan
    day = len(sun) * MINUTES / 60
    print(f"{len(sun) * hours.size:,} rays: {np.nanmean(hours):.1f} hours of sun in a day of {day:.1f}")
    draw(hours, bvh.bounds, sys.argv[1] if len(sys.argv) > 1 else "sun_hours.png")


def draw(hours: np.ndarray, bounds: np.ndarray, path: str) -> None:
    """A map, north up."""
    figure, axes = plt.subplots(figsize=(7.2, 6), dpi=110, layout="constrained")
    (west, south, _), (east, north, _) = bounds
    image = axes.imshow(hours, extent=(west, east, south, north), origin="lower", cmap="inferno")
    axes.set(title="Direct sun on a day in October, 48° north", xlabel="metres east", ylabel="metres north")
    figure.colorbar(image, label="hours")
    figure.savefig(path)


if __name__ == "__main__":
    main()
