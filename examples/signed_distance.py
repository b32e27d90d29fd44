"""A signed distance field of a mesh, cut open: how far every point is from the surface, negative inside.

    python examples/signed_distance.py [PICTURE]

The mesh is a Menger sponge, the cut goes through its middle at right angles to a diagonal. The same call
fills a grid for collisions, offset surfaces or training data.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import TwoSlopeNorm

import treelet
from treelet import scenes

PIXELS = 600


def cut(bounds: np.ndarray) -> tuple[np.ndarray, float]:
    """Points (PIXELS, PIXELS, 3) of the plane, and half the side of the square that they fill."""
    right = np.array([1, -1, 0]) / np.sqrt(2)
    up = np.array([-1, -1, 2]) / np.sqrt(6)
    half = 0.75 * np.max(bounds[1] - bounds[0])
    line = np.linspace(-half, half, PIXELS)
    middle = bounds.mean(axis=0)
    return middle + line[None, :, None] * right + line[:, None, None] * up, half


def main() -> None:
    """Measure the distances and draw them with lines of equal distance."""
    mesh = scenes.make("menger", 36_096)  # three levels, exactly
    bvh = treelet.build(mesh.vertices, mesh.faces)
    points, half = cut(bvh.bounds)
    distance = bvh.signed_distance(points)
    print(f"{distance.size:,} points, {np.mean(distance < 0):.1%} inside, deepest {-distance.min():.3f}")
    draw(distance, half, sys.argv[1] if len(sys.argv) > 1 else "signed_distance.png")


def draw(distance: np.ndarray, half: float, path: str) -> None:
    """Outside blue, inside red, the surface black."""
    figure, axes = plt.subplots(figsize=(7.2, 6), dpi=75, layout="constrained")
    extent = (-half, half, -half, half)
    colours = TwoSlopeNorm(0.0, distance.min(), distance.max())
    image = axes.imshow(distance, extent=extent, origin="lower", cmap="RdBu", norm=colours)
    axes.contour(
        distance, np.arange(0.05, distance.max(), 0.05), extent=extent, colors="white", linewidths=0.5
    )
    axes.contour(distance, [0.0], extent=extent, colors="black", linewidths=1.0)
    axes.set(title="Signed distance to a Menger sponge, on a plane through its middle")
    figure.colorbar(image, label="distance")
    figure.savefig(path)


if __name__ == "__main__":
    main()
