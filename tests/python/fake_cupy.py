"""As much of cupy as the renderer calls, over numpy and the memory of the emulated device.

The arithmetic is numpy's, so that pictures can be compared bit for bit. What cupy refuses is refused: arrays
of numpy as arguments, and turning into one unless by `get`. Even numpy's own functions, which cupy serves,
are. KEYWORDS lists all functions with the keywords that they take here; cupy must have them.

Counts what costs on a device: waits, bytes brought back to the host, bytes of memory in use.
"""

from __future__ import annotations

import contextlib
import ctypes
import operator
from types import SimpleNamespace

import numpy as np

from treelet import _core

KEYWORDS: dict[str, tuple[str, ...]] = {
    "abs": (),
    "arange": (),
    "array": ("dtype",),
    "asarray": ("dtype",),
    "ascontiguousarray": ("dtype",),
    "broadcast_to": (),
    "clip": ("out",),
    "concatenate": (),
    "copysign": (),
    "cos": (),
    "cross": (),
    "divmod": (),
    "empty": ("dtype",),
    "exp": (),
    "flatnonzero": (),
    "full_like": (),
    "interp": (),
    "linspace": (),
    "log": (),
    "maximum": ("out",),
    "minimum": ("out",),
    "moveaxis": (),
    "ones": ("dtype",),
    "pad": ("mode",),
    "percentile": (),
    "repeat": ("axis",),
    "sin": (),
    "sqrt": (),
    "stack": ("axis",),
    "tile": (),
    "where": (),
    "zeros": ("dtype",),
    "zeros_like": (),
}
METHODS = ("astype", "get", "max", "mean", "reshape", "sum")
_UPLOADS = ("array", "asarray")
_WAITING = ("flatnonzero",)

counts = SimpleNamespace(waits=0, bytes_to_host=0, bytes_in_use=0, peak_bytes=0)
cuda = SimpleNamespace(
    Device=lambda index: contextlib.nullcontext(),
    get_current_stream=lambda: SimpleNamespace(ptr=0),
)


class _Memory:
    """A block of device memory, which numpy can reach since the device is emulated."""

    def __init__(self, size: int) -> None:
        self._block, self.size = _core.DeviceMemory(size, 0, 0), size
        self.buffer = (ctypes.c_char * size).from_address(self._block.address)
        counts.bytes_in_use += size
        counts.peak_bytes = max(counts.peak_bytes, counts.bytes_in_use)

    def __del__(self) -> None:
        counts.bytes_in_use -= self.size


class ndarray:  # noqa: N801
    """An array in emulated device memory, and numpy's view of it."""

    __array_ufunc__ = None
    device = contextlib.nullcontext()

    def __init__(self, values: np.ndarray, memory: _Memory | None) -> None:
        self._view, self._memory = values, memory
        self.data = SimpleNamespace(ptr=values.ctypes.data)

    @property
    def _values(self) -> np.ndarray:
        """What the device has written once all is done that was enqueued: numpy knows no streams."""
        _core.device_synchronize(0)
        return self._view

    def __array__(self, dtype=None, copy=None):
        raise TypeError("Implicit conversion to a NumPy array is not allowed.")

    @property
    def __cuda_array_interface__(self) -> dict:
        values = self._view
        is_contiguous = values.flags.c_contiguous
        return {
            "shape": values.shape,
            "typestr": values.dtype.str,
            "data": (self.data.ptr, False),
            "strides": None if is_contiguous else values.strides,
            "stream": 1,
            "version": 3,
        }

    shape = property(lambda self: self._view.shape)
    dtype = property(lambda self: self._view.dtype)
    ndim = property(lambda self: self._view.ndim)

    def __len__(self) -> int:
        return len(self._view)

    def __iter__(self):
        return (self[index] for index in range(len(self)))

    def __getitem__(self, key) -> ndarray:
        _wait_for_masks(key)
        return _wrap(self._values[_unwrap(key)], self)

    def __setitem__(self, key, value) -> None:
        _wait_for_masks(key)
        self._values[_unwrap(key)] = _unwrap(value)

    def __float__(self) -> float:
        return float(self.get())

    def __bool__(self) -> bool:
        return bool(self.get())

    def get(self) -> np.ndarray:
        counts.waits += 1
        counts.bytes_to_host += self._values.nbytes
        return self._values.copy()

    def __neg__(self) -> ndarray:
        return _wrap(-self._values)

    def __invert__(self) -> ndarray:
        return _wrap(~self._values)

    def reshape(self, *shape: int) -> ndarray:
        return _wrap(self._values.reshape(*shape), self)

    def astype(self, dtype) -> ndarray:
        return _wrap(self._values.astype(dtype))

    def sum(self, axis=None) -> ndarray:
        return _wrap(self._values.sum(axis=axis))

    def mean(self, axis=None, dtype=None) -> ndarray:
        return _wrap(self._values.mean(axis=axis, dtype=dtype))

    def max(self, axis=None) -> ndarray:
        return _wrap(self._values.max(axis=axis))


ndarray.__module__ = "cupy"


def _unwrap(argument):
    if isinstance(argument, ndarray):
        return argument._values
    if isinstance(argument, (tuple, list)):
        return type(argument)(map(_unwrap, argument))
    if isinstance(argument, np.ndarray):
        raise TypeError("Unsupported type <class 'numpy.ndarray'>")
    return argument


def run(function, *arguments):
    """Call one of numpy's functions with arrays of the device, for what KEYWORDS does not list."""
    return _wrap(function(*_unwrap(arguments)))


def _wrap(result, *sources):
    """As an array of the device: a view where the result is one of a source, else in memory of its own."""
    if isinstance(result, tuple):
        return tuple(_wrap(part, *sources) for part in result)
    result = np.asarray(result)
    for source in sources:
        if isinstance(source, ndarray) and np.may_share_memory(result, source._view):
            return ndarray(result, source._memory)
    return _copy(result)


def _copy(values: np.ndarray) -> ndarray:
    if values.size == 0:
        return ndarray(np.empty_like(values), None)
    memory = _Memory(values.nbytes)
    strides = np.empty_like(values, order="K").strides
    place = np.ndarray(values.shape, values.dtype, memory.buffer, strides=strides)
    place[...] = values
    return ndarray(place, memory)


def _wait_for_masks(key) -> None:
    for part in key if isinstance(key, tuple) else (key,):
        counts.waits += isinstance(part, ndarray) and part.dtype == bool


def _function(name: str):
    def call(*arguments, **options):
        unknown = set(options) - set(KEYWORDS[name])
        if unknown:
            raise TypeError(f"cupy.{name} is called with {', '.join(unknown)}, which KEYWORDS does not list")
        counts.waits += name in _WAITING
        is_upload = name in _UPLOADS and isinstance(arguments[0], np.ndarray)
        values = arguments if is_upload else _unwrap(arguments)
        given = {key: _unwrap(option) for key, option in options.items()}
        return _wrap(getattr(np, name)(*values, **given), *arguments, options.get("out"))

    return call


def _operator(name: str):
    function = getattr(operator, name)

    def forward(self, other):
        return _wrap(function(self._values, _unwrap(other)))

    def backward(self, other):
        return _wrap(function(_unwrap(other), self._values))

    def in_place(self, other):
        function = getattr(operator, f"i{name}")
        function(self._values, _unwrap(other))
        return self

    return forward, backward, in_place


for _name in KEYWORDS:
    globals()[_name] = _function(_name)
for _name in (
    "add",
    "sub",
    "mul",
    "truediv",
    "pow",
    "lt",
    "le",
    "gt",
    "ge",
    "lshift",
    "rshift",
    "and_",
    "or_",
    "xor",
):
    _bare = _name.rstrip("_")
    for _prefix, _method in zip(("", "r", "i"), _operator(_name), strict=True):
        setattr(ndarray, f"__{_prefix}{_bare}__", _method)
