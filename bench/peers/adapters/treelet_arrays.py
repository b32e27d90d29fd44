"""This library."""

import treelet

NAME = "treelet"


def build(vertices, faces):
    """From arrays to a function of origins and directions that gives t, inf for a miss."""
    bvh = treelet.build(vertices, faces)
    return lambda origins, directions: bvh.intersect(origins, directions).t
