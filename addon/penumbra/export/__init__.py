# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's evaluated scene -> the native renderer's. `export_scene` is the table of contents of this room."""

from collections.abc import Callable

from ..notes import Notes
from . import camera, world
from .errors import ExportCancelled, ExportError
from .hair import Hair
from .kept import Kept
from .light_linking import LightLinking
from .luminaires import Luminaires
from .materials import Materials
from .mesh_lights import MeshLights
from .meshes import Meshes
from .motion import Motion
from .places import world_matrices
from .traits import Traits

__all__ = ["ExportCancelled", "ExportError", "Kept", "export_scene", "is_shown"]

OBJECTS_BETWEEN_BREAKS = 256
LEFT_OUT = {
    "VOLUME": "volumes",
    "GPENCIL": "grease pencil strokes",
    "GREASEPENCIL": "grease pencil strokes",
}


def is_shown(instance, space) -> bool:
    """Whether an entry of depsgraph.object_instances is to be rendered: in a 3D view, or finally (None)."""
    return instance.show_self and (space is None or instance.object.visible_in_viewport_get(space))


def export_scene(pn, depsgraph, camera_object, notes: Notes, is_cancelled: Callable[[], bool] = lambda: False,
                 space=None, kept: Kept | None = None, passes: frozenset[str] = frozenset(),
                 mattes: dict[str, set[str]] | None = None, motion: Motion | None = None):  # fmt: skip
    """The native scene of an evaluated depsgraph, all in world space and metres.

    pn: the native module. camera_object: the evaluated camera, None for the scene's own. notes: gets one note for each
    thing that Penumbra renders differently from what the file asks. Raises ExportError or ValueError naming the object
    at fault; ExportCancelled as soon as `is_cancelled()` is seen. space: a 3D view, whose own camera is set later, and
    whose hidden objects are left out. kept: what earlier exports left; its begin() tells what has changed since.
    passes: native names of those that are wanted. mattes: gets the names of what was exported, by Cryptomatte's pass.
    motion: what was recorded of it, if it is to be blurred.
    """
    scene = pn.Scene(kept.textures) if kept else pn.Scene()
    traits = Traits(scene, depsgraph, passes)
    materials = Materials(pn, scene, notes, depsgraph.view_layer_eval.material_override,
                          depsgraph.scene_eval.frame_current, traits, kept and kept.attributes)  # fmt: skip
    linking = LightLinking(pn, depsgraph, notes)
    meshes = Meshes(pn, scene, materials, notes, linking, kept)
    luminaires = Luminaires(pn, scene, notes, linking)
    hair = Hair(pn, scene, depsgraph.scene_eval, materials, notes, linking)
    mesh_lights = MeshLights(pn, scene, materials, linking)

    if space is None:
        camera.export(scene, depsgraph, camera_object, notes, motion)
    world.export(pn, scene, depsgraph.scene_eval, notes, traits.light_group(depsgraph.scene_eval.world), kept)
    matrices = world_matrices(depsgraph.object_instances)
    for count, instance in enumerate(depsgraph.object_instances):
        if count % OBJECTS_BETWEEN_BREAKS == 0 and is_cancelled():
            raise ExportCancelled
        if instance.show_particles and (space is None or instance.object.visible_in_viewport_get(space)):
            traits.set_for(instance)
            hair.add_particles(instance, motion)
        if not is_shown(instance, space):
            continue
        kind = instance.object.type
        traits.set_for(instance)
        if kind == "MESH":  # curves, text, surfaces and metaballs come as instances of a mesh, too
            stays = motion is not None and mesh_lights.shines(instance)
            mesh_lights.add(instance, meshes.add(instance, matrices[count], None if stays else motion))
            if stays:
                motion.note_moving_light(instance)
        elif kind == "LIGHT":
            luminaires.add(instance)
            if motion:
                motion.note_moving_light(instance)
        elif kind == "CURVES":
            hair.add_curves(instance, motion)
        elif kind == "POINTCLOUD":
            hair.add_points(instance, motion)
        elif kind in LEFT_OUT:
            notes.add(f"object {instance.object.name!r}: {LEFT_OUT[kind]} are not supported yet and were left out")
    if not scene.is_lit:
        notes.add(f"scene {depsgraph.scene.name!r}: nothing lights it: no light shines, no mesh emits, and the world"
                  " gives no light")  # fmt: skip
    if kept:
        kept.end()
    if mattes is not None:
        mattes.update(traits.names)
    return scene
