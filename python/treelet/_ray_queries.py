"""Ray queries of trees on the host; `_device_queries.py` has those of trees on CUDA devices."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from . import _core
from ._answers import Hits, Work
from ._compiled_tree import CompiledTree
from ._inputs import as_flag, as_rays
from ._outputs import Output, as_output, as_outputs
from ._ray_options import Cull, as_filter

_HITS = ("out.t", np.float32), ("out.face", np.int32), ("out.u", np.float32), ("out.v", np.float32)


class RayQueries(CompiledTree):
    """Closest hit, any hit, and what finding them costs."""

    def intersect(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
        *,
        active: ArrayLike | None = None,
        face_mask: ArrayLike | None = None,
        cull: Cull = "none",
        reorder: bool = False,
        out: Hits | None = None,
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
            active: (...) bool, which rays are traced; the others miss, and take next to no time. Must
                fit the rays' shape. By default all.
            face_mask: (faces,) bool, which faces rays can hit; they pass through the others, as through
                glass, to what lies behind. By default all.
            cull: "back" lets rays pass through faces whose back they see, "front" through those whose front
                they see: the side from which the corners turn counter-clockwise. Decided exactly.
            reorder: sort the rays for coherence before they are traced. Pays for incoherent batches of a
                million and more, in large scenes; answers stay in the order of the rays.
            out: Hits of arrays to write the answers to, as an earlier call returned them: numpy arrays or
                tensors of torch on the CPU, of the broadcast leading shape, contiguous, that overlap
                neither each other nor the rays.

        Returns:
            Hits(t, face, u, v), arrays of the broadcast leading shape; `out` itself where it is given.

        Raises:
            ValueError: where the shapes do not fit each other, `out` is not contiguous, or `cull` is another
                word.
            TypeError: where an array does not hold numbers, a mask no booleans, or `out` not the answer's
                dtypes, and where one lies on a CUDA device.
            RuntimeError: while another thread updates the tree.
        """
        rays = as_rays(origins, directions, t_min, t_max, self._offset)
        shown = as_filter(rays, active, face_mask, cull, self.face_count)
        room = as_outputs(out, [Output(name, rays.shape, dtype) for name, dtype in _HITS])
        order = as_flag(reorder, "reorder")
        hits = self._ask(_core.intersect, *rays.arguments, order, rays.row, shown, room)
        return Hits(*(array.reshape(rays.shape) for array in hits)) if out is None else out

    def occluded(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
        *,
        active: ArrayLike | None = None,
        face_mask: ArrayLike | None = None,
        cull: Cull = "none",
        reorder: bool = False,
        out: np.ndarray[tuple[int, ...], np.dtype[np.bool_]] | None = None,
    ) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
        """Whether each ray hits anything in [t_min, t_max]. Arguments and errors as `intersect`.

        Returns:
            bool array of the broadcast leading shape, which `out` may be. Faster than `intersect`: the first
            hit found ends it.
        """
        rays = as_rays(origins, directions, t_min, t_max, self._offset)
        shown = as_filter(rays, active, face_mask, cull, self.face_count)
        room = as_output(out, Output("out", rays.shape, np.bool_))
        order = as_flag(reorder, "reorder")
        occluded = self._ask(_core.occluded, *rays.arguments, order, rays.row, shown, room)
        return occluded.reshape(rays.shape) if out is None else out

    def traversal_cost(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
        *,
        active: ArrayLike | None = None,
        face_mask: ArrayLike | None = None,
        cull: Cull = "none",
        reorder: bool = False,
    ) -> Work:
        """Count the work that `intersect` does for each ray. Arguments and errors as `intersect`.

        Rays are counted one by one, also where `intersect` traces them in packets. The counts are the same on
        every machine, so they compare trees where timings are noisy.

        Returns:
            Work(nodes, triangles), uint32 arrays of the broadcast leading shape.
        """
        rays = as_rays(origins, directions, t_min, t_max, self._offset)
        shown = as_filter(rays, active, face_mask, cull, self.face_count)
        counts = self._ask(_core.traversal_cost, *rays.arguments, as_flag(reorder, "reorder"), shown)
        return Work(*(array.reshape(rays.shape) for array in counts))
