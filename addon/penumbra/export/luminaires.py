# SPDX-License-Identifier: GPL-3.0-or-later
"""Luminaires: Blender's area, point, spot and sun lights.

What a light asks for beyond what Penumbra does is ignored, with one note per light. A light of negative power takes
light away, as in Cycles. One of no power or no area gives none and is left out.
"""

import math

import numpy as np

from .. import compat
from ..notes import Notes
from .errors import ExportError
from .light_linking import LightLinking
from .nodes import follow, socket_colour, socket_value
from .radiometry import (
    Colour,
    area_radiance,
    extent_of_ball,
    extent_of_sun,
    point_intensity,
    scaled,
    sun_irradiance,
)
from .shader import AttributeNames, Compiler, NoImages, Shaders
from .visibility import role_of

SHAPES = {"SQUARE": "RECTANGLE", "RECTANGLE": "RECTANGLE", "DISK": "ELLIPSE", "ELLIPSE": "ELLIPSE"}


def node_emission(native_module, light, issues: list[str]) -> Colour:
    """What a light's nodes multiply its power and colour with; what they ask for beyond that is added to `issues`."""
    tree = compat.node_tree(light)
    if tree is None:
        return 1.0, 1.0, 1.0
    output = tree.get_output_node("CYCLES") or tree.get_output_node("EEVEE")
    emission = follow(output.inputs["Surface"]) if output else None
    if emission is None:
        return 0.0, 0.0, 0.0
    found: list[str] = []
    compiler = Compiler(light.name, AttributeNames(), NoImages(), found, frozenset(native_module.operations()))
    Shaders(compiler).surface(output.inputs["Surface"])
    colour = native_module.emission_of_program(light.name, **compiler.program.arrays())
    if colour is not None:
        issues += found
        return colour
    # It differs from point to point or direction to direction.
    if emission.bl_idname != "ShaderNodeEmission" or emission.mute:
        issues.append(f"node {emission.name!r} is not supported yet; plain emission was used")
        return 1.0, 1.0, 1.0
    strength = socket_value(emission.inputs["Strength"], issues)
    return scaled(strength, socket_colour(emission.inputs["Color"], issues))


def oriented(matrix: np.ndarray) -> np.ndarray:
    """A rigid transform with the place of `matrix` and the direction of its z axis."""
    z = matrix[:3, 2] / np.linalg.norm(matrix[:3, 2])
    x = np.cross(np.eye(3)[np.argmin(abs(z))], z)
    x /= np.linalg.norm(x)
    result = np.eye(4)
    result[:3] = np.stack([x, np.cross(z, x), z, matrix[:3, 3]], axis=1)
    return result


class Luminaires:
    """The native scene's luminaires."""

    def __init__(self, native_module, native_scene, notes: Notes, linking: LightLinking) -> None:
        self._module, self._scene, self._notes, self._linking = native_module, native_scene, notes, linking

    def add(self, instance) -> None:
        """Adds one entry of depsgraph.object_instances whose object is a light."""
        light, name = instance.object.data, f"light {instance.object.name!r}"
        if getattr(getattr(light, "cycles", None), "is_portal", False):
            self._notes.add(f"{name}: portals are not supported yet and were left out")
            return
        matrix = np.array(instance.matrix_world, dtype=np.float64)
        for what, values in (("power", light.energy), ("colour", tuple(light.color)), ("transform", matrix)):
            if not np.isfinite(values).all():
                raise ExportError(f"{name}: its {what} is not a finite number")
        issues: list[str] = []
        colour = tuple(np.multiply(node_emission(self._module, light, issues), compat.light_colour(light)))
        if not np.isfinite(colour).all():
            raise ExportError(f"{name}: the emission of its nodes is not a finite number")
        if light.energy == 0 or not any(colour):
            return
        add = {"AREA": self._add_area, "POINT": self._add_point, "SPOT": self._add_point, "SUN": self._add_sun}
        add[light.type](instance.object, matrix, colour, issues)
        if issues:
            self._notes.add(f"{name}: {'; '.join(issues)}")

    def _add_area(self, light_object, matrix: np.ndarray, colour: Colour, issues: list[str]) -> None:
        light = light_object.data
        size = light.size, light.size_y if light.shape in ("RECTANGLE", "ELLIPSE") else light.size
        check_finite(light_object, "size", size)
        check_finite(light_object, "spread", light.spread)
        shape = SHAPES[light.shape]
        area = self._scene.area_of(shape, matrix, size)
        if area == 0:
            issues[:] = ["its area is zero, so it gives no light"]
            return
        self._scene.add_area_light(
            light_object.name, shape, matrix, size,
            area_radiance(light.energy, colour, area if compat.light_is_normalized(light) else 1.0),
            spread=min(light.spread, math.pi), **self._common(light_object),
        )  # fmt: skip

    def _add_point(self, light_object, matrix: np.ndarray, colour: Colour, issues: list[str]) -> None:
        light = light_object.data
        check_finite(light_object, "radius", light.shadow_soft_size)
        cone = {}
        if light.type == "SPOT":
            check_finite(light_object, "cone", (light.spot_size, light.spot_blend))
            if np.linalg.det(matrix[:3, :3]) == 0:
                issues[:] = ["its scale is zero, so it gives no light"]
                return
            cone = {"spot": (light.spot_size, light.spot_blend), "cosine_falloff": compat.SPOT_HAS_COSINE}
            if compat.SPOT_IGNORES_SCALE:
                matrix = oriented(matrix)
        extent = 1.0 if compat.light_is_normalized(light) else extent_of_ball(light.shadow_soft_size)
        self._scene.add_point_light(
            light_object.name, matrix, light.shadow_soft_size, point_intensity(light.energy * extent, colour),
            shape="SPHERE" if compat.light_is_sphere(light) else "FACING_DISK", **cone, **self._common(light_object),
        )  # fmt: skip

    def _add_sun(self, light_object, matrix: np.ndarray, colour: Colour, issues: list[str]) -> None:
        light = light_object.data
        check_finite(light_object, "angle", light.angle)
        if not matrix[:3, 2].any():
            issues[:] = ["its scale is zero, so it gives no light"]
            return
        angle = min(light.angle, math.pi)  # Blender's most, which single precision rounds up
        extent = 1.0 if compat.light_is_normalized(light) else extent_of_sun(angle)
        self._scene.add_sun(
            light_object.name, matrix[:3, 2], angle, sun_irradiance(light.energy * extent, colour, angle),
            **self._common(light_object),
        )  # fmt: skip

    def _common(self, light_object) -> dict:
        """What all kinds of luminaires are told."""
        return {"cast_shadow": compat.light_casts_shadows(light_object.data),
                "role": role_of(self._module, light_object, self._linking)}  # fmt: skip


def check_finite(light_object, what: str, values) -> None:
    """Raises ExportError naming the light if one of the values is no finite number."""
    if not np.isfinite(values).all():
        raise ExportError(f"light {light_object.name!r}: its {what} is not a finite number")
