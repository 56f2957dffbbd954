# SPDX-License-Identifier: GPL-3.0-or-later
"""Penumbra's part: the scene is exported once, inside a final render; then the reference and all runs."""

import os
import platform
from time import perf_counter, process_time

import bpy
import numpy as np

from .. import properties
from ..export import ExportCancelled, export_scene
from ..export.camera import frame_size, render_region
from ..notes import Notes
from . import final_render, plan, reference
from .measure import figures, pixel_errors
from .study import Cancelled, Study, fastest, say

POLL_SECONDS = 0.05
PASSES = ["Combined", "Light Samples"]


def study(pn, scene) -> Study:
    """Measures all of Penumbra's runs of a scene; RuntimeError, ValueError or ExportError with a sentence."""
    return final_render.inside(scene, lambda engine, depsgraph: _Runs(pn, engine, depsgraph).study())


class _Runs:
    def __init__(self, pn, engine, depsgraph) -> None:
        self.pn, self.engine, self.scene = pn, engine, depsgraph.scene_eval
        size, region = frame_size(self.scene), render_region(self.scene)
        self.own = properties.native_settings(self.scene, size, region, PASSES)
        self.notes = Notes()
        wall, cpu = perf_counter(), process_time()
        try:
            self.exported = export_scene(pn, depsgraph, None, self.notes, engine.test_break)
        except ExportCancelled:
            raise Cancelled from None
        pn.Render(self.exported, self.own)  # refuses the user's settings now, and builds the ray tracing structure
        self.preparation = perf_counter() - wall, process_time() - cpu

    def render(self, settings: dict) -> tuple[dict[str, np.ndarray], dict]:
        """(passes, statistics) of one render; Cancelled if the user wants no more."""
        render = self.pn.Render(self.exported, settings)
        render.start()
        try:
            while not render.done:
                render.wait(POLL_SECONDS)
                if self.engine.test_break():
                    raise Cancelled
        except BaseException:
            render.cancel()
            raise
        finally:
            render.finish()
        return render.passes(), render.statistics()

    def study(self) -> Study:
        wanted = plan.tolerances(self.own["error_tolerance"])
        self.engine.update_stats("", "Speed against error: reference")
        found = reference.converge(self.render, self.own, wanted[-1])
        shown = [tolerance for tolerance in wanted if tolerance >= reference.SMALLER * found.error_p99]
        if not shown:
            raise RuntimeError(
                f"report: the reference's own error, {found.error_p99:.2g}, is too large for these tolerances"
                f" ({wanted[0]:g} ... {wanted[-1]:g}): raise error_tolerance or render fewer pixels"
            )
        result = Study(self.own, 2.0 ** self.own["exposure"], found, [])
        if len(shown) < len(wanted):
            self.notes.add("report: the reference is not good enough for the tolerances "
                           f"{', '.join(f'{t:g}' for t in wanted if t not in shown)}: they are left out")  # fmt: skip
        runs = plan.runs(self.own, shown)
        say(f"{len(runs)} runs of Penumbra")
        for number, run in enumerate(runs):
            self.engine.update_stats("", f"Speed against error: {run.family}, {run.setting}")
            self.engine.update_progress(number / len(runs))
            (passes, statistics), wall, cpu = fastest(lambda run=run: self.render(run.settings))
            errors = pixel_errors(passes["Combined"][..., :3], found.colour, result.display_scale)
            seconds = {"seconds": self.preparation[0] + wall, "cpu_seconds": self.preparation[1] + cpu}
            row = row_of(run, statistics) | figures(errors, run.tolerance) | seconds
            result.add(row, errors, passes["Light Samples"][..., 0])
            result.has_mirrors |= statistics["mirror_rays"] > 0
        result.facts, result.notes = facts(self.scene, self.own, statistics), self.notes.texts
        return result


def row_of(run: plan.Run, statistics: dict) -> dict:
    """The columns that come from a run's settings and from the renderer's own counts."""
    counts = {
        name: statistics[name]
        for name in ("primary_rays", "mirror_rays", "shadow_rays", "light_points", "pixels_at_sample_limit")
    }
    settings = {name: run.settings[name] for name in (*plan.SETTINGS_OF_A_RUN, "seed")}
    return {
        "renderer": "Penumbra",
        "family": run.family,
        "setting": run.setting,
        "own_settings": run.is_own,
        **settings,
        "rays": counts["primary_rays"] + counts["mirror_rays"] + counts["shadow_rays"],
        **counts,
        "points_without_ray": statistics["points_without_ray"],
    }


def facts(scene, own: dict, statistics: dict) -> list[tuple[str, str]]:
    """What the reader needs to know of the scene and the machine."""
    _, _, width, height = own["region"]
    threads = own["threads"] or os.cpu_count()
    sampling = f"{own['pixel_samples']} primary rays a pixel" if own["pixel_samples"] > 1 else "one centre ray a pixel"
    return [
        ("File", os.path.basename(bpy.data.filepath) or "not saved"),
        ("Picture", f"scene {scene.name!r}, frame {scene.frame_current}, {width} x {height} pixels, {sampling}"),
        ("Scene", ", ".join(f"{statistics[name]:,} {name}" for name in ("triangles", "instances", "luminaires"))),
        ("Exposure", f"{own['exposure']:g} stops"),
        ("Machine", f"{platform.machine()}, {threads} threads, {statistics['isa']}"),
        ("Versions", f"Penumbra {statistics['version']} ({statistics['build']}), Blender {bpy.app.version_string}"),
    ]
