# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair and point clouds: strands and spheres, with the thickness that Cycles gives them."""

from typing import NamedTuple

import numpy as np

from .. import compat
from ..notes import Notes
from .light_linking import LightLinking
from .materials import Materials
from .visibility import rays_of

CURVE_RADIUS, POINT_RADIUS = 0.005, 0.01
"""Metres, of what has no radius of its own, as in Cycles."""


class Strands(NamedTuple):
    """All strands of an object that have one material, in object space."""

    keys: np.ndarray
    """(K, 3), those of all strands one after the other"""
    radii: np.ndarray
    """(K,)"""
    counts: np.ndarray
    """(S,) keys of each strand"""
    slot: int = 0


def read_attribute(data, name: str, width: int, missing: float) -> np.ndarray:
    """A float attribute of the points of curves or a point cloud; `missing` everywhere if there is none."""
    attribute = data.attributes.get(name)
    values = np.full((len(data.points), width), missing, dtype=np.float32)
    if attribute is not None:
        attribute.data.foreach_get("vector" if width == 3 else "value", values.ravel())
    return values


def read_curves(data) -> Strands:
    """A Curves datablock: the control points are a strand's keys, whatever kind of curve it is."""
    counts = np.empty(len(data.curves), dtype=np.int32)
    data.curves.foreach_get("points_length", counts)
    return Strands(
        read_attribute(data, "position", 3, 0.0), read_attribute(data, "radius", 1, CURVE_RADIUS)[:, 0], counts
    )


def profile(shape: float, root: float, tip: float, along: np.ndarray) -> np.ndarray:
    """The radius at a share 0 ... 1 of a strand's length, after Cycles."""
    falloff = 1 - along
    if shape < 0:
        falloff = falloff ** (1 + shape)
    elif shape > 0:
        falloff = falloff ** (1 / max(1 - shape, 1e-6))
    return falloff * (root - tip) + tip


def stay_at_end(keys: np.ndarray) -> np.ndarray:
    """(strands, steps, 3): beyond the last key that a strand has, Blender leaves a place as it was, which is zero from
    Python; in Cycles it is the key before. Strands with kinks have fewer than their steps say, cut ones, too."""
    is_left = np.logical_and.accumulate((keys == 0).all(axis=2)[:, ::-1], axis=1)[:, ::-1]
    last = keys.shape[1] - 1 - is_left.sum(axis=1)
    ends = np.take_along_axis(keys, np.maximum(last, 0)[:, None, None], axis=1)
    return np.where(is_left[:, :, None], ends, keys)


def read_particles(emitter, system, to_object: np.ndarray) -> Strands | None:
    """The strands of a hair particle system as it renders; None without any.

    Children take the place of their parents. Blender tells positions in world space.
    """
    settings = system.settings
    parents, children = len(system.particles), len(system.child_particles)
    numbers = range(parents, parents + children) if settings.child_type != "NONE" and children else range(parents)
    steps = 2**settings.render_step + 1 + (settings.kink_extra_steps if settings.kink == "SPIRAL" else 0)
    if not numbers:
        return None
    place = system.co_hair
    keys = np.array([place(emitter, particle_no=n, step=s) for n in numbers for s in range(steps)], dtype=np.float64)
    keys = stay_at_end(keys.reshape(len(numbers), steps, 3)) @ to_object[:3, :3].T + to_object[:3, 3]
    lengths = np.linalg.norm(np.diff(keys, axis=1), axis=2)
    along = np.concatenate([np.zeros((len(numbers), 1)), np.cumsum(lengths, axis=1)], axis=1)
    along = np.minimum(along / np.maximum(along[:, -1:], 1e-30), 1.0)
    scale = settings.radius_scale / 2
    radii = profile(settings.shape, scale * settings.root_radius, scale * settings.tip_radius, along)
    if settings.use_close_tip:
        radii[:, -1] = 0
    counts = np.full(len(numbers), steps, dtype=np.int32)
    return Strands(keys.reshape(-1, 3), radii.ravel(), counts, max(settings.material - 1, 0))


def hair_systems(evaluated_object) -> list:
    """The particle systems that render as strands."""
    return [
        modifier.particle_system for modifier in evaluated_object.modifiers
        if modifier.type == "PARTICLE_SYSTEM" and modifier.show_render
        and modifier.particle_system.settings.type == "HAIR"
        and modifier.particle_system.settings.render_type == "PATH"
    ]  # fmt: skip


class Hair:
    """The native scene's strands and point clouds."""

    def __init__(self, native_module, native_scene, scene, materials: Materials, notes: Notes,
                 linking: LightLinking) -> None:  # fmt: skip
        self._module, self._scene, self._notes = native_module, native_scene, notes
        self._materials, self._linking = materials, linking
        self._shape = compat.hair_shape(scene)
        self._ids: dict[int, list[tuple[int, int]]] = {}
        """by address: (number as a mesh, material slot) of each part"""

    def add_curves(self, instance, motion) -> None:
        """Adds one entry of depsgraph.object_instances whose object is a Curves object."""
        data = instance.object.data
        self._add(instance, data.as_pointer(), lambda: [read_curves(data)], motion)

    def add_particles(self, instance, motion) -> None:
        """Adds the hair that an entry's object has through particle systems."""
        emitter = instance.object
        systems = hair_systems(emitter)
        if not systems:
            return
        try:
            to_object = np.linalg.inv(np.array(emitter.matrix_world, dtype=np.float64))
        except np.linalg.LinAlgError:
            self._notes.add(f"object {emitter.name!r}: its scale is zero in some direction, so it has no hair")
            return
        self._add(instance, emitter.original.as_pointer(),
                  lambda: filter(None, (read_particles(emitter, system, to_object) for system in systems)),
                  motion)  # fmt: skip

    def add_points(self, instance, motion) -> None:
        """Adds one entry whose object is a point cloud."""
        data, name = instance.object.data, instance.object.name
        key = data.as_pointer()
        if key not in self._ids and len(data.points):
            positions, radii = (read_attribute(data, *what) for what in (("position", 3, 0.0),
                                                                         ("radius", 1, POINT_RADIUS)))  # fmt: skip
            self._ids[key] = [(self._scene.add_points(name, positions, radii[:, 0]), 0)]
        self._place(instance, key, motion)

    def _add(self, instance, key: int, read, motion) -> None:
        name = instance.object.name
        if key not in self._ids:
            self._ids[key] = [(self._scene.add_curves(name, s.keys, s.radii, s.counts, self._shape), s.slot)
                              for s in read() if len(s.keys)]  # fmt: skip
        self._place(instance, key, motion)

    def _place(self, instance, key: int, motion) -> None:
        moved = {"motion": motion.matrices(instance)} if motion else {}
        slots = self._materials.of_slots(instance.object)
        for number, slot in self._ids.get(key, []):
            material = slots[min(slot, len(slots) - 1)]
            if material.attributes:
                self._notes.add(f"object {instance.object.name!r}: its strands and points have no UV maps, colours or"
                                " other attributes yet")  # fmt: skip
            self._scene.add_instance(instance.object.name, number, np.array(instance.matrix_world, dtype=np.float64),
                                     [material.number], rays=rays_of(self._module, instance, self._linking),
                                     receiver_set=self._linking.receiver_set(instance), **moved)  # fmt: skip
