"""What a picture is made with."""

from __future__ import annotations

from dataclasses import dataclass


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
    chunk: int = 1 << 16  # rays in flight at once in one worker, bounds the memory

    def __post_init__(self) -> None:
        for name in ("width", "height", "samples", "bounces", "chunk"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name} is {getattr(self, name)}, but it must be at least 1")
        if self.reach <= 0.0:
            raise ValueError(f"reach is {self.reach}, but it must be above 0")
