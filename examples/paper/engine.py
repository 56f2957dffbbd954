# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders with the engine, in Blender: a Blender scene exported once and rendered often, or Blender's own F12."""

import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import bpy
import numpy as np
import penumbra_addon

penumbra = penumbra_addon.load()
pn = penumbra.native.require()
PASSES = ("Combined", "Depth", "Normal", "Position", "Light Samples", "Error Estimate")


class Picture(NamedTuple):
    """A finished render. Arrays are (height, width, channels) float32, bottom row first."""

    passes: dict[str, np.ndarray]
    statistics: dict
    exposure: float
    seconds: float
    """CPU seconds of all threads, which other work on the machine disturbs less than the clock's"""

    @property
    def display(self) -> np.ndarray:
        """(height, width, 3) float64 in display units, 1 is white."""
        return self.passes["Combined"][..., :3].astype(np.float64) * 2.0**self.exposure

    @property
    def light_rays(self) -> int:
        """Rays to the luminaire that its stop rule asked for, one by one; those a packet traced beyond are left out."""
        return self.statistics["shadow_rays"] - self.statistics["shadow_rays_beyond_stop"]

    @property
    def rays(self) -> int:
        """All rays, counted as the paper does: those from the eye and those to the luminaire."""
        return self.statistics["primary_rays"] + self.light_rays


class ExportedScene:
    """Blender's scene as the add-on exports it for a render."""

    def __init__(self, scene) -> None:
        bpy.context.view_layer.update()
        depsgraph = bpy.context.evaluated_depsgraph_get()
        notes = penumbra.notes.Notes()
        self.native = penumbra.export.export_scene(pn, depsgraph, None, notes)
        if notes.texts:
            raise RuntimeError("the paper's scenes must be rendered as they are: " + "; ".join(notes.texts))
        self.size = penumbra.export.camera.frame_size(scene)
        self.exposure = scene.view_settings.exposure

    def render(self, passes=("Combined",), **settings) -> Picture:
        """Renders with these settings of scene.penumbra; one primary ray a pixel unless they say otherwise."""
        width, height = self.size
        chosen = {"width": width, "height": height, "pixel_samples": 1, "exposure": self.exposure} | settings
        render = pn.Render(self.native, chosen | {"passes": list(passes)})
        begin = time.process_time()
        render.start()
        render.finish()
        return Picture(render.passes(), render.statistics(), self.exposure, time.process_time() - begin)

    def look_at_point(self, point) -> None:
        """From now on the picture is one pixel that sees this point of a horizontal floor from just above it."""
        camera = np.eye(4)
        camera[:3, 3] = np.asarray(point, float) + (0.0, 0.0, 1e-3)
        self.native.set_camera("ORTHOGRAPHIC", camera, (-1e-3, 1e-3, -1e-3, 1e-3), (1e-6, 1.0))
        self.size = (1, 1)

    def value_at_point(self, **settings) -> float:
        """The one pixel's green value in display units. Its PRS stream starts where the generator does, so that
        renders with more and more points draw one growing sequence."""
        picture = self.render(stop_rule="FIXED", threads=1, **settings)
        return float(picture.passes["Combined"][0, 0, 1]) * 2.0**self.exposure


def render_in_blender(scene) -> np.ndarray:
    """What Blender's own render of the scene delivers, in display units: (height, width, 3), bottom row first."""
    image = scene.render.image_settings
    penumbra.compat.set_file_format(image, "OPEN_EXR")
    image.color_depth, image.color_mode = "32", "RGBA"
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath, scene.render.use_file_extension = str(Path(folder) / "picture.exr"), False
        bpy.ops.render.render(write_still=True, scene=scene.name)
        loaded = bpy.data.images.load(scene.render.filepath)
        pixels = np.empty(len(loaded.pixels), dtype=np.float32)
        loaded.pixels.foreach_get(pixels)
        bpy.data.images.remove(loaded)
    width, height = penumbra.export.camera.frame_size(scene)
    return pixels.reshape(height, width, 4)[..., :3].astype(np.float64) * 2.0**scene.view_settings.exposure
