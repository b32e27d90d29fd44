"""Near-best bounding volume hierarchies for triangle meshes, in milliseconds.

import treelet

bvh = treelet.build(vertices, faces)  # (V, 3) floats, (F, 3) integers
t, face, u, v = bvh.intersect(origins, directions)  # (..., 3) floats each
shadowed = bvh.occluded(origins, directions)
"""

from typing import TYPE_CHECKING, Any

from . import cuda
from ._core import FileError, __version__, set_thread_count, thread_count
from ._hit_lists import AllHits, HitChunk
from ._inputs import PrecisionWarning
from ._load import load, mesh_hash
from ._point_queries import ClosestPoints, Overlaps
from .bvh import Bvh, Hits, Work, build, intersect_brute_force
from .device_bvh import DeviceBvh
from .double_bvh import DoubleAllHits, DoubleBvh, DoubleHits
from .recipes import Parameter, RecipeWord, parse_recipe, presets, recipe_words
from .report import Report, Stage

if TYPE_CHECKING:
    from .mesh import Mesh, load_mesh

__all__ = [
    "AllHits",
    "Bvh",
    "ClosestPoints",
    "DeviceBvh",
    "DoubleAllHits",
    "DoubleBvh",
    "DoubleHits",
    "FileError",
    "HitChunk",
    "Hits",
    "Mesh",
    "Overlaps",
    "Parameter",
    "PrecisionWarning",
    "RecipeWord",
    "Report",
    "Stage",
    "Work",
    "__version__",
    "build",
    "cuda",
    "intersect_brute_force",
    "load",
    "load_mesh",
    "mesh_hash",
    "parse_recipe",
    "presets",
    "recipe_words",
    "set_thread_count",
    "thread_count",
]


def __getattr__(name: str) -> Any:
    # Half of what importing treelet would cost beside numpy, for those who bring arrays of their own.
    if name in ("Mesh", "load_mesh"):
        from . import mesh

        return getattr(mesh, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return [*globals(), "Mesh", "load_mesh"]
