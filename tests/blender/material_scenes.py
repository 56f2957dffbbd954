# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials built node by node, and a scene for them: a floor with two UV maps and a colour, and a smooth sphere."""

import bpy
import numpy as np
from cycles_reference import away_from_edges, colour, render_with_cycles, render_with_penumbra
from helpers import add_area_light, add_camera, add_plane
from penumbra import statistics

GLOSSY = "ShaderNodeBsdfGlossy" if hasattr(bpy.types, "ShaderNodeBsdfGlossy") else "ShaderNodeBsdfAnisotropic"
PRINCIPLED = "ShaderNodeBsdfPrincipled"


class Tree:
    """A material's nodes; add() makes one, with values or other nodes' outputs for its inputs, and properties."""

    def __init__(self, name: str = "Material") -> None:
        self.material = bpy.data.materials.new(name)
        self.material.use_nodes = True
        self.tree = self.material.node_tree
        self.tree.nodes.clear()
        self._output = self.tree.nodes.new("ShaderNodeOutputMaterial")

    def add(self, kind: str, inputs: dict | None = None, **properties):
        """The new node. `inputs`: by name or index."""
        node = self.tree.nodes.new(kind)
        for name, value in properties.items():
            setattr(node, name, value)
        for name, value in (inputs or {}).items():
            socket = node.inputs[name]
            if isinstance(value, bpy.types.NodeSocket):
                self.tree.links.new(value, socket)
            elif socket.type == "RGBA":
                socket.default_value = (*value, 1.0)
            else:
                socket.default_value = value
        return node

    def coordinates(self, which: str):
        return self.add("ShaderNodeTexCoord").outputs[which]

    def noise(self, output: str = "Color", scale: float = 3.0, **inputs):
        return self.add("ShaderNodeTexNoise", {"Scale": scale, **inputs}).outputs[output]

    def bump(self, inputs: dict, **properties):
        """A Bump node that looks a pixel to its sides, as all did before Blender 5."""
        node = self.add("ShaderNodeBump", inputs, **properties)
        if "Filter Width" in node.inputs:
            node.inputs["Filter Width"].default_value = 1.0
        return node

    def finish(self, shader):
        """The material with this shader output at its surface."""
        self.tree.links.new(shader, self._output.inputs["Surface"])
        return self.material

    def emit(self, value):
        """The material that shows a value as it is."""
        return self.finish(self.add("ShaderNodeEmission", {"Color": value}).outputs[0])


def show(scene, material, floor_material=None):
    """Fills a scene; returns (floor, sphere)."""
    scene.render.resolution_x, scene.render.resolution_y = 48, 36
    scene.view_layers[0].pass_alpha_threshold = 0.0
    floor = add_plane(scene, "Floor", size=4.0)
    for name, corners in ("UVMap", [(0, 0), (1, 0), (1, 1), (0, 1)]), ("Second", [(0, 0), (0.5, 0), (0.3, 1), (0, 1)]):
        floor.data.uv_layers.new(name=name).data.foreach_set("uv", np.ravel(corners).astype(np.float32))
    colours = floor.data.color_attributes.new("Col", "BYTE_COLOR", "CORNER")
    colours.data.foreach_set("color", np.array([1, 0, 0, 0.5, 0, 1, 0, 1, 0, 0, 1, 1, 1, 1, 1, 0], dtype=np.float32))
    floor.data.materials.append(floor_material or material)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=0.6, location=(0, 0, 0.6))
    sphere = bpy.context.object
    bpy.ops.object.shade_smooth()
    heights = np.linspace(0, 1, len(sphere.data.vertices), dtype=np.float32)
    sphere.data.attributes.new("height", "FLOAT", "POINT").data.foreach_set("value", heights)
    sphere.data.materials.append(material)
    add_area_light(scene, location=(1.0, 0.5, 2.0), rotation=(0.2, 0.4, 0), size=1.0, color=(1.0, 0.9, 0.8))
    add_camera(scene, location=(0, -4, 2.5), rotation=(1.03, 0, 0))
    return floor, sphere


def assert_values_equal(scene, tolerance: float) -> None:
    """What materials emit, in every pixel away from edges; the light's rays do not matter. No notes."""
    ours, notes = colour(render_with_penumbra(scene, 16)), statistics.last_render["warnings"]
    cycles = render_with_cycles(scene, samples=1)
    inside = away_from_edges(cycles, margin=1)
    assert inside.sum() > 500 and notes == []
    np.testing.assert_allclose(ours[inside], colour(cycles)[inside], rtol=0, atol=tolerance)
