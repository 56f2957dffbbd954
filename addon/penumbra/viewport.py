# SPDX-License-Identifier: GPL-3.0-or-later
"""The 3D view in rendered shading: what changed, what to render next, and the picture there is so far.

Blender's main thread exports and draws; a thread of its own renders (progressive.py), and a timer asks it for news.
A failure is shown in the view's corner and not tried again before the next change.
"""

import functools
import traceback
import weakref
from time import perf_counter

import bpy

from . import native, properties, statistics
from .export import ExportError, Kept, export_scene, is_shown
from .export.kept import changes_in
from .export.view import View, view_of
from .notes import Notes
from .progressive import STEPS, Refinement, Refiner

POLL_SECONDS = 0.02
REDRAW_SECONDS = 0.1
"""Between two drawings of one growing picture; drawing costs the renderer some time of a CPU."""
COARSE = 4
"""The first picture has 1 / COARSE of the pixels in each direction."""

viewports: "weakref.WeakSet[Viewport]" = weakref.WeakSet()
"""Those alive, for scripts."""


def of_engine(engine) -> "Viewport":
    """The viewport of a render engine's instance, which Blender keeps for as long as the view is shaded with it."""
    if getattr(engine, "viewport", None) is None:
        engine.viewport = Viewport(engine)
    return engine.viewport


def inventory(depsgraph, space) -> tuple:
    """What is in the scene, though not what it looks like: of these changes the depsgraph tells no details."""
    scene, override = depsgraph.scene, depsgraph.view_layer.material_override
    shown = tuple(instance.object.original.as_pointer() for instance in depsgraph.object_instances
                  if is_shown(instance, space) and instance.object.type != "CAMERA")  # fmt: skip
    return scene.render.film_transparent, scene.world, override, shown


class Viewport:
    """One 3D view: its copy of the scene, its picture and its figures."""

    def __init__(self, engine) -> None:
        self._engine = weakref.ref(engine)
        self._refiner = Refiner()
        weakref.finalize(self, self._refiner.close)
        self._notes = Notes()
        self._scene, self._inventory, self._kept = None, (), None
        self._wanted: tuple[int, View, dict] | None = None
        self._texture, self._shown, self._border = None, None, (0, 0, 0, 0)
        self._exported_since, self._drawn_at = 0.0, 0.0
        self._poll = functools.partial(_poll, weakref.ref(self))
        self.exports = 0
        """How often the scene was exported"""
        self.failure = ""
        viewports.add(self)

    @property
    def refinement(self) -> Refinement | None:
        """The running or last one."""
        return self._refiner.current

    def shows(self, refinement: Refinement) -> bool:
        """Whether a picture of it was drawn."""
        return self._shown is not None and self._shown[0] is refinement

    @property
    def is_drawn(self) -> bool:
        """Whether the last drawing was of all that is rendered so far."""
        now = self.refinement
        return now is not None and self._shown == (now, now.changes)

    def update(self, context, depsgraph) -> None:
        """Exports the scene if that is needed, and has the view drawn, which settings alone would not do."""
        with_failures_shown(self, self._update, context.space_data, depsgraph)
        self._engine().tag_redraw()

    def draw(self, context, depsgraph) -> None:
        """Renders on if the view has changed, and draws the best picture there is."""
        with_failures_shown(self, self._refine, context, depsgraph)
        with_failures_shown(self, self._draw, depsgraph.scene)

    @property
    def meshes_read(self) -> int:
        """How many meshes were read from Blender so far"""
        return self._kept.meshes_read if self._kept else 0

    def _update(self, space, depsgraph) -> None:
        since, pn = perf_counter(), native.require()
        found, changes = inventory(depsgraph, space), changes_in(depsgraph)
        is_another = found != self._inventory  # objects that came may have the addresses of others that went
        if self._scene is not None and not is_another and not changes.content:
            return
        self._refiner.cancel()
        self._exported_since = since
        self._scene, self._inventory = None, found
        self._kept = self._kept or Kept(pn)
        self._kept.begin(changes._replace(geometry=changes.geometry or is_another))
        self._scene = export_scene(pn, depsgraph, None, self._notes, space=space, kept=self._kept)
        self.exports += 1
        self.failure = ""

    def _refine(self, context, depsgraph) -> None:
        """Starts anew where view, settings or scene are others. A first picture that is on its way to a view may
        arrive before that: else a view that moves all the time would never be seen."""
        if self._scene is None:
            return
        view = view_of(context.space_data, context.region, context.region_data, depsgraph.scene)
        settings = properties.native_settings(depsgraph.scene, view.size, view.border, ["Combined"])
        wanted, now = (self.exports, view, settings), self.refinement
        is_awaited = now is not None and not now.done and now.pixels is None and self._wanted[0] == self.exports
        if wanted != self._wanted and not is_awaited:
            is_exported = self._wanted is None or self._wanted[0] != self.exports
            since = self._exported_since if is_exported else perf_counter()
            self._wanted, self.failure = wanted, ""
            self._refiner.start(Refinement(native.require(), self._scene, view.camera, settings, COARSE, since))
        if not bpy.app.timers.is_registered(self._poll):
            bpy.app.timers.register(self._poll)

    def _draw(self, scene) -> None:
        import gpu  # not there without a window
        from gpu_extras.presets import draw_texture_2d

        now = self.refinement
        if now is not None and (now.done or now.pixels is not None) and not self.is_drawn:
            self._shown = (now, now.changes)
            if now.pixels is not None:  # else the last picture stays
                self._border = self._wanted[1].border
                height, width = now.pixels.shape[:2]
                buffer = gpu.types.Buffer("FLOAT", width * height * 4, now.pixels.reshape(-1))
                self._texture = gpu.types.GPUTexture((width, height), format="RGBA16F", data=buffer)
        self._drawn_at = perf_counter()
        if self._texture is None:
            return
        engine = self._engine()
        x, y, width, height = self._border
        gpu.state.blend_set("ALPHA_PREMULT")
        engine.bind_display_space_shader(scene)
        draw_texture_2d(self._texture, (x, y), width, height)
        engine.unbind_display_space_shader()
        gpu.state.blend_set("NONE")

    def look_for_news(self) -> float | None:
        """Has the view drawn again if its picture has changed; seconds until this is worth asking again, or None."""
        engine, now = self._engine(), self.refinement
        if engine is None or now is None:
            return None
        is_over, is_new = now.done, not self.is_drawn
        is_first = not self.shows(now)
        if is_new and (is_over or is_first or perf_counter() - self._drawn_at >= REDRAW_SECONDS):
            self.show_status()
            engine.tag_redraw()
        return None if is_over else POLL_SECONDS

    @property
    def status(self) -> str:
        """How far the picture is, in words."""
        now = self.refinement
        if now is None:
            return ""
        done = statistics.progress_line(now.progress, now.error_estimate, now.seconds)
        return f"Picture {max(now.step, 1)} of {STEPS}: {done}"

    def show_status(self) -> None:
        """The line in the view's corner."""
        engine, now = self._engine(), self.refinement
        failure = self.failure or (now.failure if now else "")
        if failure:
            engine.update_stats("", f"Penumbra: {failure}")
            return
        notes = self._notes.texts
        engine.update_stats(f"Notes: {len(notes)}, the last: {notes[-1]}" if notes else "", self.status)


def _poll(reference) -> float | None:
    """Called by Blender's timer; does not keep the viewport alive."""
    viewport = reference()
    return viewport.look_for_news() if viewport is not None else None


def with_failures_shown(viewport: Viewport, step, *arguments) -> None:
    """Runs a step of drawing. Blender would print a trace at each drawing, and show nothing."""
    try:
        step(*arguments)
    except Exception as error:
        text = str(error) or type(error).__name__
        if text != viewport.failure:
            if not isinstance(error, ExportError | ValueError | RuntimeError | OSError | MemoryError):
                traceback.print_exc()
            print(f"Penumbra note: viewport: {text}", flush=True)
        viewport.failure = text
        viewport.show_status()
