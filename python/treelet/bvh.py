"""The tree: what `treelet.build` returns."""

from __future__ import annotations

from contextlib import nullcontext
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _core
from ._answers import Hits, Work
from ._device import is_on_device, require_current_device, shape_on_device
from ._files import TreeFiles
from ._guard import UseGuard
from ._hit_lists import HitLists
from ._inputs import Vertices, as_faces, as_flag, as_rays, as_recipe, as_vertices
from ._offset import Bounds, add_offset
from ._point_queries import PointQueries
from ._ray_queries import RayQueries
from ._surface import SurfaceQueries
from .device_bvh import DeviceBvh, build_on_device, move_to_device
from .double_bvh import build_double
from .report import Report

__all__ = ["Bvh", "Hits", "Work", "build", "intersect_brute_force"]


class Bvh(RayQueries, HitLists, PointQueries, SurfaceQueries, TreeFiles):
    """A bounding volume hierarchy over a triangle mesh, safe to query from many threads.

    It owns a copy of the triangles, and never changes unless it was built with `updatable=True`: then `refit`
    and `rebuild` move it to where the mesh is now. Other threads that use the tree meanwhile get a
    RuntimeError.

    Every query takes any leading shape: origins and directions (..., 3)
    and t_min and t_max (...) are broadcast against each other, and the answers have the broadcast shape.
    Rays are rounded to float32, their origins relative to `offset`. Rays with a NaN or infinite origin or
    direction, a zero direction or a NaN limit miss.
    """

    def __init__(
        self,
        core: _core.Bvh,
        updatable: _core.UpdatableBvh | None = None,
        *,
        is_moved: bool = False,
    ) -> None:
        """Not for users: call `treelet.build`."""
        self._core, self._is_moved = core, is_moved
        self._updatable = updatable
        self._guard = UseGuard() if updatable else None
        self._reading = self._guard.query if self._guard else nullcontext
        self._offset, rounding = _core.placement(core)
        self._updates = 0
        self._report = Report(core, rounding, self._reading)

    def refit(self, vertices: ArrayLike) -> None:
        """Move the triangles to where the vertices are now and fit the boxes, but keep the tree's shape.

        Many times faster than `rebuild`, and every answer is right, however far the vertices move; but rays
        slow down the less the mesh looks as it did at the build. `report.layout_sah` against
        `report.layout_sah_at_build` tells how much. Triangles that are not finite any more, or have two equal
        vertices, are not hit until they have a shape again (`report.hidden`); those that the build left out
        stay out until a rebuild.

        Args:
            vertices: (V, 3) as for `treelet.build`, as many as there: the faces are those of the build. The
                tree keeps its `offset`: where a mesh moves far away in float64, rebuild it.

        Recipes that split triangles (`presplit`, `trysplit`, `sbvh`, `trysbvh`, the presets `better` and
        `best`) lose more by a refit than splitting gained: their pieces get the boxes of whole triangles.
        Rebuild such trees.

        Raises:
            RuntimeError: for a tree built without `updatable=True`, or while another thread uses it.
            ValueError: for a wrong shape or another number of vertices; the tree stays as it was.
            TypeError: for an array that does not hold numbers.
        """
        tree, guard = self._require_updatable()
        points = as_vertices(vertices, self._offset, tree.require_vertex_count)
        with guard.update():
            tree.refit(points.array)
            self._accept(points)

    def rebuild(self, vertices: ArrayLike) -> None:
        """Run the whole recipe again over moved vertices. Arguments and errors as `refit`.

        The tree is that of `treelet.build`; from the second rebuild on it takes no new memory.
        """
        tree, guard = self._require_updatable()
        points = as_vertices(vertices, None, tree.require_vertex_count)
        with guard.update():
            tree.rebuild(points.array)
            self._accept(points)

    def _accept(self, points: Vertices) -> None:
        """Tell queries and report where the vertices are now."""
        self._updates += 1
        self._offset = points.offset
        self._report = Report(_place(self._core, points), points.rounding, self._reading)

    def to(self, device: str, *, stream: Any = None) -> Bvh | DeviceBvh:
        """This tree elsewhere: "cuda" copies it to the current CUDA device and waits; "cpu" is where it is.

        A copy cannot be updated.

        Args:
            device: "cpu", "cuda" or the current device's own name, as "cuda:0".
            stream: the CUDA stream to copy in: an address, a stream of torch or cupy, or anything with
                `__cuda_stream__`; the default stream if None. Not used for "cpu".

        Raises:
            ValueError: for any other device.
            TypeError: for a stream of another kind.
            RuntimeError: where there is no CUDA device, and while another thread updates the tree.
        """
        if device == "cpu":
            return self
        if device != "cuda":
            require_current_device(device)
        with self._reading():
            return move_to_device(self._core, stream)

    def _require_updatable(self) -> tuple[_core.UpdatableBvh, UseGuard]:
        if self._is_moved:
            raise RuntimeError(
                "this tree was moved here from a CUDA device, and a moved tree cannot be updated: build it "
                "from host arrays with treelet.build(vertices, faces, updatable=True)"
            )
        if self._updatable is None or self._guard is None:
            raise RuntimeError(
                "this tree cannot be updated: build it with treelet.build(vertices, faces, updatable=True)"
            )
        return self._updatable, self._guard

    def validate(self, vertices: ArrayLike | None = None, faces: ArrayLike | None = None) -> list[str]:
        """List what is wrong with the tree, at most 20 sentences; empty for a sound one.

        Given the mesh again, it also checks that the tree holds that mesh's triangles, none missing. Those
        that a refit has hidden are named then, for a build would leave them out.

        Args:
            vertices: (V, 3), where the mesh is now.
            faces: (F, 3) integers.

        Raises:
            ValueError: for a wrong shape, or a face index out of range.
            TypeError: for vertices without faces or faces without vertices, and for arrays that do not hold
                numbers or lie on a CUDA device.
            RuntimeError: while another thread updates the tree.
        """
        if vertices is None and faces is None:
            return self._ask(_core.Bvh.validate)
        if vertices is None or faces is None:
            raise TypeError("validate takes both vertices and faces, or neither")
        points = as_vertices(vertices, self._offset).array
        return self._ask(_core.Bvh.validate_against, points, as_faces(faces, len(points)))

    @property
    def report(self) -> Report:
        """What the build did: times, costs, counts, bytes."""
        return self._report

    @property
    def face_count(self) -> int:
        """Faces that were given, left-out ones included."""
        return self._report.faces

    @property
    def bounds(self) -> Bounds:
        """(2, 3) float32: lower and upper corner; inf and -inf for an empty tree.

        Triangles that a refit has hidden (`report.hidden`) keep a place in it: a vertex that is still finite,
        else where they were. A rebuild leaves them out.

        float64 where `offset` is not zero, for the corners may lie between two float32.
        """
        with self._reading():
            return add_offset(np.array(self._core.bounds, dtype=np.float32), self._offset)

    def __repr__(self) -> str:
        report = self._report
        size = f"depth {report.depth}, {report.bytes / 2**20:.1f} MiB"
        return (
            f"<treelet.Bvh of {report.faces:,} faces: {report.recipe}, SAH {report.sah:.1f}, {size}, "
            f"built in {report.build_seconds * 1e3:.0f} ms>"
        )


def build(
    vertices: ArrayLike,
    faces: ArrayLike,
    recipe: str | None = None,
    *,
    rays: float | None = None,
    precision: str = "float32",
    updatable: bool = False,
    validate: bool = False,
    stream: Any = None,
) -> Any:
    """Build a tree over a triangle mesh, where the mesh lies: on the CPU, or on a CUDA device.

    Triangles with a NaN or infinite vertex, and triangles with two equal vertices, are left out and counted
    in the report. An empty mesh gives a tree that every ray misses. The same input and recipe give the same
    tree, whatever the number of threads.

    Args:
        vertices: (V, 3) float32. Other numbers are rounded to float32, of a mesh far from the origin after
            an offset near it was subtracted exactly (`Bvh.offset`). Where rounding moves a vertex by more
            than a millionth of the mesh's extent, a `treelet.PrecisionWarning` says so.
        faces: (F, 3) integer indices into vertices.
        recipe: the name of a preset (see `treelet.presets`) or the text of a recipe, such as
            "lbvh > treelet(size=8) > bvh8" (see `treelet.recipe_words`); "balanced" if None.
        rays: how many rays the tree is for, instead of a recipe: the preset that is expected to build and
            trace in the least time, `report.recipe` tells which. Neither `better` nor `best` for updatable
            trees, whose pieces a refit would spoil, nor on a device, which cannot build them.
        precision: "float32", or "float64" for a `treelet.DoubleBvh`: no vertex is rounded, rays and answers
            are float64 (docs/precision.md). On the CPU, for recipes that split no triangles and end in bvh8.
        updatable: keep what `Bvh.refit` and `Bvh.rebuild` need: 12 bytes a face, and from the first rebuild
            on the memory that a build takes (`report.held_bytes`).
        validate: check the tree after every stage; about doubles the time.
        stream: for arrays on a device: an address, a stream of torch or cupy, or anything with
            `__cuda_stream__`; by default the current stream of the vertices' library.

    Arrays on a CUDA device (of torch, cupy, jax, numba or any library with `__cuda_array_interface__`) give a
    `treelet.DeviceBvh`, built there: vertices must be float32 and faces integers of 32 or 64 bits, both
    contiguous. They are read in place, but faces of 64 bits are copied to 32 once. Work is enqueued on
    `stream` and waited for once.

    Returns:
        A `treelet.Bvh`, a `treelet.DeviceBvh` for arrays on a device, or a `treelet.DoubleBvh`.

    Raises:
        ValueError: for a wrong shape, a face index out of range (the first is named), a bad recipe, or one
            that the precision does not go with.
        TypeError: for arrays that do not hold numbers, faces that are no integers, a recipe that is no text,
            one array on the host and one on a device, a stream for arrays on the host, a recipe beside rays.
        RuntimeError: where validation finds a violation, which is a bug in treelet; where CUDA fails, or has
            no version of a word of the recipe.
    """
    is_double = _is_double(precision)
    if is_on_device(vertices):
        if is_double:
            raise ValueError(
                'precision="float64" is for arrays on the host, and the vertices lie on a CUDA device: copy '
                "them to the host, or leave out precision and subtract an offset before rounding to float32"
            )
        chosen = _choose_recipe(recipe, rays, shape_on_device(faces), may_split=False)
        return build_on_device(vertices, faces, chosen, updatable=updatable, validate=validate, stream=stream)
    if stream is not None:
        raise TypeError("stream is for arrays on a CUDA device, and the vertices lie on the host")
    if is_double:
        choose = partial(_choose_recipe, recipe, rays, may_split=False)
        return build_double(vertices, faces, choose, updatable=updatable, validate=validate)
    points = as_vertices(vertices)
    corners = as_faces(faces, len(points.array))
    updatable = as_flag(updatable, "updatable")
    chosen = _choose_recipe(recipe, rays, corners.shape, may_split=not updatable)
    arguments = (points.array, corners, as_recipe(chosen), as_flag(validate, "validate"))
    if not updatable:
        return Bvh(_place(_core.build(*arguments), points))
    tree = _core.build_updatable(*arguments)
    return Bvh(_place(tree.bvh, points), tree)


def _is_double(precision: str) -> bool:
    if not isinstance(precision, str):
        raise TypeError(f"precision must be text, not {type(precision).__name__}")
    if precision not in ("float32", "float64"):
        raise ValueError(f'precision must be "float32" or "float64", not {precision!r}')
    return precision == "float64"


def _choose_recipe(recipe: str | None, rays: float | None, shape: tuple[int, ...], *, may_split: bool) -> str:
    if rays is None:
        return "balanced" if recipe is None else recipe
    if recipe is not None:
        raise TypeError("build takes a recipe or the number of rays to choose one by, not both")
    if isinstance(rays, bool) or not isinstance(rays, int | float | np.number):
        raise TypeError(f"rays must be a number, not {type(rays).__name__}")
    if not rays >= 0:
        raise ValueError(f"rays must be a number that is not negative, not {rays}")
    return _core.choose_preset(shape[0] if shape else 0, float(min(rays, 1e300)), may_split)


def _place(core: _core.Bvh, points: Vertices) -> _core.Bvh:
    """The tree, which is told how its vertices became float32."""
    _core.place(core, points.offset, points.rounding)
    return core


def intersect_brute_force(
    vertices: ArrayLike,
    faces: ArrayLike,
    origins: ArrayLike,
    directions: ArrayLike,
    t_min: ArrayLike = 0.0,
    t_max: ArrayLike = np.inf,
) -> Hits:
    """Answer `Bvh.intersect` by testing every triangle: slow, for checking. Arguments and errors as there."""
    points = as_vertices(vertices)
    corners = as_faces(faces, len(points.array))
    rays = as_rays(origins, directions, t_min, t_max, points.offset)
    hits = _core.intersect_brute_force(points.array, corners, *rays.arguments)
    return Hits(*(array.reshape(rays.shape) for array in hits))
