# SPDX-License-Identifier: GPL-3.0-or-later
"""The panels: settings, passes, the last render's statistics and notes, the add-on's preferences."""

import textwrap

import bpy

from . import native, panels_objects, panels_passes, statistics
from .panel import PropertiesPanel
from .presets import PENUMBRA_PT_presets

BLENDER_PANELS = (
    "MATERIAL_PT_preview",
    "EEVEE_MATERIAL_PT_context_material",
    "EEVEE_MATERIAL_PT_surface",
    "EEVEE_WORLD_PT_surface",
    "DATA_PT_preview",
    "DATA_PT_camera_dof",
    "DATA_PT_camera_dof_aperture",
)
"""Blender's own panels that are of use here but do not list the classic engine."""

NOT_FOR_US = (
    "DATA_PT_light",
    "DATA_PT_area",
    "DATA_PT_spot",
    "DATA_PT_falloff_curve",
    "RENDER_PT_freestyle",
    "RENDER_PT_gpencil",
    "RENDER_PT_stereoscopy",
    "RENDER_PT_output_views",
)
"""Panels that list the classic engine, but show what Penumbra does not do, or shows in a panel of its own."""


NOTE_WIDTH = 60
"""Letters that fit into a panel's line."""


def show_native_failure(layout) -> None:
    """One sentence, if the native module is missing."""
    if native.reason:
        box = layout.box()
        box.alert = True
        for line, part in enumerate(textwrap.wrap(native.reason, NOTE_WIDTH)):
            box.label(text=part, icon="NONE" if line else "ERROR")


class PenumbraPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    def draw(self, context):
        if native.module is None:
            show_native_failure(self.layout)
        else:
            self.layout.label(text=f"Native renderer {native.module.__version__}, {native.module.isa}")
            self.layout.label(text=native.module.build)


class PENUMBRA_RENDER_PT_error(PropertiesPanel, bpy.types.Panel):
    bl_label = "Error"

    def draw_header_preset(self, context):
        PENUMBRA_PT_presets.draw_panel_header(self.layout)

    def draw(self, context):
        show_native_failure(self.layout)
        settings, column = context.scene.penumbra, self.column()
        column.prop(settings, "stop_rule")
        if settings.stop_rule == "FIXED":
            column.prop(settings, "light_samples")
        else:
            column.prop(settings, "error_tolerance")
            column.prop(settings, "max_light_samples")
        if settings.stop_rule == "PAPER":
            column.prop(settings, "check_interval")


class PENUMBRA_RENDER_PT_sampling(PropertiesPanel, bpy.types.Panel):
    bl_label = "Sampling"

    def draw(self, context):
        settings, column = context.scene.penumbra, self.column()
        column.prop(settings, "sampler")
        row = column.row()
        row.active = settings.sampler not in {"PRS", "SPRS"}
        row.prop(settings, "sample_reuse")
        column.prop(settings, "seed")


class PENUMBRA_RENDER_PT_pixels(PropertiesPanel, bpy.types.Panel):
    bl_label = "Antialiasing"
    bl_parent_id = "PENUMBRA_RENDER_PT_sampling"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        settings, column = context.scene.penumbra, self.column()
        column.prop(settings, "pixel_samples")
        column = column.column()
        column.active = settings.pixel_samples > 1
        if settings.stop_rule == "BOUNDED":
            column.prop(settings, "max_pixel_samples")
        column.prop(settings, "filter_type")
        column.prop(settings, "filter_width")


class PENUMBRA_RENDER_PT_paths(PropertiesPanel, bpy.types.Panel):
    bl_label = "Light Paths"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        self.column().prop(context.scene.penumbra, "mirror_depth")


class PENUMBRA_RENDER_PT_film(PropertiesPanel, bpy.types.Panel):
    bl_label = "Film"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        self.column().prop(context.scene.render, "film_transparent", text="Transparent")


class PENUMBRA_RENDER_PT_performance(PropertiesPanel, bpy.types.Panel):
    bl_label = "Performance"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        render, column = context.scene.render, self.column()
        column.prop(render, "threads_mode")
        row = column.row()
        row.active = render.threads_mode == "FIXED"
        row.prop(render, "threads")
        column.prop(context.scene.penumbra, "memory_limit")


class PENUMBRA_RENDER_PT_final(PropertiesPanel, bpy.types.Panel):
    bl_label = "Final Render"
    bl_parent_id = "PENUMBRA_RENDER_PT_performance"

    def draw(self, context):
        column = self.column()
        column.prop(context.scene.render, "use_persistent_data", text="Persistent Data")
        column.prop(context.scene.penumbra, "checkpoint_folder")


class PENUMBRA_RENDER_PT_info(PropertiesPanel, bpy.types.Panel):
    """What the last final render did, and what it left out."""

    bl_label = "Info"

    def draw(self, context):
        layout = self.layout.column(align=True)
        last = statistics.last_render
        if last is None:
            layout.label(text="Nothing rendered yet")
            return
        for name, text in statistics.summary(last):
            row = layout.split(factor=0.3)
            row.label(text=name)
            row.label(text=text)


class PENUMBRA_RENDER_PT_notes(PropertiesPanel, bpy.types.Panel):
    bl_label = "Notes"
    bl_parent_id = "PENUMBRA_RENDER_PT_info"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and statistics.last_render is not None and statistics.last_render["warnings"]

    def draw(self, context):
        column = self.layout.column(align=True)
        for text in statistics.last_render["warnings"]:
            for line, part in enumerate(textwrap.wrap(text, NOTE_WIDTH)):
                column.label(text=part, icon="BLANK1" if line else "INFO")


class PENUMBRA_RENDER_PT_report(PropertiesPanel, bpy.types.Panel):
    bl_label = "Report"
    bl_parent_id = "PENUMBRA_RENDER_PT_info"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        column = self.column()
        column.prop(context.scene.penumbra, "statistics_file")
        column.operator("penumbra.report", text="Speed against Error...", icon="GRAPH")


CLASSES = (
    PenumbraPreferences,
    PENUMBRA_RENDER_PT_error,
    PENUMBRA_RENDER_PT_sampling,
    PENUMBRA_RENDER_PT_pixels,
    PENUMBRA_RENDER_PT_paths,
    PENUMBRA_RENDER_PT_film,
    PENUMBRA_RENDER_PT_performance,
    PENUMBRA_RENDER_PT_final,
    PENUMBRA_RENDER_PT_info,
    PENUMBRA_RENDER_PT_notes,
    PENUMBRA_RENDER_PT_report,
    *panels_passes.CLASSES,
    *panels_objects.CLASSES,
)


def blender_panels():
    """Blender's panels that should be shown for this engine, too."""
    for panel in bpy.types.Panel.__subclasses__():
        engines = getattr(panel, "COMPAT_ENGINES", ())
        name = panel.__name__.removeprefix("NODE_")  # the node editor's twin, with the very same set of engines
        named = panel.__name__ in BLENDER_PANELS
        if named or ("BLENDER_RENDER" in engines and name not in NOT_FOR_US):
            yield panel


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    for panel in blender_panels():
        panel.COMPAT_ENGINES.add("PENUMBRA")


def unregister() -> None:
    for panel in blender_panels():
        panel.COMPAT_ENGINES.discard("PENUMBRA")
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
