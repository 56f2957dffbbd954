# SPDX-License-Identifier: GPL-3.0-or-later
"""What stays from one export to the next, and what of the scene has changed in between."""

from typing import NamedTuple

import bpy

from .shader import AttributeNames

WITHOUT_GEOMETRY = (bpy.types.Scene, bpy.types.Camera, bpy.types.Light, bpy.types.Material, bpy.types.World,
                    bpy.types.Image, bpy.types.ShaderNodeTree)  # fmt: skip
"""Datablocks whose change leaves meshes as they are; an object says itself whether its geometry has changed."""
SHAPELESS = {"LIGHT", "CAMERA", "SPEAKER", "LIGHT_PROBE"}
"""Types of objects that are no meshes; Blender calls the change of a light one of its geometry."""
UNSEEN = (bpy.types.Scene, bpy.types.Camera)
"""Datablocks whose change is none of what is exported to a 3D view."""


class Changes(NamedTuple):
    """What the last update of a depsgraph was about."""

    content: bool
    """anything but cameras, selections and the scene's settings"""
    geometry: bool
    """some mesh may be another one"""


ALL = Changes(True, True)


def changes_in(depsgraph) -> Changes:
    """Those of the depsgraph's last update."""
    updates = list(depsgraph.updates)
    # Blender 4 tags the shading of all objects along with a scene whose settings change.
    is_scenes = any(isinstance(update.id, bpy.types.Scene) and update.is_updated_shading for update in updates)
    content = geometry = False
    for update in updates:
        changed = update.id
        if isinstance(changed, bpy.types.Object):
            if changed.type == "CAMERA":
                continue
            is_shaded = update.is_updated_shading and not is_scenes
            content = content or update.is_updated_geometry or update.is_updated_transform or is_shaded
            geometry = geometry or (update.is_updated_geometry and changed.type not in SHAPELESS)
        else:
            content = content or not isinstance(changed, UNSEEN)
            # Blender 4 tags the shading of a material's meshes along with it.
            is_shape = update.is_updated_geometry or not isinstance(changed, bpy.types.Mesh)
            geometry = geometry or (is_shape and not isinstance(changed, WITHOUT_GEOMETRY))
    return Changes(content, geometry)


class Kept:
    """The meshes of the last export, with their ray tracing structures, the textures' pixels and the world's picture.

    They are found by their content, so whatever was read anew and is as before costs no more than the reading. Where
    the depsgraph tells that no geometry has changed, evaluated meshes are found by their addresses and not even read.
    """

    def __init__(self, native_module) -> None:
        self._store = native_module.MeshStore()
        self.textures = native_module.TextureStore()
        self._before: dict = {}
        self._now: dict = {}
        self._alive: list = []  # a mesh that nobody holds is not found again
        self.attributes = AttributeNames()
        """One numbering for all exports, as meshes know attributes by their numbers"""
        self.meshes_read = 0
        """How many meshes were read from Blender so far"""
        self.skies_read = 0
        """How often a picture of the world was"""
        self._sky: tuple | None = None
        self._sky_is_used = False

    def begin(self, changes: Changes = ALL) -> None:
        """Called before an export: what has changed since the last one."""
        self._alive = [*self._before.values(), *self._now.values()]
        self._before, self._now = ({} if changes.geometry else self._now | self._before), {}
        self._sky_is_used = False

    def end(self) -> None:
        """Called after a whole export: lets go of what it did not use."""
        self._before, self._alive = {}, []
        if not self._sky_is_used:
            self._sky = None

    def mesh(self, key, read):
        """The kept mesh of an address in Blender's memory, or None if it has no triangles. read: returns the arguments
        of the native store's keep, or None."""
        if key not in self._now:
            if key in self._before:
                self._now[key] = self._before[key]
            else:
                arguments = read()
                self.meshes_read += 1
                self._now[key] = self._store.keep(*arguments) if arguments else None
        return self._now[key]

    def sky(self, fingerprint, read):
        """What `read` returned for the world's picture, as long as its fingerprint is the same and not None."""
        if fingerprint is None or self._sky is None or self._sky[0] != fingerprint:
            self._sky = None  # two large pictures at once are one too many
            self._sky = fingerprint, read()
            self.skies_read += 1
        self._sky_is_used = True
        return self._sky[1]
