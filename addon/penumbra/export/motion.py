# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion blur: where camera, objects and vertices are at several times while the shutter is open.

The times are Cycles': evenly spaced from the shutter's opening to its closing, as many as the object with the most
motion steps has. What is equal at all of them stands still and is exported as ever. The scene is evaluated at these
times first and at the shutter's centre last, where the export then reads everything else.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from .. import compat
from ..notes import Notes
from .camera import pose_of
from .errors import ExportCancelled
from .meshes import read_mesh

CURVE_POINTS = 64
"""Places at which a shutter curve is read."""


class Shape(NamedTuple):
    """What of a mesh may change."""

    positions: np.ndarray
    corner_normals: np.ndarray | None


def steps_of(evaluated_object, parent) -> int:
    """How often an object's motion is looked at after the shutter's opening; 0 where its blur is switched off."""
    owners = [getattr(owner, "cycles", None) for owner in (evaluated_object, parent) if owner is not None]
    if not all(getattr(owner, "use_motion_blur", True) for owner in owners):
        return 0
    return 2 ** max([getattr(owner, "motion_steps", 1) for owner in owners], default=1)


def key_of(instance) -> tuple:
    """Of an entry of depsgraph.object_instances: the same at all times."""
    parent = instance.parent.original.as_pointer() if instance.is_instance else 0
    return instance.object.original.as_pointer(), parent, tuple(instance.persistent_id)


def may_deform(instance) -> bool:
    """Whether the mesh of an entry may have another shape at another time, as far as one can tell without a look."""
    shown, source = instance.object, instance.object.original
    if instance.is_instance and source == instance.parent.original:  # made by geometry nodes
        return False
    if not getattr(getattr(shown, "cycles", None), "use_deform_motion", True):
        return False
    return source.type != "MESH" or bool(source.modifiers) or source.data.shape_keys is not None


def is_still(values: list) -> bool:
    return all(np.array_equal(values[0], value) for value in values[1:])


class Motion:
    """What was recorded, and Blender's frame as it was before."""

    def __init__(self, engine, depsgraph, notes: Notes, is_cancelled: Callable[[], bool] = lambda: False) -> None:
        scene = depsgraph.scene_eval
        self._engine, self._depsgraph, self._notes = engine, depsgraph, notes
        self._frame = scene.frame_current + scene.frame_subframe
        shutter = scene.render.motion_blur_shutter
        centre = self._frame + {"START": 0.5, "CENTER": 0.0, "END": -0.5}[compat.motion_blur_position(scene)] * shutter
        self.shutter = self._shutter_curve(scene)
        self._steps: dict[tuple, int] = {}
        """of each key"""
        most = max([steps_of(depsgraph.scene.camera, None) if depsgraph.scene.camera else 0,
                    *(steps_of(i.object, i.parent) for i in depsgraph.object_instances)], default=0)  # fmt: skip
        self._count = most + 1 if most else 0
        self.camera: list[tuple[np.ndarray, tuple]] = []
        """(world_from_camera, window) at each time; none where it stands still"""
        self._matrices: list[dict[tuple, np.ndarray]] = []
        self._shapes: list[dict[int, Shape]] = []
        self._told: set[int] = set()
        try:
            for i in range(self._count):
                if is_cancelled():
                    raise ExportCancelled
                self._go_to(centre + (i / most - 0.5) * shutter)
                self._record()
            self._go_to(centre)
        except BaseException:
            self.end()
            raise
        if self.camera and all(is_still(list(part)) for part in zip(*self.camera, strict=True)):
            self.camera = []

    def _go_to(self, time: float) -> None:
        frame = math.floor(time)
        self._engine.frame_set(frame, subframe=time - frame)

    def end(self) -> None:
        """Blender is at its own frame again."""
        self._go_to(self._frame)

    def _shutter_curve(self, scene) -> list[float]:
        """How far the shutter is open, at evenly spaced times; empty where that is all the same."""
        mapping = scene.render.motion_blur_shutter_curve
        mapping.initialize()
        values = [mapping.evaluate(mapping.curves[0], (i + 0.5) / CURVE_POINTS) for i in range(CURVE_POINTS)]
        values = [max(value, 0.0) for value in values]
        if getattr(scene.cycles, "rolling_shutter_type", "NONE") != "NONE":
            self._notes.add(f"scene {scene.name!r}: the rolling shutter is not supported and was left out")
        return [] if max(values) - min(values) < 1e-6 or max(values) == 0 else values

    def _record(self) -> None:
        """The scene as it is evaluated now."""
        scene, matrices, shapes = self._depsgraph.scene_eval, {}, {}
        camera = self._engine.camera_override or scene.camera
        if camera is not None and camera.type == "CAMERA" and steps_of(camera, None):
            self.camera.append(pose_of(camera, self._depsgraph))
        for instance in self._depsgraph.object_instances:
            steps = steps_of(instance.object, instance.parent)
            if not steps:
                continue
            key = key_of(instance)
            self._steps[key] = steps
            matrices[key] = np.array(instance.matrix_world, dtype=np.float64)
            if instance.object.type == "MESH" and key[0] not in shapes and may_deform(instance):
                arrays = read_mesh(instance.object.data)
                shapes[key[0]] = Shape(arrays.positions, arrays.corner_normals)
        self._matrices.append(matrices)
        self._shapes.append(shapes)

    def _at_times(self, recorded: list[dict], key, steps: int) -> list:
        """What was recorded at the object's own times; none where it was not there at one of them or stands still."""
        values = [times.get(key) for times in recorded[:: max((self._count - 1) // steps, 1)]]
        return values if len(values) > 1 and all(value is not None for value in values) else []

    def matrices(self, instance) -> list[np.ndarray]:
        """The transform of an entry at its times; empty if it stands still."""
        key = key_of(instance)
        values = self._at_times(self._matrices, key, self._steps.get(key, 1))
        return [] if not values or is_still(values) else values

    def may_deform(self, instance) -> bool:
        """Whether a shape was recorded for an entry."""
        return bool(self._shapes) and key_of(instance)[0] in self._shapes[0] and may_deform(instance)

    def shapes(self, instance, arrays) -> list[Shape]:
        """The shapes of an entry's mesh at its times; empty if it keeps the one in `arrays`."""
        key = key_of(instance)
        values = self._at_times(self._shapes, key[0], self._steps.get(key, 1))
        if not values or is_still([value.positions for value in values]):
            return []
        smooth = arrays.corner_normals is not None
        if any(len(v.positions) != len(arrays.positions) or (v.corner_normals is not None) != smooth
               or (smooth and len(v.corner_normals) != len(arrays.corner_normals)) for v in values):  # fmt: skip
            if key[0] not in self._told:
                self._notes.add(f"object {instance.object.name!r}: its vertices change in number while the shutter is"
                                " open; its shape is not blurred")  # fmt: skip
            self._told.add(key[0])
            return []
        return values

    def note_moving_light(self, instance) -> None:
        """Luminaires stay where they are at the shutter's centre."""
        if self.matrices(instance):
            self._notes.add(f"object {instance.object.name!r}: it gives light and moves; it stays where it is at the"
                            " shutter's centre")  # fmt: skip


def record(engine, depsgraph, notes: Notes, is_cancelled: Callable[[], bool]) -> Motion | None:
    """The motion of a final render, if the scene asks for its blur."""
    scene = depsgraph.scene_eval
    if not scene.render.use_motion_blur or scene.render.motion_blur_shutter <= 0:
        return None
    if scene.penumbra.pixel_samples == 1:
        notes.add(f"scene {scene.name!r}: with one ray a pixel (pixel_samples 1) there is no motion blur")
        return None
    return Motion(engine, depsgraph, notes, is_cancelled)
