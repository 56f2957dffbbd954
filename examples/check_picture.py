# SPDX-License-Identifier: GPL-3.0-or-later
"""Reopens a picture that Blender wrote: whole, of the right size, every value finite. Blender itself does not look."""

import struct
from pathlib import Path

import bpy
import numpy as np

EXR_MAGIC = 20000630
EXR_MULTIPART = 0x1000
EXR_LINES_PER_BLOCK = {0: 1, 1: 1, 2: 1, 3: 16, 4: 32, 5: 16, 6: 32, 7: 32, 8: 32, 9: 256}
"""By the compression's number in the file (OpenEXR file layout)."""


class BadPicture(Exception):
    """The file is not the whole picture; the text says why."""


def check_picture(path: Path, size: tuple[int, int]) -> None:
    """Raises BadPicture unless the file holds a whole picture of `size` (width, height) with finite values.

    Of a multilayer EXR file, whose pixels Blender's Python cannot read, size and completeness are checked.
    """
    if not path.is_file() or path.stat().st_size == 0:
        raise BadPicture("the picture was not written (disk full?)")
    with open(path, "rb") as file:
        is_exr = file.read(4) == struct.pack("<i", EXR_MAGIC)
    found = check_exr(path.read_bytes()) if is_exr else None
    image = bpy.data.images.load(str(path))
    try:
        found = tuple(image.size) if found is None else found
        if found != size:
            raise BadPicture(f"the picture has {found[0]} x {found[1]} pixels instead of {size[0]} x {size[1]}")
        pixels = np.empty(len(image.pixels), dtype=np.float32)
        if pixels.size:
            image.pixels.foreach_get(pixels)
        elif image.type != "MULTILAYER":
            raise BadPicture("the picture cannot be read back")
        if not np.isfinite(pixels).all():
            raise BadPicture("the picture has values that are not finite")
    finally:
        bpy.data.images.remove(image)


def check_exr(data: bytes) -> tuple[int, int]:
    """(width, height) of an EXR file in scan lines, in one or more parts; BadPicture if a block is missing or cut."""
    try:
        parts, position = _read_headers(data)
        prefix = 4 if len(parts) > 1 else 0  # the part's number stands before each block
        for part in parts:
            _, bottom, _, top = struct.unpack("<4i", part["dataWindow"])
            blocks = -(-(top - bottom + 1) // EXR_LINES_PER_BLOCK[part["compression"][0]])
            for (offset,) in struct.iter_unpack("<Q", data[position : position + 8 * blocks]):
                _, length = struct.unpack_from("<ii", data, offset + prefix)
                if offset < position or offset + prefix + 8 + length > len(data):
                    raise BadPicture("the picture is cut off (disk full?)")
            position += 8 * blocks
        if len(data) < position:
            raise BadPicture("the picture is cut off (disk full?)")
        left, bottom, right, top = struct.unpack("<4i", parts[0]["dataWindow"])
    except (struct.error, KeyError, IndexError, ValueError) as error:
        raise BadPicture("the picture's header cannot be read (disk full?)") from error
    return right - left + 1, top - bottom + 1


def _read_headers(data: bytes) -> tuple[list[dict[str, bytes]], int]:
    """The attributes of each part of an EXR file, name -> bytes, and where the tables of blocks begin."""
    has_parts = struct.unpack_from("<i", data, 4)[0] & EXR_MULTIPART
    parts, position = [], 8
    while not parts or (has_parts and data[position]):
        attributes = {}
        while data[position]:
            name_end = data.index(0, position)
            type_end = data.index(0, name_end + 1)
            (length,) = struct.unpack_from("<i", data, type_end + 1)
            attributes[data[position:name_end].decode()] = data[type_end + 5 : type_end + 5 + length]
            position = type_end + 5 + length
        parts.append(attributes)
        position += 1
    return parts, position + bool(has_parts)
