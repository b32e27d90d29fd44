"""Makes arrays in device memory, of the library that the input came from where that can be."""

from __future__ import annotations

import math
import sys
from contextlib import AbstractContextManager, nullcontext
from typing import Any, NoReturn

import numpy as np

from . import _core
from ._device import LEGACY_STREAM, DeviceArray, WorkStream, stream_address

_DLPACK_CUDA = 2  # the kind of device
_DLPACK_DTYPES = ("float32", "int32", "int64", "uint32", "bool")
_DTYPES = {
    name: np.dtype(name) for name in ("float32", "float64", "int32", "uint32", "int64", "uint64", "bool")
}
_ALIGNMENT = 256  # as of an allocation of its own


class Array:
    """An array in device memory for libraries that treelet does not know: they can all read it.

    It has `__cuda_array_interface__` and `__dlpack__`; `numpy()` copies it to the host.
    """

    shape: tuple[int, ...]
    """Lengths, slowest first; () for a single value."""
    dtype: np.dtype[Any]
    """numpy's type of its elements."""

    def __init__(
        self,
        memory: _core.DeviceMemory,
        offset: int,
        shape: tuple[int, ...],
        dtype: np.dtype[Any],
        stream: int,
        device: int,
    ) -> None:
        """Not for users: call `copy_to_device`, or a query. `memory` may hold other arrays, too."""
        self._memory, self._offset, self._stream, self._device = memory, offset, stream, device
        self.shape, self.dtype = shape, dtype

    @property
    def __cuda_array_interface__(self) -> dict[str, Any]:
        return {
            "shape": self.shape,
            "typestr": self.dtype.str,
            "data": (self._memory.address + self._offset, False),
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
        address = self._memory.address + self._offset
        return _core.as_dlpack(self._memory, address, self.dtype.name, list(self.shape), self._device)

    def __dlpack_device__(self) -> tuple[int, int]:
        return _DLPACK_CUDA, self._device

    def numpy(self) -> np.ndarray[Any, np.dtype[Any]]:
        """A copy in host memory; waits for the stream that writes the array."""
        size = math.prod(self.shape) * self.dtype.itemsize
        return (
            self._memory.copy_to_host(self._offset, size, self._stream).view(self.dtype).reshape(self.shape)
        )

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
    if array.dtype not in _DTYPES.values():
        raise TypeError(f"values must be of {', '.join(_DTYPES)}, not {array.dtype}")
    address, device = stream_address(stream), _core.device_current()
    memory = _core.DeviceMemory(array.nbytes, device, address)
    memory.copy_from_host(array.tobytes(), address)
    return Array(memory, 0, array.shape, array.dtype, address, device)


class Outputs:
    """Device memory that a call writes to, and then hands out as arrays."""

    def __init__(self, addresses: list[int], arrays: list[Any], library: str = "") -> None:
        self.addresses = addresses
        self._arrays, self._library = arrays, library

    def finish(self) -> list[Any]:
        """The arrays, once the work that writes them is enqueued."""
        if self._library == "jax":
            return [sys.modules["jax"].dlpack.from_dlpack(array) for array in self._arrays]
        return self._arrays


def make_outputs(
    like: DeviceArray, shape: tuple[int, ...], dtypes: tuple[str, ...], device: int, stream: WorkStream
) -> Outputs:
    """Uninitialised memory of a device, for work in a stream, as arrays of the library of `like`."""
    if like.library == "torch":
        torch = sys.modules["torch"]
        with _use_in_torch(torch.cuda, device, stream):
            tensors = [
                torch.empty(shape, dtype=getattr(torch, dtype), device=like.owner.device) for dtype in dtypes
            ]
        return Outputs([tensor.data_ptr() for tensor in tensors], tensors)
    if like.library == "cupy":
        cupy = sys.modules["cupy"]
        with cupy.cuda.Device(device), _use_in_cupy(cupy.cuda, stream):
            arrays = [cupy.empty(shape, dtype) for dtype in dtypes]
        return Outputs([array.data.ptr for array in arrays], arrays)
    return _make_own_outputs(shape, dtypes, device, stream.address, like.library)


def _make_own_outputs(
    shape: tuple[int, ...], dtypes: tuple[str, ...], device: int, stream: int, library: str
) -> Outputs:
    """One block for all: each that is given back makes the device wait."""
    count, offsets, end = math.prod(shape), [], 0
    for dtype in dtypes:
        offsets.append(end)
        end += -(-count * _DTYPES[dtype].itemsize // _ALIGNMENT) * _ALIGNMENT
    memory = _core.DeviceMemory(end, device, stream)
    arrays = [
        Array(memory, offset, shape, _DTYPES[dtype], stream, device)
        for offset, dtype in zip(offsets, dtypes, strict=True)
    ]
    first = memory.address
    return Outputs([first + offset for offset in offsets], arrays, library)


def _use_in_torch(cuda: Any, device: int, stream: WorkStream) -> AbstractContextManager[Any]:
    """Both libraries keep freed memory by the stream that it was allocated in."""
    if stream.library == "torch" or stream_address(cuda.current_stream(device)) == stream.address:
        return nullcontext()
    return cuda.stream(cuda.ExternalStream(stream.address, device=device))


def _use_in_cupy(cuda: Any, stream: WorkStream) -> AbstractContextManager[Any]:
    if stream.library == "cupy" or stream_address(cuda.get_current_stream()) == stream.address:
        return nullcontext()
    return cuda.ExternalStream(stream.address)
