# SPDX-License-Identifier: GPL-3.0-or-later
"""Speed against error: renders the user's own scene with many settings and writes a page that compares them.

`write_report` is the table of contents of this room. Nothing here is needed for rendering, and Matplotlib is imported
only when a report is asked for.
"""

from pathlib import Path

from .. import native
from ..export.camera import render_region
from . import cycles, folder, page, penumbra_runs, plots
from .changes import Changes

__all__ = ["DEFAULT_PIXELS", "write_report"]

DEFAULT_PIXELS = 320 * 240
"""The frame is scaled down to so many pixels: the reference needs thousands of points in each."""


def limit_pixels(scene, changes: Changes, most: int) -> None:
    """Lowers the resolution percentage until what is rendered has at most `most` pixels (or it is 1 %)."""
    _, _, width, height = render_region(scene)
    if width * height > most:
        percentage = int(scene.render.resolution_percentage * (most / (width * height)) ** 0.5)
        changes.set(scene.render, "resolution_percentage", max(percentage, 1))


def only_the_renderers_work(scene, view_layer, changes: Changes) -> None:
    """One view layer, no compositor or sequencer, a picture of the border's size; a render from scratch each time."""
    for layer in scene.view_layers:
        changes.set(layer, "use", layer == view_layer)
    for name, value in {
        "use_compositing": False,
        "use_sequencer": False,
        "use_freestyle": False,
        "use_persistent_data": False,
        "use_crop_to_border": True,
    }.items():
        changes.set(scene.render, name, value)


def write_report(scene, view_layer, target: Path, most_pixels: int = DEFAULT_PIXELS) -> Path:
    """Writes the report of one view layer into the folder `target` and returns its page.

    The folder appears only when all is written; a former report in it is replaced, anything else refused. All settings
    are afterwards what they were. Raises RuntimeError, ValueError, OSError or ExportError with a sentence, the missing
    Matplotlib and an unusable folder before anything is rendered.
    """
    pn = native.require()
    plots.require()
    target = folder.checked(target)
    with Changes() as changes:
        limit_pixels(scene, changes, most_pixels)
        only_the_renderers_work(scene, view_layer, changes)
        study = penumbra_runs.study(pn, scene)
        if cycles.is_enabled(scene):
            cycles.add_to(study, scene)
    with folder.whole_or_nothing(target) as unfinished:
        page.write(study, unfinished)
    return target / page.NAME
