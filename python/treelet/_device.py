"""Reads what arrays in device memory say of themselves, and makes answers in the same library.

torch, cupy, jax, numba, warp and others give `__cuda_array_interface__`: an address, a shape, a type and
strides. That is all treelet needs, and none of these libraries is imported unless an array of it came in.
"""

from __future__ import annotations

import math
import sys
from typing import Any, NamedTuple

import numpy as np

from . import _core

_LEGACY_STREAM = 1  # of __cuda_array_interface__: the default stream, 0 to CUDA
_DLPACK_CUDA = 2  # the kind of device


class DeviceArray(NamedTuple):
    """A C-contiguous array in device memory. Keeps its owner alive."""

    address: int
    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    owner: Any

    @property
    def library(self) -> str:
        """The package that the owner's type comes from, as "torch"."""
        return type(self.owner).__module__.partition(".")[0]


def is_on_device(array: object) -> bool:
    """Whether an array lies in the memory of a CUDA device."""
    return hasattr(array, "__cuda_array_interface__")


def as_device_array(array: Any, name: str) -> DeviceArray:
    """Read where an array lies. Host arrays and strided ones are refused with what to do instead."""
    if not is_on_device(array):
        raise TypeError(
            f"{name} must lie on a CUDA device as the other arrays do, not be a {type(array).__name__} on "
            "the host: move it there, or move the tree with bvh.to('cpu')"
        )
    _wait_for_jax(array)
    interface = array.__cuda_array_interface__
    shape = tuple(int(length) for length in interface["shape"])
    dtype = np.dtype(interface["typestr"])
    if not _is_contiguous(interface.get("strides"), shape, dtype.itemsize):
        raise ValueError(f"{name} must be C-contiguous on the device: call .contiguous() or .copy() first")
    return DeviceArray(int(interface["data"][0]), shape, dtype, array)


def stream_address(stream: Any, like: DeviceArray | None = None) -> int:
    """The address of a stream: an int, or an object of torch, cupy or any that has `__cuda_stream__`.

    None is the current stream of the array's library, and the default stream where there is no such thing.
    """
    if stream is None:
        return 0 if like is None else _current_stream(like)
    if isinstance(stream, int):
        return 0 if stream == _LEGACY_STREAM else stream
    if hasattr(stream, "__cuda_stream__"):
        return int(stream.__cuda_stream__()[1])
    for attribute in ("cuda_stream", "ptr"):  # torch, cupy
        if hasattr(stream, attribute):
            return int(getattr(stream, attribute))
    raise TypeError(f"stream must be an address or a stream object, not {type(stream).__name__}")


def empty_like(like: DeviceArray, shape: tuple[int, ...], dtype: str, stream: int) -> Output:
    """Uninitialised device memory that will be an array of the library of `like`."""
    if like.library == "torch":
        torch = sys.modules["torch"]
        tensor = torch.empty(shape, dtype=getattr(torch, dtype), device=like.owner.device)
        return Output(tensor.data_ptr(), tensor, shape, dtype, stream)
    if like.library == "cupy":
        array = sys.modules["cupy"].empty(shape, dtype)
        return Output(array.data.ptr, array, shape, dtype, stream)
    memory = _core.DeviceMemory(math.prod(shape) * np.dtype(dtype).itemsize, stream)
    return Output(memory.address, memory, shape, dtype, stream, like.library)


class Output:
    """Device memory that a call writes to, and then hands out as an array."""

    def __init__(
        self, address: int, owner: Any, shape: tuple[int, ...], dtype: str, stream: int, library: str = ""
    ) -> None:
        self.address = address
        self._owner, self._shape, self._dtype = owner, shape, dtype
        self._stream, self._library = stream, library

    def finish(self, device: int) -> Any:
        """The array, of the library that the input came from where that can be."""
        if not isinstance(self._owner, _core.DeviceMemory):
            return self._owner
        array = Array(self._owner, self._shape, self._dtype, self._stream, device)
        if self._library in ("jax", "jaxlib"):
            _core.device_synchronize(self._stream)  # jax takes no stream
            return sys.modules["jax"].dlpack.from_dlpack(array)
        return array


class Array:
    """An array in device memory for libraries that treelet does not know: they can all read it.

    It has `__cuda_array_interface__` and `__dlpack__`; `numpy()` copies it to the host.
    """

    def __init__(
        self, memory: _core.DeviceMemory, shape: tuple[int, ...], dtype: str, stream: int, device: int
    ) -> None:
        self._memory, self._stream, self._device = memory, stream, device
        self.shape, self.dtype = shape, np.dtype(dtype)

    @property
    def __cuda_array_interface__(self) -> dict[str, Any]:
        return {
            "shape": self.shape,
            "typestr": self.dtype.str,
            "data": (self._memory.address, False),
            "strides": None,
            "stream": self._stream or _LEGACY_STREAM,
            "version": 3,
        }

    def __dlpack__(self, **_: Any) -> Any:
        return _core.as_dlpack(self._memory, self.dtype.name, list(self.shape), self._device)

    def __dlpack_device__(self) -> tuple[int, int]:
        return _DLPACK_CUDA, self._device

    def numpy(self) -> np.ndarray[Any, np.dtype[Any]]:
        """A copy in host memory; waits for the stream that writes the array."""
        return np.frombuffer(self._memory.copy_to_host(self._stream), self.dtype).reshape(self.shape)

    def __len__(self) -> int:
        return self.shape[0]

    def __repr__(self) -> str:
        return f"<treelet.cuda.Array of {self.dtype} {self.shape} on device {self._device}>"


def copy_to_device(values: Any, dtype: str | None = None, *, stream: int = 0) -> Array:
    """Copy a host array to the current CUDA device, for who has no array library that does; waits.

    Args:
        values: what numpy makes an array of.
        dtype: "float32", "int32" or "uint32"; by default the array's own.
        stream: the address of a stream.

    Raises:
        RuntimeError: where there is no CUDA or no memory.
    """
    array = np.ascontiguousarray(values, dtype)
    memory = _core.DeviceMemory(array.nbytes, stream)
    memory.copy_from_host(array.tobytes(), stream)
    return Array(memory, array.shape, array.dtype.name, stream, _core.device_current())


def _is_contiguous(strides: Any, shape: tuple[int, ...], item: int) -> bool:
    if strides is None or 0 in shape:
        return True
    expected = item
    for length, stride in zip(reversed(shape), reversed(strides), strict=True):
        if length > 1 and stride != expected:
            return False
        expected *= length
    return True


def _wait_for_jax(array: Any) -> None:
    """jax computes in streams of its own that it tells nobody."""
    if hasattr(array, "block_until_ready"):
        array.block_until_ready()


def _current_stream(like: DeviceArray) -> int:
    if like.library == "torch":
        return int(sys.modules["torch"].cuda.current_stream(like.owner.device).cuda_stream)
    if like.library == "cupy":
        return int(sys.modules["cupy"].cuda.get_current_stream().ptr)
    stream = like.owner.__cuda_array_interface__.get("stream")
    return 0 if stream in (None, _LEGACY_STREAM) else int(stream)
