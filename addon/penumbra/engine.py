# SPDX-License-Identifier: GPL-3.0-or-later
"""The render engine as Blender sees it: export, render, bring finished buckets back, say what was done.

Only `self.report({"ERROR"}, ...)` makes Blender fail: after an exception, `error_set` or a cancelled result it saves
whatever picture there is and a headless run exits with 0. So all of render() is wrapped.
"""

import traceback
from time import perf_counter

import bpy

from . import checkpoint, cryptomatte, native, passes, properties, statistics, viewport
from .export import ExportCancelled, ExportError, Kept, export_scene
from .export.camera import frame_size, render_region
from .export.motion import record as record_motion
from .notes import Notes

POLL_SECONDS = 0.05
STATUS_SECONDS = 0.5

debug_pixel: tuple[int, int] | None = None
"""A pixel of the full frame (origin bottom left) to be told about instead of rendering; for scripts."""


class PenumbraRenderEngine(bpy.types.RenderEngine):
    bl_idname = "PENUMBRA"
    bl_label = "Penumbra"
    bl_use_preview = True  # of materials, lights and worlds
    bl_use_eevee_viewport = True  # the shading "Material Preview" is EEVEE's
    bl_use_shading_nodes_custom = False  # offer Blender's own shader nodes in the node editor

    def update_render_passes(self, scene=None, renderlayer=None):
        passes.register(self, scene, renderlayer)

    def view_update(self, context, depsgraph):
        """Called by Blender before the first view_draw and whenever something in the scene has changed."""
        viewport.of_engine(self).update(context, depsgraph)

    def view_draw(self, context, depsgraph):
        """Called by Blender whenever the view is drawn."""
        viewport.of_engine(self).draw(context, depsgraph)

    def render(self, depsgraph):
        """Renders one view layer; called by Blender once for each."""
        try:
            self.render_view_layer(depsgraph)
        except ExportCancelled:
            pass
        except (ExportError, ValueError, RuntimeError, OSError) as error:  # texts that name their object
            self.report({"ERROR"}, f"Penumbra: {error}")
        except MemoryError as error:
            self.report({"ERROR"}, f"Penumbra: out of memory: {error}")
        except Exception as error:
            traceback.print_exc()
            self.report({"ERROR"}, f"Penumbra: internal failure: {type(error).__name__}: {error}")

    def render_view_layer(self, depsgraph) -> None:
        """Everything from the evaluated scene to the pixels in Blender's render result; raises on any failure."""
        pn = native.require()
        scene, view_layer = depsgraph.scene_eval, depsgraph.view_layer_eval
        statistics_path = None if self.is_preview else statistics.file_path(scene, scene.frame_current)
        if statistics_path:
            statistics.check_writable(statistics_path)
        size, region = frame_size(scene), render_region(scene)
        self.check_region(region)
        notes = Notes(is_quiet=self.is_preview)

        start = perf_counter()
        self.update_stats("", "Exporting the scene")
        passes.note_missing(view_layer, notes)
        wanted = passes.native_settings(scene, view_layer)
        mattes: dict[str, set[str]] = {}
        kept = self.kept_meshes(pn, scene)
        motion = record_motion(self, depsgraph, notes, self.test_break)
        try:
            exported = export_scene(pn, depsgraph, self.camera_override, notes, self.test_break, kept=kept,
                                    passes=frozenset(wanted["passes"]), mattes=mattes, motion=motion)  # fmt: skip
        finally:
            if motion:
                motion.end()
        seconds = {"export": perf_counter() - start, "return": 0.0}

        self.update_stats("", "Building the ray tracing structure")
        settings = properties.native_settings(scene, size, region, wanted["passes"]) | wanted
        if self.is_preview:
            settings |= properties.PREVIEW
        if debug_pixel:
            print(pn.Render(exported, settings).debug_pixel(*debug_pixel), flush=True)
            return
        if not self.is_preview:
            settings["checkpoint"] = checkpoint.folder(scene, view_layer)
        render = pn.Render(exported, settings)
        passes.add_to_result(self, view_layer)
        cancelled = self.collect(render, view_layer, region, seconds)

        if self.is_preview:
            return
        found = render.statistics()
        for text in found["warnings"]:
            notes.add(text)
        self.publish(view_layer, statistics.of_view_layer(found, seconds, notes.texts, cancelled), statistics_path)
        for kind, matte_names in mattes.items():
            self.add_metadata(cryptomatte.metadata(view_layer.name, kind, matte_names))

    def kept_meshes(self, pn, scene) -> Kept | None:
        """What the frame before has left, if the scene wants data to persist: Blender keeps this instance then, and
        with it what is held here. Otherwise each frame ends with nothing left."""
        self.kept = getattr(self, "kept", None) or Kept(pn) if scene.render.use_persistent_data else None
        if self.kept:
            self.kept.begin()
        return self.kept

    def check_region(self, region: tuple[int, int, int, int]) -> None:
        """Raises RuntimeError if Blender's render result has another size than the border computed here."""
        probe = self.begin_result(0, 0, 2**20, 2**20)
        size = probe.resolution_x, probe.resolution_y
        self.end_result(probe, cancel=True)
        if size != region[2:]:
            raise RuntimeError(
                f"render border: Blender renders {size[0]} x {size[1]} pixels, expected {region[2]} x {region[3]}"
            )

    def collect(self, render, view_layer, region, seconds: dict[str, float]) -> bool:
        """Runs the render and writes each finished bucket, or all at once where nobody looks; True if the user
        cancelled it."""
        is_watched = not bpy.app.background
        cancelled = False
        began = told = perf_counter()
        render.start()
        try:
            while not render.done:
                buckets = render.wait(POLL_SECONDS)
                start = perf_counter()
                for bucket in buckets if is_watched else ():
                    passes.write_bucket(self, render, view_layer, bucket)
                seconds["return"] += perf_counter() - start
                self.update_progress(render.progress)
                if perf_counter() - told >= STATUS_SECONDS:  # a line in the log of a headless run
                    told = perf_counter()
                    line = statistics.progress_line(render.progress, render.estimated_error, told - began)
                    self.update_stats("", line)
                if not cancelled and self.test_break():
                    cancelled = True
                    render.cancel()
        except BaseException:
            render.cancel()
            raise
        finally:
            render.finish()
        if not is_watched:
            start = perf_counter()
            passes.write_bucket(self, render, view_layer, (0, 0, *region[2:]), is_all=True)
            seconds["return"] += perf_counter() - start
        return cancelled

    def publish(self, view_layer, layer_statistics: dict, path) -> None:
        """Adds a view layer's statistics to the frame's: panel, picture metadata, file."""
        layers = getattr(self, "layer_statistics", {})
        if view_layer.name in layers:  # of the frame before, where data persists
            layers = {}
        self.layer_statistics = layers = layers | {view_layer.name: layer_statistics}
        statistics.last_render = total = statistics.merge(layers)
        self.add_metadata(statistics.metadata(total))
        if path:
            statistics.write(path, total)

    def add_metadata(self, fields: dict[str, str]) -> None:
        """Writes into the picture's header. Only after end_result do fields reach it."""
        result = self.get_result()
        for name, text in fields.items():
            result.stamp_data_add_field(name, text)


def register() -> None:
    bpy.utils.register_class(PenumbraRenderEngine)


def unregister() -> None:
    bpy.utils.unregister_class(PenumbraRenderEngine)
