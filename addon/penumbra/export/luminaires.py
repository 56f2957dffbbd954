# SPDX-License-Identifier: GPL-3.0-or-later
"""Luminaires: Blender's area lights.

Other kinds of light are left out, features beyond shape, size, power, colour and shadow are ignored, with one note per
light. A light of negative power takes light away, as in Cycles. One of no power or no area gives none and is left out.
"""

import math

import numpy as np

from .. import compat
from ..notes import Notes
from .errors import ExportError
from .nodes import follow, socket_colour

SHAPES = {"SQUARE": "RECTANGLE", "RECTANGLE": "RECTANGLE", "DISK": "ELLIPSE", "ELLIPSE": "ELLIPSE"}
LATER_PROPERTIES = {"exposure": 0.0, "normalize": True, "use_temperature": False}
"""Properties that area lights have from Blender 4.5 on, with the values that change nothing."""


def area_radiance(power: float, colour: tuple[float, float, float], area: float) -> tuple[float, float, float]:
    """Radiance (r, g, b) in W/(sr m^2) leaving the emitting side of an area light.

    power: Blender's watts. area: the true area in square metres, the object's scale included. The law is Blender's own,
    which changed with 4.0: P / (4 A) before, P / (pi A), the radiance of a Lambertian emitter of P watts, since.
    """
    divisor = 4.0 if compat.AREA_LIGHT_WATTS_OVER_FOUR_AREAS else math.pi
    return tuple(power * component / (divisor * area) for component in colour)


def has_plain_nodes(light) -> bool:
    """Whether a light has no nodes, or only those it starts with: a white Emission of strength 1."""
    tree = compat.node_tree(light)
    if tree is None:
        return True
    output = tree.get_output_node("CYCLES") or tree.get_output_node("EEVEE")
    emission = follow(output.inputs["Surface"]) if output else None
    if emission is None or emission.bl_idname != "ShaderNodeEmission":
        return False
    issues: list[str] = []
    colour, strength = socket_colour(emission.inputs["Color"], issues), emission.inputs["Strength"]
    return not issues and colour == (1.0, 1.0, 1.0) and not strength.is_linked and strength.default_value == 1.0


def ignored_features(light_object) -> list[str]:
    """What an area light asks for that Penumbra does not do yet."""
    light = light_object.data
    found = [name for name, plain in LATER_PROPERTIES.items() if getattr(light, name, plain) != plain]
    if light.spread < math.radians(179.9):
        found.append("spread below 180 degrees")
    if not has_plain_nodes(light):
        found.append("nodes")
    linking = getattr(light_object, "light_linking", None)  # Blender 4.0+
    if linking and (linking.receiver_collection or linking.blocker_collection):
        found.append("light linking")
    return found


class Luminaires:
    """The native scene's luminaires."""

    def __init__(self, native_scene, notes: Notes) -> None:
        self._scene, self._notes = native_scene, notes

    def add(self, instance) -> None:
        """Adds one entry of depsgraph.object_instances whose object is a light."""
        light = instance.object.data
        name = f"light {instance.object.name!r}"
        if light.type != "AREA":
            self._notes.add(f"{name}: {light.type.lower()} lights are not supported yet and were left out")
            return
        if getattr(getattr(light, "cycles", None), "is_portal", False):
            self._notes.add(f"{name}: portals are not supported yet and were left out")
            return
        size = light.size, light.size_y if light.shape in ("RECTANGLE", "ELLIPSE") else light.size
        matrix = np.array(instance.matrix_world, dtype=np.float64)
        colour = tuple(light.color)
        for what, values in (("power", light.energy), ("colour", colour), ("size", size), ("transform", matrix)):
            if not np.isfinite(values).all():
                raise ExportError(f"{name}: its {what} is not a finite number")
        if light.energy == 0 or not any(colour):
            return
        shape = SHAPES[light.shape]
        area = self._scene.area_of(shape, matrix, size)
        if area == 0:
            self._notes.add(f"{name}: its area is zero, so it gives no light")
            return
        if found := ignored_features(instance.object):
            self._notes.add(f"{name}: {', '.join(found)} not supported yet and ignored")
        self._scene.add_area_light(
            instance.object.name, shape, matrix, size, area_radiance(light.energy, colour, area),
            cast_shadow=compat.light_casts_shadows(light),
        )  # fmt: skip
