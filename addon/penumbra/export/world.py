# SPDX-License-Identifier: GPL-3.0-or-later
"""The world: the colour seen where a camera ray hits nothing. It does not light the scene yet."""

from .. import compat
from ..notes import Notes
from .nodes import follow, socket_colour, socket_value


def background_colour(world, issues: list[str]) -> tuple[float, float, float]:
    """Scene-linear radiance of the world; black without a world or without a background node, as in Cycles."""
    if world is None:
        return 0.0, 0.0, 0.0
    tree = compat.node_tree(world)
    if tree is None:
        return tuple(world.color)
    output = tree.get_output_node("CYCLES") or tree.get_output_node("EEVEE")
    node = follow(output.inputs["Surface"]) if output else None
    if node is None:
        return 0.0, 0.0, 0.0
    if node.bl_idname != "ShaderNodeBackground":
        issues.append(f"node {node.name!r} is not supported yet; the background is black")
        return 0.0, 0.0, 0.0
    strength = socket_value(node.inputs["Strength"], issues)
    return tuple(strength * c for c in socket_colour(node.inputs["Color"], issues))


def export(native_scene, scene, notes: Notes) -> None:
    """Sets the native scene's background."""
    issues: list[str] = []
    colour = background_colour(scene.world, issues)
    if any(colour):
        issues.append("its light is not supported yet and was left out; the camera sees its colour")
    if issues:
        notes.add(f"world {scene.world.name!r}: {'; '.join(issues)}")
    native_scene.set_background(color=colour, transparent=scene.render.film_transparent)
