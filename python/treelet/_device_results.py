"""Makes arrays in device memory, of the library that the input came from where that can be."""

from __future__ import annotations

import math
import sys
from contextlib import AbstractContextManager, nullcontext
from typing import Any, NoReturn

import numpy as np

from . import _core
from ._device import LEGACY_STREAM, DeviceArray, stream_address

_DLPACK_CUDA = 2  # the kind of device
_DLPACK_DTYPES = ("float32", "int32", "uint32", "bool")
_DTYPES = ("float32", "float64", "int32", "uint32", "int64", "uint64", "bool")


class Array:
    """An array in device memory for libraries that treelet does not know: they can all read it.

    It has `__cuda_array_interface__` and `__dlpack__`; `numpy()` copies it to the host.
    """

    shape: tuple[int, ...]
    """Lengths, slowest first; () for a single value."""
    dtype: np.dtype[Any]
    """numpy's type of its elements."""

    def __init__(
        self, memory: _core.DeviceMemory, shape: tuple[int, ...], dtype: str, stream: int, device: int
    ) -> None:
        """Not for users: call `copy_to_device`, or a query."""
        self._memory, self._stream, self._device = memory, stream, device
        self.shape, self.dtype = shape, np.dtype(dtype)

    @property
    def __cuda_array_interface__(self) -> dict[str, Any]:
        return {
            "shape": self.shape,
            "typestr": self.dtype.str,
            "data": (self._memory.address, False),
            "strides": None,
            "stream": self._stream or LEGACY_STREAM,
            "version": 3,
        }

    def __dlpack__(
        self,
        *,
        stream: int | None = None,
        max_version: tuple[int, int] | None = None,
        dl_device: tuple[int, int] | None = None,
        copy: bool | None = None,
    ) -> Any:
        """A capsule for `from_dlpack`; waits until the array is written, unless stream is -1."""
        if self.dtype.name not in _DLPACK_DTYPES:
            raise TypeError(f"an array of {self.dtype} has no __dlpack__ here: copy it with .numpy()")
        if copy or dl_device not in (None, self.__dlpack_device__()):
            raise BufferError("the array is neither copied nor moved: copy it with .numpy()")
        if stream != -1:
            _core.device_synchronize(self._stream, self._device)
        return _core.as_dlpack(self._memory, self.dtype.name, list(self.shape), self._device)

    def __dlpack_device__(self) -> tuple[int, int]:
        return _DLPACK_CUDA, self._device

    def numpy(self) -> np.ndarray[Any, np.dtype[Any]]:
        """A copy in host memory; waits for the stream that writes the array."""
        return np.frombuffer(self._memory.copy_to_host(self._stream), self.dtype).reshape(self.shape)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NoReturn:
        raise TypeError("the array lies on a CUDA device: copy it with .numpy()")

    def __len__(self) -> int:
        if not self.shape:
            raise TypeError("a single value has no length")
        return self.shape[0]

    def __repr__(self) -> str:
        return f"<treelet.cuda.Array of {self.dtype} {self.shape} on device {self._device}>"


def copy_to_device(values: Any, dtype: str | None = None, *, stream: Any = None) -> Array:
    """Copy a host array to the current CUDA device, for who has no array library that does; waits.

    Args:
        values: what numpy makes an array of.
        dtype: "float32", "float64", "int32", "uint32", "int64", "uint64" or "bool"; by default the
            array's own.
        stream: as for queries; by default the default stream.

    Raises:
        TypeError: for any other dtype.
        RuntimeError: where there is no CUDA or no memory.
    """
    array = np.asarray(values, dtype, order="C")
    if array.dtype not in map(np.dtype, _DTYPES):
        raise TypeError(f"values must be of {', '.join(_DTYPES)}, not {array.dtype}")
    address, device = stream_address(stream), _core.device_current()
    memory = _core.DeviceMemory(array.nbytes, device, address)
    memory.copy_from_host(array.tobytes(), address)
    return Array(memory, array.shape, array.dtype.name, address, device)


class Output:
    """Device memory that a call writes to, and then hands out as an array."""

    def __init__(self, address: int, array: Any, library: str = "") -> None:
        self.address = address
        self._array, self._library = array, library

    def finish(self) -> Any:
        """The array, once the work that writes it is enqueued."""
        if self._library == "jax":
            return sys.modules["jax"].dlpack.from_dlpack(self._array)
        return self._array


def empty_like(like: DeviceArray, shape: tuple[int, ...], dtype: str, device: int, stream: int) -> Output:
    """Uninitialised memory of a device, for work in a stream, as an array of the library of `like`."""
    if like.library == "torch":
        torch = sys.modules["torch"]
        with _use_in_torch(torch.cuda, device, stream):
            tensor = torch.empty(shape, dtype=getattr(torch, dtype), device=f"cuda:{device}")
        return Output(tensor.data_ptr(), tensor)
    if like.library == "cupy":
        cupy = sys.modules["cupy"]
        with cupy.cuda.Device(device), _use_in_cupy(cupy.cuda, stream):
            array = cupy.empty(shape, dtype)
        return Output(array.data.ptr, array)
    memory = _core.DeviceMemory(math.prod(shape) * np.dtype(dtype).itemsize, device, stream)
    return Output(memory.address, Array(memory, shape, dtype, stream, device), like.library)


def _use_in_torch(cuda: Any, device: int, stream: int) -> AbstractContextManager[Any]:
    """Both libraries keep freed memory by the stream that it was allocated in."""
    if stream_address(cuda.current_stream(device)) == stream:
        return nullcontext()
    return cuda.stream(cuda.ExternalStream(stream, device=device))


def _use_in_cupy(cuda: Any, stream: int) -> AbstractContextManager[Any]:
    if stream_address(cuda.get_current_stream()) == stream:
        return nullcontext()
    return cuda.ExternalStream(stream)
