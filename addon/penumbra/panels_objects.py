# SPDX-License-Identifier: GPL-3.0-or-later
"""The panels of lights and objects: what Penumbra uses of them, in whichever version has it."""

import bpy

from .panel import PropertiesPanel

LIGHT_SHAPE = {
    "AREA": ("shape", "size"),
    "POINT": ("shadow_soft_size",),
    "SPOT": ("shadow_soft_size", "spot_size", "spot_blend"),
    "SUN": ("angle",),
}
"""The properties that give each type of light its shape."""

RAYS = (
    ("visible_camera", "Camera"),
    ("visible_diffuse", "Diffuse"),
    ("visible_glossy", "Glossy"),
    ("visible_shadow", "Shadow"),
)
"""The kinds of rays an object may be there for, as Blender names them."""


def output_node(tree):
    return tree.get_output_node("CYCLES") or tree.get_output_node("EEVEE")


class LightPanel(PropertiesPanel):
    bl_context = "data"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.light


class PENUMBRA_LIGHT_PT_light(LightPanel, bpy.types.Panel):
    bl_label = "Light"

    def draw(self, context):
        light = context.light
        self.layout.row().prop(light, "type", expand=True)
        column = self.column()
        for name in ("use_temperature", "temperature", "color", "energy", "exposure", "normalize"):
            switch = getattr(light, "use_temperature", False) if name == "temperature" else True
            if hasattr(light, name) and switch:  # Blender 4.5+ has more of them
                column.prop(light, name)


class PENUMBRA_LIGHT_PT_shape(LightPanel, bpy.types.Panel):
    bl_label = "Shape"
    bl_parent_id = "PENUMBRA_LIGHT_PT_light"

    def draw(self, context):
        light, column = context.light, self.column()
        for name in LIGHT_SHAPE[light.type]:
            column.prop(light, name)
        if light.type == "AREA":
            if light.shape in ("RECTANGLE", "ELLIPSE"):
                column.prop(light, "size_y", text="Y")
            column.prop(light, "spread")
        if hasattr(light, "use_soft_falloff") and light.type in ("POINT", "SPOT"):
            column.prop(light, "use_soft_falloff")
        column.prop(light, "use_shadow", text="Cast Shadow")


class PENUMBRA_LIGHT_PT_nodes(LightPanel, bpy.types.Panel):
    bl_label = "Nodes"
    bl_parent_id = "PENUMBRA_LIGHT_PT_light"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        light, column = context.light, self.column()
        column.prop(light, "use_nodes", toggle=True)
        output = light.use_nodes and light.node_tree and output_node(light.node_tree)
        if output:
            column.template_node_view(light.node_tree, output, output.inputs["Surface"])


class PENUMBRA_OBJECT_PT_rays(PropertiesPanel, bpy.types.Panel):
    """Rays of these kinds meet the object; of a light: where it shines and is seen."""

    bl_label = "Ray Visibility"
    bl_context = "object"
    bl_parent_id = "OBJECT_PT_visibility"

    @classmethod
    def poll(cls, context):
        shines = context.object and context.object.type in {"MESH", "CURVE", "SURFACE", "FONT", "META", "LIGHT"}
        return super().poll(context) and shines

    def draw(self, context):
        column = self.column()
        for name, text in RAYS:
            column.prop(context.object, name, text=text)


CLASSES = (
    PENUMBRA_LIGHT_PT_light, PENUMBRA_LIGHT_PT_shape, PENUMBRA_LIGHT_PT_nodes, PENUMBRA_OBJECT_PT_rays,
)  # fmt: skip
