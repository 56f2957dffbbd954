# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes examples/images/viewport.png: Blender's window with the four objects in rendered shading.

Run it as `LIBGL_ALWAYS_SOFTWARE=1 xvfb-run -s "-screen 0 1280x800x24" blender --factory-startup -p 0 0 1280 800
examples/four_objects.blend -P examples/viewport_screenshot.py`, in Blender 3 (later ones take black screenshots there).
"""

import sys
from pathlib import Path

import bpy

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER))

import penumbra_addon  # noqa: E402  (found through the line above)

POLL_SECONDS = 0.5


def work():
    """What a user would do; yields the seconds to wait before going on."""
    area = next(area for area in bpy.context.window.screen.areas if area.type == "VIEW_3D")
    space = area.spaces.active
    space.region_3d.view_matrix = bpy.context.scene.camera.matrix_world.inverted()
    space.lens = 42
    space.shading.type = "RENDERED"
    yield POLL_SECONDS
    while not all(shown.refinement and shown.refinement.done for shown in package.viewport.viewports):
        yield POLL_SECONDS
    yield POLL_SECONDS  # the last drawing
    bpy.ops.screen.screenshot(filepath=str(FOLDER / "images" / "viewport.png"))
    bpy.ops.wm.quit_blender()


package = penumbra_addon.load()
steps = work()
bpy.app.timers.register(lambda: next(steps, None), first_interval=POLL_SECONDS)
