# SPDX-License-Identifier: GPL-3.0-or-later
"""Cryptomatte's ids and its manifest (Friedman and Jones 2015, and the specification 1.2.0 of Psyop)."""

import json

import numpy as np


def murmur3(data: bytes, seed: int = 0) -> int:
    """MurmurHash3_x86_32 (Austin Appleby, public domain)."""

    def rotated(x: int, bits: int) -> int:
        return (x << bits | x >> (32 - bits)) & 0xFFFFFFFF

    def scrambled(k: int) -> int:
        return rotated(k * 0xCC9E2D51 & 0xFFFFFFFF, 15) * 0x1B873593 & 0xFFFFFFFF

    h, whole = seed, len(data) // 4 * 4
    for i in range(0, whole, 4):
        h = rotated(h ^ scrambled(int.from_bytes(data[i : i + 4], "little")), 13) * 5 + 0xE6546B64 & 0xFFFFFFFF
    if len(data) > whole:
        h ^= scrambled(int.from_bytes(data[whole:], "little"))
    h ^= len(data)
    h = (h ^ h >> 16) * 0x85EBCA6B & 0xFFFFFFFF
    h = (h ^ h >> 13) * 0xC2B2AE35 & 0xFFFFFFFF
    return h ^ h >> 16


def matte_id(name: str) -> float:
    """What the passes show of a name: the bits of its hash, changed where they would be denormal, infinite or NaN."""
    h = murmur3(name.encode())
    exponent = min(max(h >> 23 & 0xFF, 1), 254)
    return float(np.uint32(h & 0x807FFFFF | exponent << 23).view(np.float32))


def metadata(layer: str, kind: str, names) -> dict[str, str]:
    """Entries of a picture's header for the passes `kind`00, `kind`01, ... of a view layer with these names."""
    title = f"{layer}.{kind}"
    prefix = f"cryptomatte/{murmur3(title.encode()):08x}"[:19]  # seven digits
    manifest = {name: f"{murmur3(name.encode()):08x}" for name in sorted(set(names))}
    return {
        f"{prefix}/name": title,
        f"{prefix}/hash": "MurmurHash3_32",
        f"{prefix}/conversion": "uint32_to_float32",
        f"{prefix}/manifest": json.dumps(manifest, ensure_ascii=False, separators=(",", ":")),
    }
