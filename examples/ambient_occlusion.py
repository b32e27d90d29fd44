"""Bake ambient occlusion into the vertices of a mesh: how much of the sky each of them sees.

    python examples/ambient_occlusion.py [PICTURE]

The rays of a vertex are cosine-distributed around its normal, so that the share of them that meets nothing
within REACH is the share of light from an even sky. A viewer then interpolates one number a vertex, here with
the barycentric coordinates `u` and `v` of the hits of a camera's rays.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import treelet

RAYS = 256  # a vertex
REACH = 3.0  # beyond it nothing darkens
LIFT = 1e-3  # rays start a little above their surface
PIXELS = 600


def unit(vectors: np.ndarray) -> np.ndarray:
    """The vectors (..., 3) with length one."""
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def grid(rows: int, columns: int) -> np.ndarray:
    """Faces of a grid of vertices, two triangles a cell."""
    corner = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    cell = np.array([[0, columns, 1], [1, columns, columns + 1]])
    return (corner[:, None, None] + cell).reshape(-1, 3)


def knot_on_a_floor() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A trefoil tube above a plane: vertices (V, 3), normals (V, 3), faces (F, 3)."""
    s, around = np.meshgrid(np.linspace(0, 2 * np.pi, 601), np.linspace(0, 2 * np.pi, 61), indexing="ij")
    spine = np.stack([np.sin(s) + 2 * np.sin(2 * s), np.cos(s) - 2 * np.cos(2 * s), -np.sin(3 * s)], -1)
    along = np.stack([np.cos(s) + 4 * np.cos(2 * s), 4 * np.sin(2 * s) - np.sin(s), -3 * np.cos(3 * s)], -1)
    side = unit(np.cross(along, [0.0, 0.0, 1.0]))
    over = unit(np.cross(side, along))
    tube_normals = np.cos(around)[..., None] * side + np.sin(around)[..., None] * over
    tube = spine + 0.45 * tube_normals + [0, 0, 1.45]
    x, y = np.meshgrid(np.linspace(-6, 6, 241), np.linspace(-6, 6, 241), indexing="ij")
    floor = np.stack([x, y, np.zeros_like(x)], axis=-1)
    vertices = np.concatenate([tube.reshape(-1, 3), floor.reshape(-1, 3)]).astype(np.float32)
    normals = np.concatenate([tube_normals.reshape(-1, 3), np.tile([0.0, 0.0, 1.0], (x.size, 1))])
    return vertices, normals, np.concatenate([grid(*s.shape), grid(*x.shape) + s.size])


def bake(bvh: treelet.Bvh, vertices: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """(V,) share of the sky that each vertex sees, from 0 to 1."""
    index = np.arange(RAYS) + 0.5
    z, turn = 1 - 2 * index / RAYS, np.pi * (1 + np.sqrt(5)) * index
    sphere = np.stack([*(np.sqrt(1 - z * z) * [np.cos(turn), np.sin(turn)]), z], axis=1)  # Fibonacci's
    seen = np.zeros(len(vertices))
    for point in sphere:
        directions = unit(normals + point)  # the sum is cosine-distributed
        seen += ~bvh.occluded(vertices + LIFT * normals, directions, t_max=REACH)
    return seen / RAYS


def main() -> None:
    """Bake, look at the mesh from above one corner, write the picture."""
    vertices, normals, faces = knot_on_a_floor()
    bvh = treelet.build(vertices, faces)
    light = bake(bvh, vertices, normals)
    print(f"{RAYS * len(vertices):,} rays, mean {light.mean():.2f}")
    plane = np.linspace(-4.4, 4.4, PIXELS)
    right, up, forward = np.array([[1, 0, 0], [0, 0.6, 0.8], [0, 0.8, -0.6]])
    eyes = plane[None, :, None] * right + plane[::-1, None, None] * up * 0.9 - 20 * forward + [0, 0, 0.8]
    _, face, u, v = bvh.intersect(eyes, forward)
    picture = np.sum(light[faces[face]] * np.stack([1 - u - v, u, v], axis=-1), axis=-1)
    path = sys.argv[1] if len(sys.argv) > 1 else "ambient_occlusion.png"
    plt.imsave(path, np.where(face >= 0, picture, 1.0), cmap="bone", vmin=0, vmax=1)


if __name__ == "__main__":
    main()
