"""What there is of CUDA here.

from treelet import cuda

if not cuda.is_available():
    print(cuda.why_unavailable())
"""

from __future__ import annotations

from typing import Any, NamedTuple

from . import _core
from ._device import stream_address
from ._device_results import Array, copy_to_device

__all__ = [
    "Array",
    "Device",
    "copy_to_device",
    "devices",
    "is_available",
    "is_compiled_in",
    "release_memory",
    "synchronize",
    "why_unavailable",
]


class Device(NamedTuple):
    """A GPU that this process sees."""

    name: str
    compute_capability: tuple[int, int]
    memory_bytes: int
    multiprocessors: int


def is_compiled_in() -> bool:
    """Whether this installation holds CUDA code at all, GPU or not."""
    return _core.cuda_is_compiled_in()


def is_available() -> bool:
    """Whether there is a GPU here that treelet can use; never raises. The first call starts the driver."""
    return _core.cuda_is_available()


def why_unavailable() -> str:
    """One sentence that says what is missing and what to do; empty where CUDA is available."""
    return _core.cuda_why_unavailable()


def devices() -> list[Device]:
    """All GPUs that the process sees, in CUDA's order; none where CUDA is not available."""
    return [Device(*facts) for facts in _core.cuda_devices()]


def synchronize(stream: Any = None) -> None:
    """Wait for all work on a stream, by default the default one.

    Args:
        stream: an address, a stream of torch or cupy, or anything with `__cuda_stream__`.

    Raises:
        TypeError: where it is none of these.
        RuntimeError: where there is no CUDA, or a kernel failed.
    """
    _core.device_synchronize(stream_address(stream))


def release_memory() -> None:
    """Give back to the device what earlier builds freed: treelet keeps it for the next one otherwise.

    Raises:
        RuntimeError: where there is no CUDA.
    """
    _core.device_release_memory()
