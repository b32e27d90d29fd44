"""Scenes to build trees for: procedural ones, made here, and mesh files from outside.

scenes.names(), scenes.describe(name), scenes.make(name, triangles, seed)   embedded
scenes.external_names(), scenes.load_external(name)          from the folder in TREELET_SCENES
scenes.load(name_or_path)                                     any of them, or a file
"""

from .catalog import FEWEST_TRIANGLES, MOST_TRIANGLES, describe, make, names
from .external import external_names, load_external
from .lookup import load

__all__ = [
    "FEWEST_TRIANGLES",
    "MOST_TRIANGLES",
    "describe",
    "external_names",
    "load",
    "load_external",
    "make",
    "names",
]
