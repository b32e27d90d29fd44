"""Files to damage, for tools/fuzz.py: meshes in each format, and trees whose checksums can be mended."""

from __future__ import annotations

import io
import struct
from random import Random
from typing import Any

import fuzz_values
import numpy as np

Array = np.ndarray[Any, np.dtype[Any]]

_BITS = 2**64 - 1
_PRIMES = (0x9E3779B185EBCA87, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9, 0x85EBCA77C2B2AE63, 0x27D4EB2F165667C5)
_HEADER_BYTES, _FIRST_SECTION, _SECTION_BYTES, _SECTIONS = 168, 64, 32, 3  # docs/file-format.md


def mesh_file(random: Random) -> tuple[str, bytes]:
    """An extension, and the bytes of a small mesh in that format."""
    vertices, faces = fuzz_values.mesh(random, 6)
    write = random.choice(_WRITERS)
    return write(random, vertices, faces)


def _write_ply(random: Random, vertices: Array, faces: Array) -> tuple[str, bytes]:
    order, kind = random.choice("<>a"), random.choice(("float", "double"))
    name = {"<": "binary_little_endian", ">": "binary_big_endian", "a": "ascii"}[order]
    header = (
        f"ply\nformat {name} 1.0\ncomment x\nelement vertex {len(vertices)}\n"
        + "".join(f"property {kind} {axis}\n" for axis in "xyz")
        + f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    if order == "a":
        lines = [" ".join(map(str, row)) for row in vertices.tolist()]
        lines += [" ".join(map(str, (3, *row))) for row in faces.tolist()]
        return ".ply", (header + "\n".join(lines) + "\n").encode()
    rows = np.zeros(len(faces), [("count", "u1"), ("corners", f"{order}i4", 3)])
    rows["count"], rows["corners"] = 3, faces
    with np.errstate(over="ignore"):
        return ".ply", header.encode() + vertices.astype(
            order + ("f4" if kind == "float" else "f8")
        ).tobytes() + rows.tobytes()


def _write_obj(random: Random, vertices: Array, faces: Array) -> tuple[str, bytes]:
    lines = ["v " + " ".join(map(str, row)) for row in vertices.tolist()]
    lines += ["f " + " ".join(f"{corner + 1}/1/1" for corner in row) for row in faces.tolist()]
    return ".obj", "\n".join(lines).encode()


def _write_off(random: Random, vertices: Array, faces: Array) -> tuple[str, bytes]:
    lines = ["OFF", f"{len(vertices)} {len(faces)} 0"] + [
        " ".join(map(str, row)) for row in vertices.tolist()
    ]
    return ".off", "\n".join(lines + [" ".join(map(str, (3, *row))) for row in faces.tolist()]).encode()


def _write_stl(random: Random, vertices: Array, faces: Array) -> tuple[str, bytes]:
    with np.errstate(over="ignore"):
        corners = vertices[faces].astype("<f4").reshape(-1, 3, 3)
    if random.random() < 0.5:
        rows = np.zeros(len(faces), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
        rows["corners"] = corners
        return ".stl", bytes(80) + struct.pack("<I", len(faces)) + rows.tobytes()
    facets = [
        "facet normal 0 0 1\nouter loop\n"
        + "".join(f"vertex {x} {y} {z}\n" for x, y, z in triangle)
        + "endloop\nendfacet\n"
        for triangle in corners.tolist()
    ]
    return ".stl", ("solid x\n" + "".join(facets) + "endsolid x\n").encode()


def _write_npz(random: Random, vertices: Array, faces: Array) -> tuple[str, bytes]:
    file = io.BytesIO()
    np.savez(file, vertices=vertices[None] if random.random() < 0.3 else vertices, faces=faces)
    return ".npz", file.getvalue()


_WRITERS = (_write_ply, _write_ply, _write_obj, _write_off, _write_stl, _write_npz)


def resealed(content: bytes) -> bytes:
    """A tree's file with the checksums that its bytes should have, as who means harm would write it."""
    if len(content) < _HEADER_BYTES:
        return content
    sealed = bytearray(content)
    for section in range(_SECTIONS):
        at = _FIRST_SECTION + section * _SECTION_BYTES
        offset, size = struct.unpack_from("<QQ", sealed, at + 8)
        if offset + size <= len(sealed):
            struct.pack_into("<Q", sealed, at + 24, xxh64(bytes(sealed[offset : offset + size])))
    end = _HEADER_BYTES - 8
    struct.pack_into("<Q", sealed, end, xxh64(bytes(sealed[:end])))
    return bytes(sealed)


def xxh64(data: bytes) -> int:
    """The checksum of the file format, seed 0."""
    body = len(data) // 32 * 32
    if body:
        lanes = [(_PRIMES[0] + _PRIMES[1]) & _BITS, _PRIMES[1], 0, -_PRIMES[0] & _BITS]
        for at, word in enumerate(struct.unpack_from(f"<{body // 8}Q", data)):
            lanes[at % 4] = _round(lanes[at % 4], word)
        value = sum(_rotate(lane, bits) for lane, bits in zip(lanes, (1, 7, 12, 18), strict=True)) & _BITS
        for lane in lanes:
            value = ((value ^ _round(0, lane)) * _PRIMES[0] + _PRIMES[3]) & _BITS
    else:
        value = _PRIMES[4]
    return _finish((value + len(data)) & _BITS, data[body:])


def _finish(value: int, rest: bytes) -> int:
    words = len(rest) // 8
    for word in struct.unpack_from(f"<{words}Q", rest):
        value = (_rotate(value ^ _round(0, word), 27) * _PRIMES[0] + _PRIMES[3]) & _BITS
    rest = rest[8 * words :]
    if len(rest) >= 4:
        value ^= int.from_bytes(rest[:4], "little") * _PRIMES[0] & _BITS
        value, rest = (_rotate(value, 23) * _PRIMES[1] + _PRIMES[2]) & _BITS, rest[4:]
    for byte in rest:
        value = _rotate(value ^ (byte * _PRIMES[4] & _BITS), 11) * _PRIMES[0] & _BITS
    value = (value ^ value >> 33) * _PRIMES[1] & _BITS
    value = (value ^ value >> 29) * _PRIMES[2] & _BITS
    return value ^ value >> 32


def _round(lane: int, word: int) -> int:
    return _rotate((lane + word * _PRIMES[1]) & _BITS, 31) * _PRIMES[0] & _BITS


def _rotate(value: int, bits: int) -> int:
    return (value << bits | value >> 64 - bits) & _BITS
