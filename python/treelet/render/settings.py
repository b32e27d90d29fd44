"""What a picture is made with."""

from __future__ import annotations

import math
from dataclasses import dataclass

from treelet.scenes.catalog import check_seed


@dataclass(frozen=True)
class RenderSettings:
    """Size, effort and seed of a picture. Lengths are shares of the scene's diagonal."""

    width: int = 1280  # pixels
    height: int = 800  # pixels
    samples: int = 32  # paths a pixel; depth, normals and heat use at most 16 of them
    bounces: int = 4  # surfaces a path may touch, 1 = direct light only
    seed: int = 0
    reach: float = 0.08  # how far ambient occlusion looks, share of the scene's diagonal
    exposure: float | None = None  # linear factor; None measures the picture
    denoise: bool = True  # edge-avoiding filter over the noise of few samples
    chunk: int | None = None  # rays in flight at once, bounds the memory; None is 2^16 a thread, 2^21 on CUDA

    def __post_init__(self) -> None:
        for name in ("width", "height", "samples", "bounces", "chunk"):
            if getattr(self, name) is not None and getattr(self, name) < 1:
                raise ValueError(f"{name} is {getattr(self, name)}, but it must be at least 1")
        if not 0.0 < self.reach < math.inf:
            raise ValueError(f"reach is {self.reach}, but it must be finite and above 0")
        if self.exposure is not None and not 0.0 < self.exposure < math.inf:
            raise ValueError(f"exposure is {self.exposure}, but it must be finite and above 0")
        check_seed(self.seed)
