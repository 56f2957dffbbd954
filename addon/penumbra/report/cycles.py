# SPDX-License-Identifier: GPL-3.0-or-later
"""Cycles' part: the same scene with Cycles on the CPU, direct light only, over a range of samples.

Each renderer is measured against its own truth, since pictures may differ for other reasons than noise (edges, and
materials and lights that Penumbra approximates or leaves out). Cycles' truth is the mean of two pictures of the most
samples; these two are measured against each other, their difference divided by sqrt(2).
"""

import tempfile
from pathlib import Path

import bpy
import numpy as np

from .. import compat
from .changes import Changes
from .measure import figures, pixel_errors, weighted
from .study import Cancelled, Study, fastest

SAMPLES = (16, 64, 256)
"""The truth from two pictures of 256 samples makes the error of 64 appear at most 6 % too large (sqrt(1 + 1 / 8))."""

CENTRE_RAY = {"pixel_filter_type": "GAUSSIAN", "filter_width": 0.01}


def is_enabled(scene) -> bool:
    """Whether this Blender has Cycles and the add-on is switched on."""
    return hasattr(scene, "cycles") and any(
        getattr(engine, "bl_idname", "") == "CYCLES" for engine in bpy.types.RenderEngine.__subclasses__()
    )


def set_up(scene, changes: Changes, own: dict, has_mirrors: bool) -> None:
    """Cycles as it may be compared with: what it does beyond Penumbra, and all that trades error for speed, is off."""
    bounces = own["mirror_depth"] if has_mirrors else 0
    filtered = {"pixel_filter_type": own["filter_type"], "filter_width": own["filter_width"]}
    cycles = {
        "device": "CPU", "max_bounces": bounces, "glossy_bounces": bounces, "diffuse_bounces": 0,
        "transmission_bounces": 0, "volume_bounces": 0, "min_light_bounces": 0, "light_sampling_threshold": 0.0,
        "blur_glossy": 0.0, "sample_clamp_direct": 0.0, "sample_clamp_indirect": 0.0, "use_denoising": False,
        "use_adaptive_sampling": False, "use_fast_gi": False, "use_guiding": False, "use_animated_seed": False,
        "time_limit": 0.0, "film_exposure": 1.0, "sample_offset": 0,
        **(filtered if own["pixel_samples"] > 1 else CENTRE_RAY),
    }  # fmt: skip
    for name, value in cycles.items():
        changes.set(scene.cycles, name, value)
    changes.keep(scene.cycles, "samples", "seed")
    if own["pixel_samples"] == 1:
        changes.set(scene.render, "use_motion_blur", False)
        changes.set(scene.camera.data.dof, "use_dof", False)
    for scene_object in bpy.data.objects:
        for owner in (scene_object, getattr(scene_object, "cycles", None)):
            for name in ("offset", "normal_offset", "shading_offset", "geometry_offset"):
                changes.set(owner, f"shadow_terminator_{name}", 0.0)


def render(scene) -> None:
    """One final render; Cancelled if the user pressed Esc or Ctrl-C."""
    cancelled = []

    def note(*_) -> None:
        cancelled.append(True)

    bpy.app.handlers.render_cancel.append(note)
    try:
        bpy.ops.render.render(scene=scene.name)
    finally:
        bpy.app.handlers.render_cancel.remove(note)
    if cancelled:
        raise Cancelled


def last_picture(scene) -> np.ndarray:
    """(H, W, 3) float32 scene-linear colour of the last render, row 0 = bottom, by way of an EXR file."""
    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder) / "picture.exr")
        bpy.data.images["Render Result"].save_render(path, scene=scene)
        image = bpy.data.images.load(path)
        try:
            image.colorspace_settings.name = "Non-Color"
            width, height = image.size
            pixels = np.empty(width * height * image.channels, np.float32)
            image.pixels.foreach_get(pixels)
            return pixels.reshape(height, width, -1)[..., :3]
        finally:
            bpy.data.images.remove(image)


def add_to(study: Study, scene) -> None:
    """Renders all runs of Cycles and adds them to the study."""
    with Changes() as changes:
        changes.keep(scene.render, "engine")
        image = scene.render.image_settings
        changes.keep(image, "media_type", "file_format", "color_mode", "color_depth", "exr_codec", "color_management")
        set_up(scene, changes, study.own, study.has_mirrors)
        scene.render.engine = "CYCLES"
        compat.set_file_format(image, "OPEN_EXR")
        image.color_mode, image.color_depth, image.exr_codec = "RGBA", "32", "NONE"
        pictures = []
        for seed, samples in enumerate((*SAMPLES, SAMPLES[-1])):
            scene.cycles.samples, scene.cycles.seed = samples, seed
            _, seconds, cpu_seconds = fastest(lambda: render(scene))
            pictures.append((samples, last_picture(scene).astype(np.float64), seconds, cpu_seconds))
    measure(study, pictures)


def measure(study: Study, pictures: list[tuple[int, np.ndarray, float, float]]) -> None:
    """Adds a row for each number of samples; the last two pictures have the same."""
    *_, (_, first, *_), (_, second, *_) = pictures
    truth = (first + second) / 2
    if truth.shape != study.reference.colour.shape:
        raise RuntimeError(f"report: Cycles rendered {truth.shape[1]} x {truth.shape[0]} pixels, Penumbra did not")
    tolerance, scale = study.own["error_tolerance"], study.display_scale
    for samples, picture, seconds, cpu_seconds in pictures[:-1]:
        errors = pixel_errors(picture, truth, scale)
        if picture is first:
            errors = weighted((first - second) / np.sqrt(2), truth, scale)
        row = {"renderer": "Cycles", "family": "Cycles", "setting": f"{samples} samples", "own_settings": False,
               **figures(errors, tolerance), "seconds": seconds, "cpu_seconds": cpu_seconds}  # fmt: skip
        study.add(row, errors, None)
    apart = pixel_errors(truth, study.reference.colour, scale)
    median, p99 = np.quantile(apart, (0.5, 0.99))
    study.facts.append((
        "Cycles",
        f"direct light only, on the CPU, held against its own truth: the mean of two pictures of {SAMPLES[-1]} samples."
        f" Half of that truth's pixels differ from Penumbra's reference by less than {median:.2g}, 99 % by less than"
        f" {p99:.2g}: noise, edges, and what only one of the two renders",
    ))  # fmt: skip
