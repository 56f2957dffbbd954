# SPDX-License-Identifier: GPL-3.0-or-later
"""The report from the render panel: "Speed against Error..." asks for the folder to be made."""

import traceback
from pathlib import Path

import bpy
from bpy.props import IntProperty, StringProperty

from ..export import ExportError
from . import DEFAULT_PIXELS, write_report


class PENUMBRA_OT_report(bpy.types.Operator):
    bl_idname = "penumbra.report"
    bl_label = "Speed against Error"
    bl_description = (
        "Render this scene with many settings, with Cycles too, and write a page that compares time and error. Takes"
        " minutes, in which Blender does not answer; replaces the last render's picture"
    )

    filepath: StringProperty(name="Folder", description="The folder to be made", subtype="DIR_PATH")
    pixels: IntProperty(
        name="Pixels", description="The frame is scaled down to at most so many pixels", default=DEFAULT_PIXELS,
        min=1, soft_max=1920 * 1080,
    )  # fmt: skip

    def invoke(self, context, event):
        blend = Path(bpy.data.filepath) if bpy.data.filepath else Path.home() / "untitled"
        self.filepath = str(blend.with_name(f"{blend.stem}_speed_against_error"))
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        if not self.filepath:
            self.report({"ERROR"}, "Penumbra: no folder was given")
            return {"CANCELLED"}
        folder = Path(bpy.path.abspath(self.filepath))
        try:
            page = write_report(context.scene, context.view_layer, folder, self.pixels)
        except (ExportError, ValueError, RuntimeError, OSError) as error:  # texts that say what is wrong
            self.report({"ERROR"}, f"Penumbra: {str(error).strip().removeprefix('Error: ')}")
            return {"CANCELLED"}
        except MemoryError:
            self.report({"ERROR"}, "Penumbra: out of memory")
            return {"CANCELLED"}
        except Exception as error:
            traceback.print_exc()
            self.report({"ERROR"}, f"Penumbra: internal failure: {type(error).__name__}: {error}")
            return {"CANCELLED"}
        self.report({"INFO"}, f"Penumbra: {page}")
        return {"FINISHED"}


def register() -> None:
    bpy.utils.register_class(PENUMBRA_OT_report)


def unregister() -> None:
    bpy.utils.unregister_class(PENUMBRA_OT_report)
