"""Random meshes, arrays and damage to bytes, for tools/fuzz.py: most of it wrong in one way or another."""

from __future__ import annotations

import struct
from random import Random
from typing import Any

import numpy as np

Array = np.ndarray[Any, np.dtype[Any]]

_NUMBERS = (0.0, -0.0, 1.0, -1.0, 0.5, 1e-45, -1e-45, 1e-38, 3.4e38, -3.4e38, 1e30, 2.0**24 + 1, 5e6)
_NUMBERS += (float("nan"), float("inf"), float("-inf"), 1e300, -1e300)
_DTYPES = ("f4", "f4", "f8", "f2", ">f4", "i4", "u1", "i8", "u8", np.longdouble)
_WRONG_DTYPES = ("?", "c8", "O", "U3", "M8[s]", "S2")
_NO_ARRAYS = (None, "abc", b"abc", {}, object(), [[1, 2], [3]], 10**40, {1, 2}, float("nan"), True, [], ())
_WORDS = (
    "nan",
    "inf",
    "-inf",
    "-1",
    "0",
    "1e999",
    "4294967296",
    "99999999999999999999",
    "-2147483649",
    "1.5",
)
_WORDS += (
    "",
    "#",
    "\\",
    "/",
    "//",
    "0/0/0",
    "é",
    "\0",
    "f",
    "v",
    "end_header",
    "element face 3",
    "OFF",
    "solid",
)


def numpy_of(random: Random) -> np.random.Generator:
    """A numpy generator that this one seeds."""
    return np.random.default_rng(random.getrandbits(64))


def mesh(random: Random, most_faces: int = 40) -> tuple[Array, Array]:
    """Vertices and faces that `treelet.build` takes: soups, far, flat or huge, with shared vertices, NaN."""
    rng = numpy_of(random)
    count = random.randrange(most_faces + 1)
    vertices = rng.standard_normal((3 * count + random.randrange(4), 3))
    if random.random() < 0.3:
        vertices = np.round(vertices * 2)  # many equal coordinates, planes and edges in common
    if random.random() < 0.2:
        vertices[:, random.randrange(3)] = 0
    vertices *= random.choice((1, 1, 1, 1e-38, 1e-42, 1e19, 1e38, 100))
    vertices += random.choice((0, 0, 0, 5e6, 1e30))
    if random.random() < 0.3:
        put_nasty(random, vertices)
    faces = rng.integers(0, max(len(vertices), 1), (count if len(vertices) else 0, 3))
    if random.random() < 0.2 and len(faces):
        faces[random.randrange(len(faces)) :] = faces[0]
    with np.errstate(all="ignore"):
        return vertices.astype(random.choice(("f4", "f4", "f8"))), faces.astype(
            random.choice(("i4", "u4", "i8"))
        )


def put_nasty(random: Random, array: Array) -> None:
    """Some of the numbers become extreme ones."""
    flat = array.reshape(-1)
    for _ in range(random.randrange(1, 4) if flat.size else 0):
        with np.errstate(all="ignore"):
            flat[random.randrange(flat.size)] = random.choice(_NUMBERS)


def vectors(random: Random, shape: tuple[int, ...], near: Array) -> Array:
    """(*shape, 3) points or directions of any size and type, many at vertices of a mesh."""
    rng = numpy_of(random)
    array = rng.standard_normal((*shape, 3)) * random.choice((1, 1, 1, 1e-40, 1e20, 100))
    if random.random() < 0.4:
        array = np.sign(array)
    if random.random() < 0.4 and len(near) and array.size:
        with np.errstate(invalid="ignore"):  # of a signalling NaN
            array = near[rng.integers(0, len(near), shape)].astype("f8")
    if random.random() < 0.2:
        put_nasty(random, array)
    with np.errstate(all="ignore"):
        return in_other_memory(random, array.astype(random.choice(("f4", "f4", "f8"))))


def numbers(random: Random, shape: tuple[int, ...]) -> Any:
    """Limits or radii: one for all, or one each."""
    if random.random() < 0.4:
        return random.choice(_NUMBERS)
    array = numpy_of(random).standard_normal(shape) * 3
    if random.random() < 0.3:
        put_nasty(random, array)
    return array


def shape(random: Random) -> tuple[int, ...]:
    """A leading shape of a few rays or points."""
    return random.choice(((), (0,), (1,), (5,), (17,), (3, 4), (4, 8), (2, 0, 3), (1, 1, 1), (8, 8)))


def in_other_memory(random: Random, array: Array) -> Array:
    """The same values strided, read-only, backwards, unaligned or in Fortran's order."""
    kind = random.randrange(8)
    if kind == 0:
        return np.asfortranarray(array)
    if kind == 1:
        array.flags.writeable = False
    if kind == 2 and array.ndim:
        return np.repeat(array, 2, axis=0)[::2]
    if kind == 3 and array.ndim:
        return array[::-1].copy()[::-1]
    if kind == 4 and array.size:
        return np.frombuffer(b"x" + array.tobytes(), np.uint8)[1:].view(array.dtype).reshape(array.shape)
    return array


def anything(random: Random) -> Any:
    """What need not be an array at all."""
    if random.random() < 0.4:
        return random.choice(_NO_ARRAYS)
    size = tuple(random.choice((0, 1, 2, 3, 3, 4)) for _ in range(random.randrange(4)))
    wrong = random.random() < 0.2
    array = numpy_of(random).integers(-3, 9, size)
    with np.errstate(all="ignore"):
        array = array.astype(random.choice(_WRONG_DTYPES if wrong else _DTYPES))
        if array.dtype.kind == "f" and random.random() < 0.5:
            put_nasty(random, array)
    return in_other_memory(random, array)


def damaged(random: Random, content: bytes) -> bytes:
    """The bytes after one to four accidents."""
    content = bytearray(content)
    for _ in range(random.randrange(1, 5)):
        _damage(random, content)
    return bytes(content)


def _damage(random: Random, content: bytearray) -> None:
    begin = random.randrange(len(content) + 1)
    end = min(len(content), begin + random.choice((0, 1, 1, 2, 4, 8, 100)))
    kind = random.randrange(8)
    if kind == 0:
        content[begin:end] = random.randbytes(end - begin)
    elif kind == 1 and begin < len(content):
        content[begin] ^= 1 << random.randrange(8)
    elif kind == 2:
        del content[begin:end]
    elif kind == 3:
        del content[begin:]
    elif kind == 4:
        content[begin:begin] = content[begin:end] * random.randrange(1, 4)
    elif kind == 5:
        _replace_word(random, content)
    elif kind == 6:
        at = begin // 4 * 4
        word = random.choice(
            (0, 1, 7, 2**31 - 1, 2**31, 2**32 - 1, 0x7FC00000, 0x7F800000, random.randrange(40))
        )
        content[at : at + 4] = struct.pack("<I", word)
    else:
        content[begin:begin] = random.choice(_WORDS).encode() + random.choice((b"", b" ", b"\n"))


def _replace_word(random: Random, content: bytearray) -> None:
    words = bytes(content).split(b" ")
    words[random.randrange(len(words))] = random.choice(_WORDS).encode()
    content[:] = b" ".join(words)
