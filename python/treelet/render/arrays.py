"""Whose arrays a picture is made of: numpy's on the host, cupy's on a CUDA device.

The renderer is written once. A function asks for the module of what it is given, `xp = module_of(values)`,
and calls what both have by the same name. cupy refuses numpy's arrays and numpy cupy's, so nothing changes
sides by accident.
"""

from __future__ import annotations

import sys
from contextlib import AbstractContextManager, nullcontext
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from treelet.device_bvh import DeviceBvh

Array = Any  # numpy.ndarray or cupy.ndarray


class DeviceMesh(NamedTuple):
    """What `treelet.build` and `render` need of a mesh, in the memory of a CUDA device."""

    vertices: Array  # (V, 3) float32
    faces: Array  # (F, 3) integers


def upload_mesh(mesh) -> DeviceMesh:
    """`mesh` in the memory of the current CUDA device. Raises ImportError without cupy."""
    cupy = import_cupy()
    return DeviceMesh(cupy.asarray(mesh.vertices, dtype=np.float32), cupy.asarray(mesh.faces))


def module_for(bvh) -> ModuleType:
    """The module of the arrays that `bvh` is asked with; ImportError where that is cupy and missing."""
    return import_cupy() if isinstance(bvh, DeviceBvh) else np


def module_of(values: Array) -> ModuleType:
    """The module that `values` belong to."""
    return np if isinstance(values, (np.ndarray, np.generic)) else sys.modules["cupy"]


def device_of(bvh) -> AbstractContextManager[Any]:
    """Inside, new arrays lie where the tree is."""
    if not isinstance(bvh, DeviceBvh):
        return nullcontext()
    return import_cupy().cuda.Device(int(bvh.device.partition(":")[2]))


def to_host(values: Array) -> np.ndarray:
    """The same values as numpy's; waits for the device where they lie on one."""
    return values if isinstance(values, np.ndarray) else values.get()


def ratio(over: Array, under: Array, otherwise: float = 0.0) -> Array:
    """over / under where `under` is above 0, else `otherwise`. cupy's divide takes no `where`."""
    xp = module_of(over)
    is_above = under > 0.0
    quotient = over / xp.where(is_above, under, under.dtype.type(1.0))
    return xp.where(is_above, quotient, quotient.dtype.type(otherwise))


def dot(left: Array, right: Array) -> Array:
    """Dot products of (..., 3) and (..., 3) or (3,)."""
    if module_of(left) is not np:
        return _dot_on_device(left, right)
    return left @ right if right.ndim < left.ndim else np.einsum("...i,...i->...", left, right)


def import_cupy() -> ModuleType:
    """cupy, or an ImportError that says what to install."""
    try:
        import cupy
    except ImportError as missing:
        raise ImportError(
            "rendering on a CUDA device needs cupy: pip install 'cupy-cuda13x[ctk]', or cupy-cuda12x where "
            "the driver is older than 580"
        ) from missing
    return cupy


def _dot_on_device(left: Array, right: Array) -> Array:
    # To cupy, einsum and @ are a matrix product of one row and one column for each dot product.
    products = left * right
    return products[..., 0] + products[..., 1] + products[..., 2]
