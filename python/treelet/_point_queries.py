"""What a mesh is to points, boxes and balls: nearest, around, or met."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from . import _core
from ._compiled_tree import CompiledTree
from ._inputs import FloatArray, as_boxes, as_points, as_spheres
from ._offset import ORIGIN
from ._outputs import Output, as_output, as_outputs


class ClosestPoints(NamedTuple):
    """Nearest points of the mesh, one for each point that was given, in their shape (...).

    The nearest point is (1-u-v) P0 + u P1 + v P2 of `face`.
    """

    point: np.ndarray[tuple[int, ...], np.dtype[np.floating[Any]]]
    """(..., 3) float32, or float64 where the tree has an `offset`; NaN where there is none."""
    distance: FloatArray
    """float32, in the mesh's units; inf where there is none."""
    face: np.ndarray[tuple[int, ...], np.dtype[np.int32]]
    """int32 index into the faces that were given; -1 where there is none."""
    u: FloatArray
    """float32; 0 where there is none."""
    v: FloatArray
    """float32; 0 where there is none."""


class Overlaps(NamedTuple):
    """Faces that N boxes or balls meet: those of number i are `face[offsets[i]:offsets[i + 1]]`."""

    offsets: np.ndarray[tuple[int], np.dtype[np.int64]]
    """(N + 1,) int64; boxes and balls of any leading shape are numbered as in C order."""
    face: np.ndarray[tuple[int], np.dtype[np.int32]]
    """(overlaps,) int32 index into the faces that were given: ascending, each once in a row."""


class PointQueries(CompiledTree):
    """Nearest points, inside and outside, and overlaps.

    Points are rounded to float32, relative to `offset`. All take any leading shape. `out` is an array to
    write the answers to and to return, as for `Bvh.intersect`.
    """

    def closest_point(
        self, points: ArrayLike, max_distance: ArrayLike = np.inf, *, out: ClosestPoints | None = None
    ) -> ClosestPoints:
        """Find the point of the mesh that is nearest to each point.

        Of equal distances the smaller face. Distances are computed in float64 from the float32 triangles, and
        rounded once.

        Args:
            points: (..., 3) float.
            max_distance: (...) or scalar, in the mesh's units: points of the mesh that are farther do not
                count. A small one saves time.
            out: arrays to write the answers to, as for `Bvh.intersect`.

        Returns:
            ClosestPoints(point, distance, face, u, v), arrays of the broadcast leading shape; `out` itself
            where it is given. There is no
            nearest point, so NaN, inf and face -1, in an empty mesh, for a point with NaN or infinity, and
            for a NaN or negative max_distance.

        Raises:
            ValueError: where the shapes do not fit each other.
            TypeError: where an array does not hold numbers, or lies on a CUDA device.
            RuntimeError: while another thread updates the tree.
        """
        balls = as_spheres(points, max_distance, ("points", "max_distance"), self._offset)
        room = as_outputs(out, self._closest_outputs(balls.shape))
        local = None if self._offset == ORIGIN or room is None else room[0]
        if room is not None and local is not None:
            room[0] = None  # float64, for which the answers in float32 are made first
        point, *rest = self._ask(_core.closest_point, *balls.arguments, room)
        place = point.reshape(*balls.shape, 3)
        if self._offset != ORIGIN:
            given = None if local is None else local.reshape(place.shape)
            place = np.add(place, np.array(self._offset), out=given)
        return ClosestPoints(place, *(array.reshape(balls.shape) for array in rest)) if out is None else out

    def _closest_outputs(self, shape: tuple[int, ...]) -> list[Output]:
        point = np.float32 if self._offset == ORIGIN else np.float64
        rest = ("distance", np.float32), ("face", np.int32), ("u", np.float32), ("v", np.float32)
        return [
            Output("out.point", (*shape, 3), point),
            *(Output(f"out.{name}", shape, dtype) for name, dtype in rest),
        ]

    def distance(self, points: ArrayLike, *, out: FloatArray | None = None) -> FloatArray:
        """The distance of each point (..., 3) from the mesh, float32 (...). As `closest_point`; faster."""
        given = as_points(points, "points", self._offset)
        room = as_output(out, Output("out", given.shape, np.float32))
        answers = self._ask(_core.distance, given.array, room).reshape(given.shape)
        return answers if out is None else out

    def signed_distance(self, points: ArrayLike, *, out: FloatArray | None = None) -> FloatArray:
        """`distance`, negative where the mesh `contains` the point, float32 (...).

        inf where there is no nearest point: in an empty mesh, and for a point with NaN or infinity.
        The sign is exact for closed meshes. For others take that of `winding_number(points) - 0.5`.
        """
        given = as_points(points, "points", self._offset)
        room = as_output(out, Output("out", given.shape, np.float32))
        answers = self._ask(_core.signed_distance, given.array, room).reshape(given.shape)
        return answers if out is None else out

    def contains(
        self, points: ArrayLike, *, out: np.ndarray[tuple[int, ...], np.dtype[np.bool_]] | None = None
    ) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
        """Whether each point (..., 3) is inside of the mesh, bool (...).

        Exact for closed meshes, whatever way their faces are turned: a point is inside if a ray from it
        crosses the mesh an odd number of times. On the surface, the side of larger coordinates decides, so of
        two solids that touch one contains the point. For a mesh with holes the answer is that of one ray,
        nearly along the negative x axis: `winding_number(points) > 0.5` is the better question then. False
        for points with NaN or infinity.
        """
        given = as_points(points, "points", self._offset)
        room = as_output(out, Output("out", given.shape, np.bool_))
        answers = self._ask(_core.contains, given.array, room).reshape(given.shape)
        return answers if out is None else out

    def winding_number(
        self, points: ArrayLike, accuracy: float = 2.0, *, out: FloatArray | None = None
    ) -> FloatArray:
        """How often the mesh winds around each point (..., 3), float32 (...).

        For a closed mesh with counterclockwise faces 1 inside and 0 outside; for one with holes or
        overlaps something between that is above a half inside. NaN for points with NaN or infinity.

        Args:
            points: (..., 3) float.
            accuracy: from how many of its radii on a part of the mesh is taken as a whole: 2 errs by
                some thousandths at most, 6 by some hundred-thousandths, infinity by rounding alone and
                takes time proportional to the mesh.

        Raises:
            ValueError: for an accuracy below 1, whose parts would contain the point, or NaN.
            TypeError: for an accuracy that is no number.
        """
        if isinstance(accuracy, bool) or not isinstance(accuracy, int | float | np.number):
            raise TypeError(f"accuracy must be a number, not {type(accuracy).__name__}")
        if not accuracy >= 1:
            raise ValueError(f"accuracy must be a number from 1 to infinity, not {accuracy!r}")
        given = as_points(points, "points", self._offset)
        room = as_output(out, Output("out", given.shape, np.float32))
        answers = self._ask(_core.winding_number, given.array, float(accuracy), room)
        return answers.reshape(given.shape) if out is None else out

    def overlap_boxes(self, lower: ArrayLike, upper: ArrayLike) -> Overlaps:
        """List the faces that have a point in common with each box; touching counts.

        Nothing is rounded but the corners themselves, to float32.

        Args:
            lower: (..., 3) float, corners with the smallest coordinates; may be -inf.
            upper: (..., 3) float, corners with the largest ones; may be inf.

        Returns:
            Overlaps(offsets, face). A box with NaN, or with lower beyond upper, meets no face.

        Raises:
            ValueError: where the shapes do not fit each other.
            TypeError: where an array does not hold numbers, or lies on a CUDA device.
        """
        boxes = as_boxes(lower, upper, self._offset)
        return Overlaps(*self._ask(_core.overlap_boxes, *boxes.arguments))

    def overlap_spheres(self, centers: ArrayLike, radii: ArrayLike) -> Overlaps:
        """List the faces that are at most a radius from each centre: those whose `distance` is at most that.

        Args:
            centers: (..., 3) float.
            radii: (...) or scalar. A negative or NaN one meets no face.

        Returns:
            Overlaps(offsets, face). Errors as `overlap_boxes`.
        """
        spheres = as_spheres(centers, radii, ("centers", "radii"), self._offset)
        return Overlaps(*self._ask(_core.overlap_spheres, *spheres.arguments))
