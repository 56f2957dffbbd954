# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes examples/images/panel.png: the render properties after a render of the four objects.

Run it as `LIBGL_ALWAYS_SOFTWARE=1 xvfb-run -s "-screen 0 520x960x24" blender --factory-startup -p 0 0 520 960
examples/four_objects.blend -P examples/panel_screenshot.py`, in Blender 3 (later ones take black screenshots there).
With `-- CONTEXT FILE.png` it is another page of the properties editor, such as MATERIAL, of the active object.
"""

import sys
from pathlib import Path

import bpy

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER))

import penumbra_addon  # noqa: E402  (found through the line above)

SETTLE_SECONDS = 3.0
"""For panels to open and previews to be rendered."""


def work(context: str, picture: Path):
    """What a user would do; yields the seconds to wait before going on."""
    bpy.context.scene.render.resolution_percentage = 50
    bpy.ops.render.render()
    area = max(bpy.context.window.screen.areas, key=lambda area: area.width * area.height)
    with bpy.context.temp_override(area=area):
        bpy.ops.screen.screen_full_area()
    yield 1.0
    area = bpy.context.window.screen.areas[0]
    area.type = "PROPERTIES"
    yield 1.0  # its pages are known once it was drawn
    area.spaces.active.context = context
    yield SETTLE_SECONDS
    bpy.ops.screen.screenshot(filepath=str(picture))
    bpy.ops.wm.quit_blender()


package = penumbra_addon.load()
given = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else ["RENDER", FOLDER / "images" / "panel.png"]
steps = work(str(given[0]), Path(given[1]))
bpy.app.timers.register(lambda: next(steps, None), first_interval=1.0)
