# SPDX-License-Identifier: GPL-3.0-or-later
"""Run by a Blender with a window (test_previews.py): has the preview of each material, light and world rendered.

    xvfb-run ... blender --addons penumbra FILE -P preview_session.py -- FILE.npz

FILE.npz gets the pixels of each, (height, width, 4) from the bottom, and `seconds`: how long each took.
"""

import sys
import traceback
from time import perf_counter

import bpy
import numpy as np
from penumbra.engine import PenumbraRenderEngine

RESULT = sys.argv[sys.argv.index("--") + 1]
TIMEOUT_SECONDS, POLL_SECONDS = 240, 0.05
rendered: list = []


def watch() -> None:
    """Notes when the engine has rendered a preview."""
    render = PenumbraRenderEngine.render

    def watched(engine, depsgraph):
        since = perf_counter()
        render(engine, depsgraph)
        rendered.append((engine.is_preview, perf_counter() - since))

    PenumbraRenderEngine.render = watched


def session():
    """One preview after the other; yields the seconds to wait before going on."""
    found, seconds = {}, []
    yield 1.0
    for thing in (*bpy.data.materials, *bpy.data.lights, *bpy.data.worlds):
        since, before = perf_counter(), len(rendered)
        with bpy.context.temp_override(id=thing):
            bpy.ops.ed.lib_id_generate_preview()
        while len(rendered) == before:
            assert perf_counter() - since < TIMEOUT_SECONDS, f"no preview of {thing.name}"
            yield POLL_SECONDS
        yield 1.0  # for Blender to take it
        is_preview, needed = rendered[-1]
        assert is_preview
        seconds.append(needed)
        width, height = thing.preview.image_size
        found[thing.name] = np.array(thing.preview.image_pixels_float[:], np.float32).reshape(height, width, 4)
    np.savez(RESULT, seconds=seconds, **found)
    bpy.ops.wm.quit_blender()


def go_on():
    """One step of the session, called by Blender's timer."""
    try:
        return next(steps, None)
    except Exception:
        traceback.print_exc()
        bpy.ops.wm.quit_blender()
    return None


bpy.context.preferences.view.show_splash = False
watch()
steps = session()
bpy.app.timers.register(go_on)
