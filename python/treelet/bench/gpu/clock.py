"""Time on a CUDA device: the driver's events, or the host's clock where there is no driver to ask.

The driver is called by name, so no array library is needed; streams and memory are the same to it as to
CUDA's runtime, which treelet uses.
"""

from __future__ import annotations

import ctypes
import time
from collections.abc import Callable
from typing import Any, Protocol

from treelet import _core, cuda

Call = Callable[[], object]  # enqueues work on the default stream
_COPY_BYTES = 1 << 30


class Clock(Protocol):
    """Measures how long the device works on what a call enqueues."""

    name: str

    def time(self, call: Call) -> float:
        """Seconds of one call."""
        ...


class HostClock:
    """From before the call until the device has done its work: the call's own overhead counts too."""

    name = "host"

    def time(self, call: Call) -> float:
        """Seconds of one call."""
        cuda.synchronize()
        start = time.perf_counter()
        call()
        cuda.synchronize()
        return time.perf_counter() - start


class Driver:
    """The few functions of CUDA's driver that measuring needs. Raises OSError where there is none."""

    def __init__(self, library: Any = None) -> None:
        self._library = library or ctypes.CDLL("libcuda.so.1")

    def make_event(self) -> ctypes.c_void_p:
        """An event with a time."""
        event = ctypes.c_void_p()
        self._check("cuEventCreate", ctypes.byref(event), ctypes.c_uint(0))
        return event

    def record(self, event: ctypes.c_void_p) -> None:
        """Enqueue an event on the default stream."""
        self._check("cuEventRecord", event, ctypes.c_void_p(0))

    def seconds_between(self, start: ctypes.c_void_p, stop: ctypes.c_void_p) -> float:
        """Wait for the second event."""
        milliseconds = ctypes.c_float()
        self._check("cuEventSynchronize", stop)
        self._check("cuEventElapsedTime", ctypes.byref(milliseconds), start, stop)
        return milliseconds.value / 1e3

    def copy(self, to: int, source: int, count: int) -> None:
        """Enqueue a copy of bytes within the device on the default stream."""
        addresses = ctypes.c_uint64(to), ctypes.c_uint64(source)
        self._check("cuMemcpyDtoDAsync_v2", *addresses, ctypes.c_size_t(count), ctypes.c_void_p(0))

    def _check(self, function: str, *arguments: Any) -> None:
        error = getattr(self._library, function)(*arguments)
        if error != 0:
            raise OSError(f"{function} failed with CUDA error {error}")


class EventClock:
    """Between two events on the device.

    One call goes ahead of the first event: while the device works on it, the host enqueues the event and the
    call that is measured, so that no gap of the host's making lies between the events.
    """

    name = "events"

    def __init__(self, driver: Driver) -> None:
        self._driver = driver
        self._start, self._stop = driver.make_event(), driver.make_event()

    def time(self, call: Call) -> float:
        """Seconds of one call."""
        cuda.synchronize()
        ahead = call()
        self._driver.record(self._start)
        measured = call()
        self._driver.record(self._stop)
        seconds = self._driver.seconds_between(self._start, self._stop)
        del ahead, measured  # what they return must not be freed between the events
        return seconds


def find_driver(library: Any = None) -> Driver | None:
    """The driver, if it answers."""
    cuda.synchronize()  # makes the context of CUDA's runtime this thread's own: events need one
    try:
        driver = Driver(library)
        driver.make_event()
    except (OSError, AttributeError):  # no library, an error, or a function that it lacks
        return None
    return driver


def make_clock(driver: Driver | None) -> Clock:
    """Events where there is a driver."""
    return EventClock(driver) if driver else HostClock()


def time_copies(driver: Driver, repeats: int, count: int = _COPY_BYTES) -> tuple[list[float], int]:
    """Seconds of copies within device memory, and the bytes that each moves: read and written ones."""
    device = _core.device_current()
    memory = [_core.DeviceMemory(count, device, 0) for _ in range(2)]
    clock = EventClock(driver)

    def copy() -> None:
        driver.copy(memory[0].address, memory[1].address, count)

    copy()
    return [clock.time(copy) for _ in range(repeats)], 2 * count
