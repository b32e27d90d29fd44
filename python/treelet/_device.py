"""Reads what arrays in device memory say of themselves, and orders what a stream does with them.

torch, cupy, jax, numba, warp and others give `__cuda_array_interface__`: an address, a shape, a type and
strides. That is all treelet needs. It imports none of these libraries: whoever passes an array of one has.
"""

from __future__ import annotations

import math
import operator
import re
import sys
from collections.abc import Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from . import _core

LEGACY_STREAM = 1  # of __cuda_array_interface__: the default stream, 0 to CUDA
_LIBRARIES = {"torch": "torch", "cupy": "cupy", "jax": "jax", "jaxlib": "jax"}  # by package of the type
_MAX_ROWS = 2**32 - 1
_ABSENT = object()


class DeviceArray(NamedTuple):
    """A C-contiguous array in device memory. Keeps its owner alive."""

    address: int
    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    stream: int | None
    """The stream that writes it, where it says so."""
    library: str
    """Which of the libraries that treelet answers in made it: "torch", "cupy", "jax" or ""."""
    owner: Any


class WorkStream(NamedTuple):
    """Where work is enqueued."""

    address: int
    library: str = ""
    """The library whose current stream it is; "" where nobody has asked."""


def is_on_device(array: object) -> bool:
    """Whether an array lies in the memory of a CUDA device."""
    return hasattr(array, "__cuda_array_interface__")


def shape_on_device(array: Any) -> tuple[int, ...]:
    """The shape of an array on a device, () where it does not say."""
    return tuple(getattr(array, "__cuda_array_interface__", {}).get("shape", ()))


def find_device_array(array: Any, name: str) -> DeviceArray | None:
    """Read where an array lies; None where that is the host. Strided arrays are refused with what to do."""
    interface = getattr(array, "__cuda_array_interface__", _ABSENT)
    if interface is _ABSENT:
        return None
    kind = _kind_of(type(array))
    if kind.is_lazy:
        array.block_until_ready()
    try:
        read, strides, mask = _read_interface(array, interface, kind)
        is_contiguous = strides is None or _is_contiguous(strides, read.shape, read.dtype.itemsize)
    except (AttributeError, IndexError, KeyError, SyntaxError, TypeError, ValueError) as error:
        reason = f"it has no {error}" if isinstance(error, KeyError) else error
        raise ValueError(f"{name}: its __cuda_array_interface__ is not valid: {reason}") from error
    if mask is not None:
        raise ValueError(f"{name} must not have a mask: fill in what it hides first")
    if not is_contiguous:
        raise ValueError(f"{name} must be C-contiguous on the device: call .contiguous() or .copy() first")
    alignment = read.dtype.alignment
    if read.address % alignment != 0 and 0 not in read.shape:
        raise ValueError(f"{name} must begin at a multiple of {alignment} bytes: copy it first")
    return read


def as_device_array(array: Any, name: str, advice: str) -> DeviceArray:
    """As `find_device_array`, but an array on the host is refused with what to do instead."""
    read = find_device_array(array, name)
    if read is None:
        raise TypeError(
            f"{name} must lie on a CUDA device as the rest does, not be a {type(array).__name__} on the "
            f"host: {advice}"
        )
    return read


def require_rows_of_3(array: DeviceArray, name: str, letter: str) -> None:
    """Refuse all but (N, 3), and more rows than 32 bits count."""
    if len(array.shape) != 2 or array.shape[1] != 3:
        raise ValueError(f"{name} must have shape ({letter}, 3), not {array.shape}")
    if array.shape[0] > _MAX_ROWS:
        raise ValueError(f"{name} has {array.shape[0]} rows, but at most {_MAX_ROWS} can be numbered")


def require_current_device(device: str) -> None:
    """Refuse all names but that of the current device, as "cuda:0"."""
    if not isinstance(device, str) or re.fullmatch(r"cuda:[0-9]+", device) is None:
        raise ValueError(f"device must be 'cpu' or 'cuda', not {device!r}")
    current = f"cuda:{_core.device_current()}"
    if device != current:
        raise ValueError(f"device must be the current one, {current!r}, not {device!r}: choose that first")


def stream_address(stream: Any, like: DeviceArray | None = None) -> int:
    """The address of a stream: an int, or an object of torch, cupy or any that has `__cuda_stream__`.

    None is the current stream of the array's library, and the default stream where there is no such thing.
    """
    if stream is None:
        return 0 if like is None else _current_stream(like)
    if hasattr(stream, "__cuda_stream__"):
        return _as_address(stream.__cuda_stream__()[1])
    for attribute in ("cuda_stream", "ptr"):  # torch, cupy
        if hasattr(stream, attribute):
            return _as_address(getattr(stream, attribute))
    return _as_address(stream)


def work_stream(stream: Any, like: DeviceArray) -> WorkStream:
    """As `stream_address`, but remembers whose current stream it is: to ask takes microseconds."""
    if stream is None:
        return WorkStream(_current_stream(like), like.library)
    return WorkStream(stream_address(stream))


def before_reading(arrays: Sequence[DeviceArray], stream: WorkStream) -> None:
    """What is enqueued from now on comes after what wrote the arrays, and before their memory is reused."""
    for array in arrays:
        if array.stream is not None and array.stream != stream.address:
            _core.device_synchronize(array.stream)
        if array.library == "torch" != stream.library and _current_stream(array) != stream.address:
            cuda = sys.modules["torch"].cuda
            array.owner.record_stream(cuda.ExternalStream(stream.address, device=array.owner.device))


def after_reading(arrays: Sequence[DeviceArray], stream: WorkStream) -> None:
    """Waits for what was enqueued where the arrays' library would not."""
    for array in arrays:
        if array.library == "jax":  # takes no stream, and frees in its own
            _core.device_synchronize(stream.address)
            return


class _Kind(NamedTuple):
    """What there is to know of a type of arrays."""

    libraries: tuple[str, ...]
    """Which may have made it, the likeliest first."""
    is_lazy: bool
    """Whether it is jax's, which computes in streams of its own that it tells nobody."""

    def library(self) -> str:
        for library in self.libraries:
            if library in sys.modules:
                return library
        return ""


@lru_cache(maxsize=64)
def _kind_of(array_type: type) -> _Kind:
    packages = [str(base.__module__).partition(".")[0] for base in array_type.__mro__]
    libraries = tuple(_LIBRARIES[package] for package in packages if package in _LIBRARIES)
    return _Kind(libraries, hasattr(array_type, "block_until_ready"))


_dtype_of = lru_cache(maxsize=64)(np.dtype)


def _read_interface(array: Any, interface: Any, kind: _Kind) -> tuple[DeviceArray, Any, Any]:
    """The array, its strides and its mask. Raises nearly anything where the interface is not valid."""
    shape = tuple(map(operator.index, interface["shape"]))
    if min(shape, default=0) < 0:
        raise ValueError(f"shape {shape} is negative")
    typestr, data, stream = interface["typestr"], interface["data"], interface.get("stream")
    if not isinstance(typestr, str):
        raise TypeError(f"typestr must be text, not {typestr!r}")
    address = operator.index((data[0] if data is not None else None) or 0)
    if address == 0 and 0 not in shape:
        raise ValueError(f"an array of {math.prod(shape)} elements has no address")
    written_in = None if stream is None else _as_address(stream)
    read = DeviceArray(address, shape, _dtype_of(typestr), written_in, kind.library(), array)
    return read, interface.get("strides"), interface.get("mask")


def _is_contiguous(strides: Any, shape: tuple[int, ...], item: int) -> bool:
    if 0 in shape:
        return True
    expected = item
    for length, stride in zip(reversed(shape), reversed(strides), strict=True):
        if length > 1 and stride != expected:
            return False
        expected *= length
    return True


def _as_address(stream: Any) -> int:
    if type(stream) is int and 0 <= stream < 2**63:  # nearly always
        return 0 if stream == LEGACY_STREAM else stream
    if isinstance(stream, bool) or not hasattr(stream, "__index__"):
        raise TypeError(f"stream must be an address or a stream object, not {type(stream).__name__}")
    address = operator.index(stream)
    if not 0 <= address < 2**64:
        raise ValueError(f"stream must be an address, not {address}")
    return 0 if address == LEGACY_STREAM else address


def _current_stream(like: DeviceArray) -> int:
    if like.library == "torch":
        return stream_address(sys.modules["torch"].cuda.current_stream(like.owner.device))
    if like.library == "cupy":
        with like.owner.device:
            return stream_address(sys.modules["cupy"].cuda.get_current_stream())
    return like.stream or 0
