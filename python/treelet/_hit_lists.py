"""All hits of rays instead of the first: listed, counted, and in chunks."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from . import _core
from ._compiled_tree import CompiledTree
from ._core import RayFilter
from ._inputs import FloatArray, Rays, as_count, as_flag, as_rays
from ._outputs import Output, as_output
from ._ray_options import Cull, Masks, as_filter, as_masks

_NO_LIMIT = 2**63 - 1
_RAYS_PER_COUNT = 2**18  # rays whose hits are counted at a time before they are listed

OffsetArray = np.ndarray[tuple[int], np.dtype[np.int64]]
CountArray = np.ndarray[tuple[int, ...], np.dtype[np.int64]]


class AllHits(NamedTuple):
    """All hits of N rays, one ray's after the other's: those of ray i are `offsets[i]:offsets[i + 1]`.

    Each ray's hits are sorted by (t, face). The hit point is (1-u-v) P0 + u P1 + v P2 of `face`.
    """

    offsets: OffsetArray
    """(N + 1,) int64; rays of any leading shape are numbered as in C order."""
    t: FloatArray
    """(hits,) float32, in units of the direction's length."""
    face: np.ndarray[tuple[int, ...], np.dtype[np.int32]]
    """(hits,) int32 index into the faces that were given."""
    u: FloatArray
    """(hits,) float32."""
    v: FloatArray
    """(hits,) float32."""

    @property
    def ray(self) -> CountArray:
        """(hits,) int64: the number of each hit's ray."""
        return np.repeat(np.arange(len(self.offsets) - 1), np.diff(self.offsets))


class HitChunk(NamedTuple):
    """Consecutive rays and all of their hits."""

    first_ray: int
    """Number of the first ray of the chunk, in C order."""
    hits: AllHits
    """Hits of the chunk's rays, which are numbered from zero."""


class HitLists(CompiledTree):
    """Every crossing of a ray with the mesh.

    A ray crosses a surface once, also where it passes through an edge or a vertex: the crossing belongs to
    one of the triangles there. So counts on a closed mesh are even from outside and odd from inside, without
    exception (docs/algorithms/all-hits.md). Where a surface turns away from the ray, a silhouette, the ray
    crosses none or two of its triangles, and `intersect`, for which edges belong to all their triangles,
    may report a hit where these report none. The sign of t is exact.
    """

    def intersect_all(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
        *,
        active: ArrayLike | None = None,
        face_mask: ArrayLike | None = None,
        cull: Cull = "none",
        limit: int | None = None,
        reorder: bool = False,
    ) -> AllHits:
        """Find all hits of each ray with t in [t_min, t_max], sorted by (t, face), each face once.

        Args:
            origins: (..., 3) float.
            directions: (..., 3) float, of any length that float32 can hold but zero; t counts in it.
            t_min: (...) or scalar, included.
            t_max: (...) or scalar, included. Hits beyond the largest float32 have t = inf and belong to rays
                whose t_max is infinite.
            active: (...) bool, which rays are traced; the others have no hits. By default all.
            face_mask: (faces,) bool, which faces count; the others are as if they were not there. By default
                all.
            cull: "back" leaves out the faces whose back a ray sees, "front" those whose front it sees: the
                side from which the corners turn counter-clockwise. Decided exactly.
            limit: the first so many hits of each ray; by default all. Up to 16 save time, too.
            reorder: sort the rays for coherence before they are traced, as for `intersect`; answers stay in
                the order of the rays.

        Returns:
            AllHits(offsets, t, face, u, v). It takes 16 bytes a hit and 8 a ray, and while it is made twice
            that: `stream_hits` bounds it.

        Raises:
            ValueError: where the shapes do not fit each other, or limit is less than 1.
            TypeError: where an array does not hold numbers, or lies on a CUDA device.
            RuntimeError: while another thread updates the tree.
        """
        rays = as_rays(origins, directions, t_min, t_max, self._offset)
        most = as_limit(limit)
        shown = as_filter(rays, active, face_mask, cull, self.face_count)
        return self._list_hits(rays, most, as_flag(reorder, "reorder"), shown)

    def count_hits(
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
        out: CountArray | None = None,
    ) -> CountArray:
        """Count the hits that `intersect_all` lists. Arguments and errors as there.

        Returns:
            int64 array of the broadcast leading shape, which `out` may be. Takes no memory but that, and a
            little less time than listing the hits.
        """
        rays = as_rays(origins, directions, t_min, t_max, self._offset)
        shown = as_filter(rays, active, face_mask, cull, self.face_count)
        room = as_output(out, Output("out", rays.shape, np.int64))
        counts = self._ask(_core.count_hits, *rays.arguments, as_flag(reorder, "reorder"), shown, room)
        return counts.reshape(rays.shape) if out is None else out

    def stream_hits(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
        *,
        active: ArrayLike | None = None,
        face_mask: ArrayLike | None = None,
        cull: Cull = "none",
        limit: int | None = None,
        max_hits: int = 1_000_000,
        reorder: bool = False,
    ) -> Iterator[HitChunk]:
        """Find the hits of `intersect_all` in chunks of bounded size. Arguments and errors as there.

        Args:
            origins: see `intersect_all`, as for all that follow.
            directions: ...
            t_min: ...
            t_max: ...
            active: ...
            face_mask: ...
            cull: ...
            limit: ...
            max_hits: of a chunk; a single ray that has more is a chunk of its own.
            reorder: ...

        Returns:
            An iterator over HitChunk(first_ray, hits), which together hold all rays in order. Hits are
            counted before they are listed, so that no chunk takes more memory than it says. If the tree is
            updated before the iterator ends, that raises a RuntimeError.
        """
        rays = as_rays(origins, directions, t_min, t_max, self._offset)
        most = as_limit(limit)
        options = as_masks(rays, active, face_mask, cull, self.face_count)
        count = min(as_count(max_hits, "max_hits"), _NO_LIMIT)
        return self._chunks(rays, most, count, as_flag(reorder, "reorder"), options)

    def _chunks(
        self, rays: Rays, limit: int, max_hits: int, reorder: bool, masks: Masks
    ) -> Iterator[HitChunk]:
        count, updates = rays.arguments[0], self._updates
        for first in range(0, count, _RAYS_PER_COUNT):
            last = min(first + _RAYS_PER_COUNT, count)
            block = _part(rays, first, last)
            counts = self._ask(_core.count_hits, *block.arguments, reorder, masks.part(first, last))
            ends = np.cumsum(np.minimum(counts, limit))
            begin = done = 0
            while begin < len(ends):
                end = max(int(np.searchsorted(ends, done + max_hits, side="right")), begin + 1)
                shown = masks.part(first + begin, first + end)
                hits = self._list_hits(_part(block, begin, end), limit, reorder, shown)
                if self._updates != updates:
                    raise RuntimeError("the tree was updated while its hits were streamed: begin again")
                yield HitChunk(first + begin, hits)
                begin, done = end, int(ends[end - 1])

    def _list_hits(self, rays: Rays, limit: int, reorder: bool, shown: RayFilter | None) -> AllHits:
        return AllHits(*self._ask(_core.intersect_all, *rays.arguments, limit, reorder, shown))


def _part(rays: Rays, begin: int, end: int) -> Rays:
    _, origins, directions, t_min, t_max = rays.arguments

    def rows(array: FloatArray) -> FloatArray:
        return array if len(array) == 1 else array[begin:end]

    arguments = (end - begin, rows(origins), rows(directions), rows(t_min), rows(t_max))
    return Rays((end - begin,), arguments)


def as_limit(limit: int | None) -> int:
    """How many hits of each ray are kept."""
    return _NO_LIMIT if limit is None else min(as_count(limit, "limit"), _NO_LIMIT)
