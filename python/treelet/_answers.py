"""What queries answer, on the host and on devices."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ._inputs import FloatArray


class Hits(NamedTuple):
    """Closest hits, one a ray, in the rays' shape. The hit point is (1-u-v) P0 + u P1 + v P2 of `face`."""

    t: FloatArray
    """float32, in units of the direction's length; inf for a miss."""
    face: np.ndarray[tuple[int, ...], np.dtype[np.int32]]
    """int32 index into the faces that were given; -1 for a miss."""
    u: FloatArray
    """float32; 0 for a miss."""
    v: FloatArray
    """float32; 0 for a miss."""


class Work(NamedTuple):
    """What finding each ray's closest hit took, in the rays' shape."""

    nodes: np.ndarray[tuple[int, ...], np.dtype[np.uint32]]
    """uint32: nodes whose children's boxes were tested."""
    triangles: np.ndarray[tuple[int, ...], np.dtype[np.uint32]]
    """uint32: triangles tested."""
