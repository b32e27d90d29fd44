"""torchbvh: `RayBVH`, a binary tree of Morton codes over torch tensors; closest hits alone.

Its first call compiles it, for which nvcc must be there.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from treelet.render.rays import Rays

NAME = "torchbvh"
VARIANTS = ("lbvh",)


def load() -> TorchBvh:
    """Raises ImportError without torch and torchbvh, OSError where torch finds no CUDA device."""
    import torch
    import torchbvh

    if not torch.cuda.is_available():
        raise OSError("torch finds no CUDA device")
    return TorchBvh(torch, torchbvh)


class TorchBvh:
    """See `Peer`."""

    def __init__(self, torch: Any, torchbvh: Any) -> None:
        self._torch, self._module = torch, torchbvh
        self.version = f"torchbvh {getattr(torchbvh, '__version__', '')}".strip()

    def synchronize(self) -> None:
        """Wait for the device."""
        self._torch.cuda.synchronize()

    def upload(self, vertices: np.ndarray, faces: np.ndarray) -> Callable[[str], Any]:
        """It takes triangles as (F, 3, 3)."""
        triangles = self._to_device(vertices[faces])
        return lambda variant: self._module.RayBVH(triangles, primitive_type="triangle")

    def prepare(self, tree: Any, rays: Rays) -> _Tracer:
        """Copy rays. Raises NotImplementedError for any-hit rays."""
        if rays.any_hit:
            raise NotImplementedError("it has no any-hit query")
        return _Tracer(tree, self._to_device(rays.origins), self._to_device(rays.directions), rays.t_max)

    def _to_device(self, values: np.ndarray) -> Any:
        return self._torch.from_numpy(np.ascontiguousarray(values, np.float32)).cuda()


class _Tracer:
    def __init__(self, tree: Any, origins: Any, directions: Any, t_max: float) -> None:
        self._tree, self._arguments, self._t_max = tree, (origins, directions), t_max
        self._hits: Any = None

    def __call__(self) -> None:
        self._hits = self._tree.trace(*self._arguments, t_min=0.0, t_max=self._t_max)

    def answers(self) -> Any:
        return self._hits.t.cpu().numpy(), self._hits.primitive_indices.cpu().numpy()
