# SPDX-License-Identifier: GPL-3.0-or-later
"""The world: a colour or an equirectangular picture, seen where a ray hits nothing, that lights the scene."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import bpy
import numpy as np

from .. import compat
from ..notes import Notes
from .errors import ExportError
from .kept import Kept
from .nodes import follow, socket_colour, socket_value

MISSING = np.array([[[1.0, 0.0, 1.0]]], dtype=np.float32)
"""A picture that cannot be read is magenta, as in Cycles."""
LINEAR_SPACES = ("Linear", "Linear Rec.709", "Non-Color", "Raw")
"""Colour spaces whose numbers Blender's scene-linear ones are, in any version's spelling."""


class Sky(NamedTuple):
    """What is beyond all surfaces: radiance (r, g, b), multiplied with a picture if there is one."""

    colour: tuple[float, float, float]
    picture: object = None
    """The native module's"""
    local_from_world: np.ndarray | None = None
    smooth: bool = True


BLACK = Sky((0.0, 0.0, 0.0))


def read_image(image, issues: list[str]) -> np.ndarray:
    """The pixels of one of Blender's images, scene linear, or MISSING with an issue that names it."""
    width, height = image.size
    if not image.has_data and not (width and height):
        issues.append(f"image {image.name!r} can't be read from {image.filepath!r}; rendered magenta")
        return MISSING
    pixels = np.empty((height, width, image.channels), dtype=np.float32)
    image.pixels.foreach_get(pixels.ravel())
    colours = pixels[..., :3] if image.channels >= 3 else np.repeat(pixels[..., :1], 3, axis=2)
    space = image.colorspace_settings.name
    if space == "sRGB":
        low = colours <= 0.04045
        colours = np.where(low, colours / 12.92, ((np.maximum(colours, 0.04045) + 0.055) / 1.055) ** 2.4)
    elif space not in LINEAR_SPACES:
        issues.append(f"colour space {space!r} of image {image.name!r} is not supported yet; taken as linear")
    return np.ascontiguousarray(colours, dtype=np.float32)


def fingerprint(image) -> tuple | None:
    """What is another one where an image's pixels are others; None where nothing tells: painted or generated ones."""
    if image.source != "FILE" or image.is_dirty:
        return None
    path = Path(bpy.path.abspath(image.filepath, library=image.library))
    packed = image.packed_file and hash(image.packed_file.data)
    written = None if packed or not path.is_file() else path.stat().st_mtime_ns
    return image.name_full, str(path), packed, written, tuple(image.size), image.colorspace_settings.name


def picture_of(pn, image, issues: list[str], kept: Kept | None):
    """The native picture of an image, that of an earlier export if nothing has changed; ValueError: it is unusable."""

    if image is None:
        return pn.SkyPicture(MISSING)

    def read():
        found: list[str] = []
        return pn.SkyPicture(read_image(image, found)), found

    picture, found = kept.sky(fingerprint(image), read) if kept else read()
    issues += found
    return picture


def rotation_of(node, issues: list[str]) -> np.ndarray:
    """(4, 4) local from world of an Environment Texture: identity, or the rotation of the Mapping node before it."""
    source = follow(node.inputs["Vector"])
    rotation = np.eye(4)
    if source is not None and source.bl_idname == "ShaderNodeMapping" and not source.mute:
        values = {socket.name: socket for socket in source.inputs if socket.name != "Vector"}  # all that it uses
        if any(socket.is_linked for socket in values.values()):
            issues.append(f"what is linked to node {source.name!r} was ignored")
        moves = source.vector_type in ("POINT", "TEXTURE") and any(values["Location"].default_value)
        if moves:
            issues.append(f"Location of node {source.name!r} is not supported yet and ignored")
        scale = np.array(values["Scale"].default_value)
        if not (np.allclose(scale, scale[0]) and scale[0] > 0):
            issues.append(f"Scale of node {source.name!r} is not supported yet and ignored")
        turn = np.array(values["Rotation"].default_value.to_matrix())
        rotation[:3, :3] = turn.T if source.vector_type == "TEXTURE" else turn
        source = follow(source.inputs["Vector"])
    if source is not None and not (source.bl_idname == "ShaderNodeTexCoord" and not source.mute):
        issues.append(f"node {source.name!r} before the environment texture is not supported yet and ignored")
    return rotation


def sky_of(world, issues: list[str], picture_of: Callable) -> Sky:
    """Black without a world or without a background node, as in Cycles; what is left out is added to `issues`.

    picture_of: makes the native picture of an image, or of None.
    """
    if world is None:
        return BLACK
    tree = compat.node_tree(world)
    if tree is None:
        return Sky(tuple(world.color))
    output = tree.get_output_node("CYCLES") or tree.get_output_node("EEVEE")
    node = follow(output.inputs["Surface"]) if output else None
    if node is None:
        return BLACK
    if output.inputs["Volume"].is_linked:
        issues.append("its volume is not supported and was left out")
    if node.bl_idname != "ShaderNodeBackground" or node.mute:
        issues.append(f"node {node.name!r} is not supported yet; the background is black")
        return BLACK
    strength = socket_value(node.inputs["Strength"], issues)
    texture = follow(node.inputs["Color"])
    if texture is None or texture.bl_idname != "ShaderNodeTexEnvironment" or texture.mute or strength == 0:
        return Sky(tuple(strength * c for c in socket_colour(node.inputs["Color"], issues)))
    if texture.image is None:
        issues.append(f"node {texture.name!r} has no image; rendered magenta")
        return Sky((strength,) * 3, picture_of(None))
    if texture.projection != "EQUIRECTANGULAR":
        issues.append(f"projection of node {texture.name!r} is not supported yet; the background is black")
        return BLACK
    picture, rotation = picture_of(texture.image), rotation_of(texture, issues)
    return Sky((strength,) * 3, picture, rotation, texture.interpolation != "Closest")


def export(pn, native_scene, scene, notes: Notes, light_group: int | None = None, kept: Kept | None = None) -> None:
    """Sets the native scene's background. light_group: number of the group that its light belongs to. kept: what
    earlier exports left."""
    issues: list[str] = []
    world = scene.world
    try:
        sky = sky_of(world, issues, lambda image: picture_of(pn, image, issues, kept))
    except ValueError as problem:
        raise ExportError(f"world {world.name!r}: {str(problem).removeprefix('background: ')}") from problem
    if not np.isfinite(sky.colour).all():
        raise ExportError(f"world {world.name!r}: its colour or strength is not a finite number")
    seen_by = compat.world_visibility(world)
    if any(sky.colour) and seen_by["diffuse"] != seen_by["glossy"]:
        issues.append("ray visibility of diffuse and glossy alone is not supported yet; that of diffuse was used")
    if issues:
        notes.add(f"world {world.name!r}: {'; '.join(issues)}")
    native_scene.set_background(
        color=sky.colour, transparent=scene.render.film_transparent, lights=seen_by["diffuse"],
        seen_by_camera=seen_by["camera"], image=sky.picture, local_from_world=sky.local_from_world, smooth=sky.smooth,
        light_group=light_group,
    )  # fmt: skip
