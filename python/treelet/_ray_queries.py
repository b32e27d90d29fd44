"""Ray queries of trees on the host; `_device_queries.py` has those of trees on CUDA devices."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from . import _core
from ._answers import Hits, Work
from ._compiled_tree import CompiledTree
from ._inputs import as_flag, as_rays


class RayQueries(CompiledTree):
    """Closest hit, any hit, and what finding them costs."""

    def intersect(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
        *,
        reorder: bool = False,
    ) -> Hits:
        """Find the closest hit of each ray: the smallest t in [t_min, t_max], of equal t the smaller face.

        Watertight: no ray slips between triangles that share an edge or a vertex.

        A camera's rays are found faster in the shape of their picture, (height, width, 3), than in rows of
        (height * width, 3): where width is a multiple of 4, they are then traced by tiles of 4 x 4. Answers
        are the same.

        Args:
            origins: (..., 3) float.
            directions: (..., 3) float, of any length that float32 can hold but zero; t counts in it.
            t_min: (...) or scalar.
            t_max: (...) or scalar, included.
            reorder: sort the rays for coherence before they are traced. Pays for incoherent batches of a
                million and more, in large scenes; answers stay in the order of the rays.

        Returns:
            Hits(t, face, u, v), arrays of the broadcast leading shape.

        Raises:
            ValueError: where the shapes do not fit each other.
            TypeError: where an array does not hold numbers, or lies on a CUDA device.
            RuntimeError: while another thread updates the tree.
        """
        rays = as_rays(origins, directions, t_min, t_max, self._offset)
        hits = self._ask(_core.intersect, *rays.arguments, as_flag(reorder, "reorder"), rays.row)
        return Hits(*(array.reshape(rays.shape) for array in hits))

    def occluded(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
        *,
        reorder: bool = False,
    ) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
        """Whether each ray hits anything in [t_min, t_max]. Arguments and errors as `intersect`.

        Returns:
            bool array of the broadcast leading shape. Faster than `intersect`: the first hit found ends it.
        """
        rays = as_rays(origins, directions, t_min, t_max, self._offset)
        occluded = self._ask(_core.occluded, *rays.arguments, as_flag(reorder, "reorder"), rays.row)
        return occluded.reshape(rays.shape)

    def traversal_cost(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
        *,
        reorder: bool = False,
    ) -> Work:
        """Count the work that `intersect` does for each ray. Arguments and errors as `intersect`.

        Rays are counted one by one, also where `intersect` traces them in packets. The counts are the same on
        every machine, so they compare trees where timings are noisy.

        Returns:
            Work(nodes, triangles), uint32 arrays of the broadcast leading shape.
        """
        rays = as_rays(origins, directions, t_min, t_max, self._offset)
        counts = self._ask(_core.traversal_cost, *rays.arguments, as_flag(reorder, "reorder"))
        return Work(*(array.reshape(rays.shape) for array in counts))
