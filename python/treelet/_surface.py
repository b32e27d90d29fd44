"""The faces behind hits and nearest points: corners, normals, and rays that leave them."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from . import _core
from ._compiled_tree import CompiledTree
from ._inputs import FloatArray, as_points
from ._offset import ORIGIN

FaceNumbers = np.ndarray[tuple[int, ...], np.dtype[np.int32]]


class OnFaces(Protocol):
    """Points of faces: `Hits`, `AllHits` and `ClosestPoints` are such."""

    @property
    def face(self) -> FaceNumbers: ...

    @property
    def u(self) -> FloatArray: ...

    @property
    def v(self) -> FloatArray: ...


class SurfaceQueries(CompiledTree):
    """What the tree knows of its faces. The first call makes a table of 4 bytes a face."""

    def triangles(self, face: ArrayLike) -> np.ndarray[tuple[int, ...], np.dtype[np.floating[Any]]]:
        """Corners of faces, as the tree has them.

        Args:
            face: (...) integers, such as `hits.face`.

        Returns:
            (..., 3, 3): corner, then x, y, z; float32, or float64 where the tree has an `offset`. NaN for
            face -1, and for faces that the build left out.

        Raises:
            ValueError: for a face that the mesh does not have.
            TypeError: for numbers that are no integers.
        """
        numbers = self._as_faces(face)
        corners = self._ask(_core.triangles, numbers.reshape(-1)).reshape(*numbers.shape, 3, 3)
        return corners if self._offset == ORIGIN else corners + np.array(self._offset)

    def normals(self, face: ArrayLike, *, facing: ArrayLike | None = None) -> FloatArray:
        """Geometric normals of length one, on the side from which a face turns counter-clockwise.

        They are computed in float64 from the float32 corners, exactly where that would cancel, and rounded.

        Args:
            face: (...) integers, such as `hits.face`.
            facing: (..., 3) float, directions of rays: where one sees the face's back, the normal is turned
                over, so that it never points along the ray. By default none is turned.

        Returns:
            (..., 3) float32 of the broadcast leading shape; NaN for face -1, for faces that the build left
            out, and for triangles without area.

        Raises:
            ValueError: for a face that the mesh does not have, and where the shapes do not fit each other.
            TypeError: for numbers that are no integers.
        """
        numbers = self._as_faces(face)
        if facing is None:
            return self._ask(_core.normals, numbers.reshape(-1)).reshape(*numbers.shape, 3)
        directions = as_points(facing, "facing")
        shape = _common_shape("face", numbers.shape, "facing", directions.shape)
        rows = _rows(numbers, shape), _rows(directions.array.reshape(*directions.shape, 3), shape, 3)
        return self._ask(_core.normals, *rows).reshape(*shape, 3)

    def spawn(
        self, hits: OnFaces, directions: ArrayLike
    ) -> np.ndarray[tuple[int, ...], np.dtype[np.floating[Any]]]:
        """Origins for rays that go on from hits, none of which meets the face that it leaves.

        The point of the hit is moved along the face's normal to the side to which the direction goes, by a
        bound on what rounding can do: 2^-22 of the triangle's extent, and a float of each coordinate. So a
        ray with such an origin, the same direction and t_min = 0 does not report its own face, however
        it grazes, and a t_min that would also swallow thin gaps is not needed
        (docs/algorithms/spawn.md). Other faces near an edge may lie closer than that.

        Args:
            hits: (...) answers of `intersect`, `intersect_all` or `closest_point`: whatever has `face`, `u`
                and `v`.
            directions: (..., 3) float, of the rays that leave. Give the query the same ones.

        Returns:
            (..., 3) origins of the broadcast leading shape: float32, or float64 where the tree has an
            `offset`. NaN where there is no hit, and such rays miss.

        Raises:
            ValueError: for a face that the mesh does not have, and where the shapes do not fit each other.
            TypeError: for faces that are no integers, and for hits without `face`, `u` and `v`.
        """
        if not all(hasattr(hits, part) for part in ("face", "u", "v")):
            raise TypeError(
                f"hits must be an answer with face, u and v, as of intersect, not {type(hits).__name__}"
            )
        numbers, leaving = self._as_faces(hits.face), as_points(directions, "directions")
        for name, weight in (("u", hits.u), ("v", hits.v)):
            if np.shape(weight) != numbers.shape:
                shapes = f"{numbers.shape}, not {np.shape(weight)}"
                raise ValueError(f"{name} of hits must have the shape of their face, {shapes}")
        shape = _common_shape("hits", numbers.shape, "directions", leaving.shape)
        weights = [_rows(np.asarray(weight, np.float32), shape) for weight in (hits.u, hits.v)]
        vectors = _rows(leaving.array.reshape(*leaving.shape, 3), shape, 3)
        faces = _rows(numbers, shape)
        far = max(abs(part) for part in self._offset)
        origins = self._ask(_core.spawn, len(faces), faces, *weights, vectors, far).reshape(*shape, 3)
        return origins if self._offset == ORIGIN else origins + np.array(self._offset)

    def _as_faces(self, face: ArrayLike) -> FaceNumbers:
        numbers = np.asarray(face)
        if numbers.dtype.kind not in "iu":
            raise TypeError(f"face must hold integers, not {numbers.dtype}")
        count = self.face_count
        if numbers.size and (numbers.min() < -1 or numbers.max() >= count):
            worst = numbers.min() if numbers.min() < -1 else numbers.max()
            raise ValueError(f"there is no face {worst}: the mesh has {count}, and -1 stands for none")
        return np.asarray(numbers, np.int32, order="C")


def _common_shape(first: str, own: tuple[int, ...], second: str, other: tuple[int, ...]) -> tuple[int, ...]:
    try:
        return np.broadcast_shapes(own, other)
    except ValueError:
        raise ValueError(
            f"{first} for {own} and {second} for {other} cannot be broadcast against each other"
        ) from None


def _rows(array: np.ndarray[Any, Any], shape: tuple[int, ...], *row: int) -> np.ndarray[Any, Any]:
    return np.ascontiguousarray(np.broadcast_to(array, (*shape, *row))).reshape(-1, *row)
