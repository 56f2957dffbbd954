# SPDX-License-Identifier: GPL-3.0-or-later
"""The panels of view layers: data passes, passes of light, Cryptomatte, light groups."""

import bpy

from . import compat
from .panel import PropertiesPanel

DATA_PASSES = (
    "use_pass_z", "use_pass_mist", "use_pass_position", "use_pass_normal", "use_pass_uv", "use_pass_object_index",
    "use_pass_material_index",
)  # fmt: skip
LIGHT_PASSES = {
    "Diffuse": {"use_pass_diffuse_direct": "Direct", "use_pass_diffuse_color": "Color"},
    "Glossy": {
        "use_pass_glossy_direct": "Direct", "use_pass_glossy_indirect": "Mirrored", "use_pass_glossy_color": "Color",
    },
    "": {"use_pass_emit": "Emission", "use_pass_environment": "Environment", "use_pass_shadow": "Shadow"},
}  # fmt: skip
"""By row: the view layer's switches and what they are called there."""


class PENUMBRA_VIEWLAYER_PT_passes(PropertiesPanel, bpy.types.Panel):
    bl_label = "Passes"
    bl_context = "view_layer"

    def draw(self, context):
        layer, column = context.view_layer, self.column()
        for name in DATA_PASSES:
            column.prop(layer, name)
        for name in ("use_pass_light_samples", "use_pass_error_estimate"):
            column.prop(layer.penumbra, name)


class PENUMBRA_VIEWLAYER_PT_light_passes(PropertiesPanel, bpy.types.Panel):
    bl_label = "Light"
    bl_context = "view_layer"
    bl_parent_id = "PENUMBRA_VIEWLAYER_PT_passes"

    def draw(self, context):
        layer, column = context.view_layer, self.column()
        for heading, names in LIGHT_PASSES.items():
            row = column.row(heading=heading, align=True)
            for name, text in names.items():
                row.prop(layer, name, text=text, toggle=bool(heading))


class PENUMBRA_VIEWLAYER_PT_cryptomatte(PropertiesPanel, compat.view_layer_panel("Cryptomatte"), bpy.types.Panel):
    bl_context = "view_layer"
    bl_parent_id = "PENUMBRA_VIEWLAYER_PT_passes"


class PENUMBRA_VIEWLAYER_PT_lightgroups(PropertiesPanel, compat.view_layer_panel("Lightgroups"), bpy.types.Panel):
    bl_context = "view_layer"
    bl_parent_id = "PENUMBRA_VIEWLAYER_PT_passes"


CLASSES = (
    PENUMBRA_VIEWLAYER_PT_passes,
    PENUMBRA_VIEWLAYER_PT_light_passes,
    PENUMBRA_VIEWLAYER_PT_cryptomatte,
    PENUMBRA_VIEWLAYER_PT_lightgroups,
)
