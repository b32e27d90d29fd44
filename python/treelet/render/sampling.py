"""Random numbers that depend only on (seed, pixel, sample, dimension), never on the order of work.

Samples of one pixel and dimension are the first points of Sobol's (0, 2)-sequence, scrambled and shuffled
by a hash [KolligKeller2002 "Efficient multidimensional sampling"]: far less noise than independent numbers
at the same cost.
"""

from __future__ import annotations

import numpy as np

from treelet.render.arrays import Array, module_of

_TO_UNIT = np.float32(2.0**-32)
_BELOW_ONE = np.float32(1.0 - 2.0**-24)


def hash_64(value: Array) -> Array:
    """Mix uint64 values of any shape (the finaliser of SplitMix64), returns uint64 of the same shape."""
    value = (value ^ (value >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    value = (value ^ (value >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return value ^ (value >> np.uint64(31))


def sobol_table(count: int) -> np.ndarray:
    """The first `count` points of the two-dimensional Sobol sequence, (count, 2) uint32 fixed point."""
    index = np.arange(count, dtype=np.uint32)
    table = np.zeros((count, 2), dtype=np.uint32)
    first = second = np.uint32(1 << 31)
    for bit in range(max(1, int(count - 1).bit_length())):
        is_set = (index >> np.uint32(bit)) & np.uint32(1) != 0
        table[is_set, 0] ^= first
        table[is_set, 1] ^= second
        first >>= np.uint32(1)
        second ^= second >> np.uint32(1)
    return table


class Sampler:
    """Pairs of numbers in [0, 1) for the pixels and samples of one picture."""

    def __init__(self, seed: int, samples: int, xp=np) -> None:
        # A power of two, so that wrapping arithmetic on the indices can permute them.
        self._count = 1 << max(0, samples - 1).bit_length()
        self._xp, self._table = xp, xp.asarray(sobol_table(self._count))
        self._seed = hash_64(np.array([seed & 0xFFFFFFFFFFFFFFFF], dtype=np.uint64))[0]

    def pairs(self, pixel: Array, sample: Array, dimension: int) -> tuple[Array, Array]:
        """Numbers for `pixel` and `sample` (integers, same shape), two float32 arrays of that shape.

        `dimension` tells apart the decisions one path takes: lens, first bounce, sun, ...
        """
        key = self._xp.asarray(pixel).astype(np.uint64) + np.uint64(
            dimension * 0x9E3779B97F4A7C15 & 0xFFFFFFFFFFFFFFFF
        )
        scramble = hash_64(key ^ self._seed)
        point = self._table[self._shuffled(self._xp.asarray(sample).astype(np.uint64), hash_64(scramble))]
        first = point[..., 0] ^ scramble.astype(np.uint32)
        second = point[..., 1] ^ (scramble >> np.uint64(32)).astype(np.uint32)
        return _to_unit(first), _to_unit(second)

    def _shuffled(self, index: Array, key: Array) -> Array:
        """A permutation of [0, count) for each `key`: steps that can be undone, modulo a power of two.

        Xor with a number would not do: Sobol points are linear in it, so all dimensions would stay in step.
        """
        mask = np.uint64(self._count - 1)
        half = np.uint64(max(1, self._count.bit_length() // 2))
        for shift in (0, 21, 42):
            part = key >> np.uint64(shift)
            index = (index * (part | np.uint64(1)) + (part >> np.uint64(11))) & mask
            index ^= index >> half
        return index.astype(np.int64)


def _to_unit(bits: Array) -> Array:
    return module_of(bits).minimum(bits.astype(np.float32) * _TO_UNIT, _BELOW_ONE)
