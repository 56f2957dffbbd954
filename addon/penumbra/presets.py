# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets of the settings through Blender's own preset system: Draft, Good, Final and Paper come with the add-on
(preset_files/), and users add theirs with + in the menu, which go to their own folder presets/penumbra.

In Python: `bpy.ops.script.execute_preset(filepath=FILE, menu_idname="PENUMBRA_PT_presets")`, or run the file.
"""

from pathlib import Path

import bpy
from bl_operators.presets import AddPresetBase
from bl_ui.utils import PresetPanel

FOLDER = Path(__file__).parent / "preset_files"
VALUES = (
    "stop_rule", "error_tolerance", "sampler", "sample_reuse", "light_samples", "max_light_samples", "check_interval",
    "pixel_samples", "max_pixel_samples",
)  # fmt: skip
"""The settings that a preset has: all that trades time for quality."""


class PENUMBRA_PT_presets(PresetPanel, bpy.types.Panel):
    bl_label = "Penumbra Presets"
    preset_subdir = "penumbra"
    preset_operator = "script.execute_preset"
    preset_add_operator = "render.penumbra_preset_add"
    COMPAT_ENGINES = {"PENUMBRA"}

    def path_menu(self, searchpaths, *arguments, **named):
        """Blender's, with the add-on's own presets first."""
        bpy.types.Menu.path_menu(self, [str(FOLDER), *searchpaths], *arguments, **named)

    @staticmethod
    def post_cb(context, filepath=""):
        """Called after a preset was run: has views drawn again, which settings of add-ons alone do not."""
        context.scene.update_tag()


class PENUMBRA_OT_preset_add(AddPresetBase, bpy.types.Operator):
    """Add the present settings as a preset, or remove one of your own"""

    bl_idname = "render.penumbra_preset_add"
    bl_label = "Add Penumbra Preset"
    preset_menu = "PENUMBRA_PT_presets"
    preset_subdir = "penumbra"
    # In full: Blender executes and evaluates these in a function, where Python 3.13 keeps no new names between the two.
    preset_values = [f"bpy.context.scene.penumbra.{name}" for name in VALUES]


CLASSES = (PENUMBRA_PT_presets, PENUMBRA_OT_preset_add)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
