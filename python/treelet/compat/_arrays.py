"""What the users of other libraries pass, as numpy arrays."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def as_array(values: Any) -> NDArray[Any]:
    """Of a tensor its values, else what numpy makes of it."""
    return np.asarray(values.numpy() if hasattr(values, "numpy") else values)
