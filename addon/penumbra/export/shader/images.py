# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's images -> the native scene's: which file or bytes, and how their values are meant."""

import re
from pathlib import Path

import bpy
import numpy as np

from ... import compat
from .compiler import UnsupportedNode

LINEAR_SPACES = {"Linear", "Linear Rec.709", "Non-Color", "Raw", "Generic Data", "scene_linear"}
SRGB_SPACES = {"sRGB"}
LAST_DIGITS = re.compile(r"\d+(?=\D*$)")


def sequence_frame(user, frame: int) -> int:
    """The number of the picture that a sequence shows at a frame."""
    number = frame - user.frame_start + 1
    length = max(user.frame_duration, 1)
    number = (number - 1) % length + 1 if user.use_cyclic else min(max(number, 1), length)
    return number + user.frame_offset


def alpha_kind(image, alpha_is_used: bool) -> str:
    """What an image's fourth channel is to the native scene. As in Cycles, colours are straight where a node's Alpha is
    used, else multiplied by it; data are left as they are."""
    if image.alpha_mode == "NONE":
        return "NONE"
    if image.alpha_mode == "CHANNEL_PACKED" or image.colorspace_settings.is_data:
        return "CHANNEL"
    return "STRAIGHT" if alpha_is_used else "COVERAGE"


def pixel_bytes(native_module, image) -> bytes:
    """An image's pixels, raw, as the bytes of a file."""
    width, height = image.size
    if width * height == 0:
        raise ValueError("it has no pixels")
    pixels = np.empty((height, width, image.channels), dtype=np.float32)
    image.pixels.foreach_get(pixels.ravel())
    if image.channels == 4 and not image.is_float and image.alpha_mode in ("STRAIGHT", "PREMUL"):
        pixels[..., :3] *= pixels[..., 3:]  # OpenEXR's colours are premultiplied
    return native_module.encode_image(pixels)


SUFFIXES = {
    b"\x89PNG": ".png", b"\xff\xd8\xff": ".jpg", b"\x76\x2f\x31\x01": ".exr", b"II*\0": ".tif", b"MM\0*": ".tif",
    b"#?": ".hdr", b"BM": ".bmp", b"RIFF": ".webp", b"SDPX": ".dpx", b"XPDS": ".dpx",
}  # fmt: skip
"""By how a file begins."""


def named(path: str, packed) -> tuple[str, bytes | None]:
    """(path, bytes of a packed file or None). OpenImageIO knows formats by names; what was painted, then packed, has a
    name without a suffix."""
    if packed is None:
        return path, None
    suffix = next((suffix for start, suffix in SUFFIXES.items() if packed.data.startswith(start)), "")
    return (path if Path(path).suffix.lower() == suffix else path + suffix), packed.data


class Images:
    """The native scene's images: each combination of image and ways to look it up once."""

    def __init__(self, native_module, native_scene, frame: int) -> None:
        self._module, self._scene, self._frame = native_module, native_scene, frame
        self._ids: dict[tuple, int] = {}

    def number(self, node, material_name: str, issues: list[str]) -> int | None:
        """The native number of an Image Texture node's image; None, and an issue, where it is not supported."""
        image = node.image
        key = (image.as_pointer(), node.extension, node.interpolation, node.outputs["Alpha"].is_linked,
               sequence_frame(node.image_user, self._frame) if image.source == "SEQUENCE" else 0)  # fmt: skip
        if key not in self._ids:
            try:
                files = self._files(image, node.image_user)
            except ValueError as problem:
                issues.append(f"image {image.name!r}: {problem}; rendered in magenta")
                return None
            if compat.PREMULTIPLIED_IS_DIVIDED and image.alpha_mode == "PREMUL" and not image.is_float:
                issues.append(f"image {image.name!r}: premultiplied alpha is not supported yet and read as straight")
            self._ids[key] = self._scene.add_image(
                f"material {material_name!r}: node {node.name!r}: image {image.name!r}",
                files,
                tiled=image.source == "TILED",
                wrap=node.extension,
                interpolation="Cubic" if node.interpolation == "Smart" else node.interpolation,
                srgb=self._is_srgb(image, issues),
                alpha=alpha_kind(image, node.outputs["Alpha"].is_linked),
            )
        return self._ids[key]

    def _is_srgb(self, image, issues: list[str]) -> bool:
        space = image.colorspace_settings.name
        if space in LINEAR_SPACES or image.colorspace_settings.is_data:
            return False
        if space not in SRGB_SPACES:
            kind = "linear" if image.is_float else "sRGB"
            issues.append(f"image {image.name!r}: colour space {space!r} is not supported yet and read as {kind}")
            return not image.is_float
        return True

    def _files(self, image, user) -> list[tuple[int, str, bytes | None]]:
        """[(UDIM tile, path, bytes of the file or None)]. ValueError: not supported."""
        path = bpy.path.abspath(image.filepath, library=image.library)
        if image.source == "GENERATED" or (image.is_dirty and image.source == "FILE"):
            return [(1001, "pixels.exr", pixel_bytes(self._module, image))]
        if image.source == "TILED":
            return [(tile.number, *self._tile(image, path, tile.number)) for tile in image.tiles]
        if image.source == "SEQUENCE":
            name = Path(path).name
            digits = LAST_DIGITS.search(name)
            if digits is None:
                raise ValueError("a sequence needs a number in its file's name")
            number = str(sequence_frame(user, self._frame)).zfill(len(digits.group()))
            return [(1001, str(Path(path).with_name(LAST_DIGITS.sub(number, name, count=1))), None)]
        if image.source != "FILE":
            raise ValueError(f"the source {image.source!r} is not supported yet")
        return [(1001, *named(path, image.packed_file))]

    def _tile(self, image, path: str, number: int) -> tuple[str, bytes | None]:
        """(path, bytes or None) of one tile of an image whose path has <UDIM>, or <UVTILE>, where its number goes."""
        column, row = (number - 1001) % 10 + 1, (number - 1001) // 10 + 1
        path = path.replace("<UDIM>", str(number)).replace("<UVTILE>", f"u{column}_v{row}")
        packed = {bpy.path.abspath(f.filepath, library=image.library): f for f in image.packed_files if f.packed_file}
        return named(path, packed[path].packed_file if path in packed else None)


class NoImages:
    """Of node trees that cannot look up pictures: those of lights."""

    def number(self, node, material_name: str, issues: list[str]) -> int | None:
        raise UnsupportedNode(f"node {node.name!r}: a picture in a light is not supported yet")
