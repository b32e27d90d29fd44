"""Arrays of the caller for answers: `out=` of the queries."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

Rows = np.ndarray[Any, np.dtype[Any]]


class Output(NamedTuple):
    """What an array of answers must be: its name in errors, its shape and what it holds."""

    name: str
    shape: tuple[int, ...]
    dtype: type[np.generic]


def as_output(out: Any, wanted: Output) -> Rows | None:
    """The array's own memory as one row, None for None."""
    if out is None:
        return None
    array = _as_array(out, wanted.name)
    if array.dtype != wanted.dtype:
        raise TypeError(f"{wanted.name} must hold {np.dtype(wanted.dtype)}, not {array.dtype}")
    if array.shape != wanted.shape:
        raise ValueError(f"{wanted.name} must have shape {wanted.shape}, not {array.shape}")
    flags = array.flags
    if not (flags.c_contiguous and flags.aligned and flags.writeable):
        fault = "contiguous in C order" if not flags.c_contiguous else "aligned and writeable"
        raise ValueError(f"{wanted.name} must be {fault}: np.empty makes such arrays")
    return array.reshape(-1)


def as_outputs(out: Sequence[Any] | None, wanted: Sequence[Output]) -> list[Rows | None] | None:
    """As well, for answers of several arrays."""
    if out is None:
        return None
    names = ", ".join(part.name.removeprefix("out.") for part in wanted)
    if not isinstance(out, tuple | list) or len(out) != len(wanted):
        raise TypeError(f"out must be {len(wanted)} arrays ({names}), such as an earlier answer")
    if any(part is None for part in out):
        raise TypeError(f"out must be {len(wanted)} arrays ({names}), and one of them is None")
    return [as_output(part, own) for part, own in zip(out, wanted, strict=True)]


def _as_array(out: Any, name: str) -> Rows:
    if isinstance(out, np.ndarray):
        return out
    if hasattr(out, "data_ptr") and hasattr(out, "numpy"):  # a tensor of torch, whose memory this shares
        try:
            array: Rows = out.numpy()
        except (TypeError, RuntimeError) as error:
            raise TypeError(f"{name} must lie on the host and need no gradient: {error}") from None
        return array
    raise TypeError(f"{name} must be a numpy array or a tensor of torch on the CPU, not {type(out).__name__}")
