# SPDX-License-Identifier: GPL-3.0-or-later
"""Which light a material's surface sends out by itself: Emission and Principled nodes of constant colour, mixed."""

import numpy as np

from .. import compat
from .nodes import follow, socket_colour, socket_value


def emission_of(material, issues: list[str]) -> np.ndarray:
    """Radiance (r, g, b) of both sides of a surface; zero for None. What is textured is added to `issues`."""
    tree = compat.node_tree(material) if material is not None else None
    output = tree and (tree.get_output_node("CYCLES") or tree.get_output_node("EEVEE"))
    return sent_by(follow(output.inputs["Surface"]), issues) if output else np.zeros(3)


def sent_by(node, issues: list[str]) -> np.ndarray:
    """Radiance of a shader node (None: nothing)."""
    if node is None or node.mute:
        return np.zeros(3)
    kind = node.bl_idname
    if kind == "ShaderNodeAddShader":
        return sum(sent_by(follow(socket), issues) for socket in node.inputs[:2])
    if kind == "ShaderNodeMixShader":
        parts = [sent_by(follow(socket), issues) for socket in node.inputs[1:3]]
        if not np.any(parts):
            return np.zeros(3)
        factor = min(max(socket_value(node.inputs[0], issues), 0.0), 1.0)
        return parts[0] * (1 - factor) + parts[1] * factor
    if kind == "ShaderNodeGroup" and node.node_tree:
        return sent_by_group(node, issues)
    if kind == "ShaderNodeEmission":
        return product(node.inputs["Color"], node.inputs["Strength"], issues)
    if kind == "ShaderNodeBsdfPrincipled":
        colour = node.inputs.get("Emission Color") or node.inputs["Emission"]
        strength = node.inputs["Emission Strength"]
        if not colour.is_linked and not any(colour.default_value[:3]):
            return np.zeros(3)
        return product(colour, strength, issues)
    return np.zeros(3)


def sent_by_group(node, issues: list[str]) -> np.ndarray:
    """Groups without emission send nothing; what others send depends on their inputs, which is not followed yet."""
    if any(inner.bl_idname == "ShaderNodeEmission" for inner in node.node_tree.nodes):
        issues.append(f"what node group {node.name!r} emits is not supported yet and does not light the scene")
    return np.zeros(3)


def product(colour, strength, issues: list[str]) -> np.ndarray:
    """Colour x strength of two sockets; what is textured does not light the scene, which is noted."""
    if not strength.is_linked and strength.default_value == 0:
        return np.zeros(3)
    found: list[str] = []
    value = np.array(socket_colour(colour, found)) * socket_value(strength, found)
    if found:
        issues.append(f"{colour.node.name!r} emits by a texture, which does not light the scene yet")
        return np.zeros(3)
    return value
