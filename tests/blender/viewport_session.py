# SPDX-License-Identifier: GPL-3.0-or-later
"""Run by a Blender with a window (test_viewport.py): works in a 3D view in rendered shading and records what it shows.

    xvfb-run ... blender --addons penumbra FILE -P viewport_session.py -- SCREEN FOLDER

SCREEN is the X server's memory as a file in xwd format. FOLDER gets NAME.npz for each thing that was done (`screen`:
the region's pixels, 0 ... 1, bottom row first; `picture`: the linear ones behind them) and session.json.
"""

import json
import struct
import sys
import traceback
from pathlib import Path
from time import perf_counter

import bpy
import numpy as np
from mathutils import Matrix, Quaternion
from penumbra import progressive, viewport

SCREEN, FOLDER = (Path(text) for text in sys.argv[sys.argv.index("--") + 1 :])
TIMEOUT_SECONDS = 240
FINAL_SIZE = (48, 32)
MANY_SAMPLES = 65536
"""A second for FINAL_SIZE, a minute and more for the view."""
SETTLE_SECONDS = 0.5
"""For a change that Blender does not tell of, and between two looks at a screen that must not change any more."""
recorded: dict = {}


def read_screen() -> np.ndarray:
    """(height, width, 3) of the whole screen, 0 ... 1, bottom row first."""
    content = SCREEN.read_bytes()
    header = struct.unpack(">25I", content[:100])
    size, width, height, line, colours = header[0], header[4], header[5], header[12], header[19]
    start = size + 12 * colours
    pixels = np.frombuffer(content, np.uint8, line * height, start).reshape(height, line // 4, 4)
    return pixels[::-1, :width, 2::-1] / 255.0


def view():
    """(area, region, space) of the 3D view."""
    area = next(area for area in bpy.context.window.screen.areas if area.type == "VIEW_3D")
    return area, next(region for region in area.regions if region.type == "WINDOW"), area.spaces.active


def record(name: str, since: float) -> None:
    """Keeps what the view shows now."""
    _, region, _ = view()
    (shown,) = viewport.viewports
    picture = shown.refinement.pixels
    screen = read_screen()[region.y : region.y + region.height, region.x : region.x + region.width]
    picture = shown.refinement.pixels
    np.savez(FOLDER / f"{name}.npz", screen=screen, picture=np.zeros(0) if picture is None else picture)
    now = shown.refinement
    recorded[name] = {
        "exports": shown.exports, "meshes_read": shown.meshes_read,
        "failure": shown.failure or now.failure, "status": shown.status, "step": now.step,
        "seconds_to_first_picture": now.seconds_to_first_picture, "seconds": perf_counter() - since,
        "size": [region.width, region.height], "done": now.done,
    }  # fmt: skip


def is_settled() -> bool:
    """Whether the view has the last and best picture of what it is to show, and has drawn it."""
    shown = list(viewport.viewports)
    if len(shown) != 1 or shown[0].refinement is None:
        return False
    return shown[0].refinement.done and shown[0].is_drawn


def is_at_last_picture() -> bool:
    (shown,) = viewport.viewports
    return shown.refinement.step == progressive.STEPS


def has_first_picture() -> bool:
    (shown,) = viewport.viewports
    return shown.refinement.pixels is not None


def shade() -> None:
    _, _, space = view()
    space.overlay.show_overlays = space.show_gizmo = False
    space.show_region_toolbar = space.show_region_tool_header = space.show_region_header = space.show_region_ui = False
    space.region_3d.view_perspective = "CAMERA"
    bpy.context.scene.camera.data.show_passepartout = False
    space.shading.type = "RENDERED"


def orbit() -> None:
    _, _, space = view()
    space.region_3d.view_perspective = "PERSP"
    space.region_3d.view_matrix = Matrix.Translation((0, 0, -12))


def look_orthographically() -> None:
    view()[2].region_3d.view_perspective = "ORTHO"


def move_object() -> None:
    bpy.data.objects["Cube"].location.x += 1.5


def dim_light() -> None:
    bpy.data.lights["Light"].energy /= 2


def set_colour(material: str, colour) -> None:
    bpy.data.materials[material].node_tree.nodes["Diffuse BSDF"].inputs["Color"].default_value = colour


def paint() -> None:
    """Another colour, of the material of the floor."""
    set_colour("Paint", (0.2, 0.5, 0.1, 1))


def deform() -> None:
    mesh = bpy.data.objects["Cube"].data
    for vertex in mesh.vertices:
        vertex.co.z *= 1.5
    mesh.update()


def hide() -> None:
    bpy.data.objects["Cube"].hide_set(True)


def show() -> None:
    bpy.data.objects["Cube"].hide_set(False)


def select_object() -> None:
    bpy.data.objects["Cube"].select_set(True)


def change_setting(name: str, value) -> None:
    """As the user does it in a panel: Blender's buttons tag the datablock, which Python by itself does not."""
    setattr(bpy.context.scene.penumbra, name, value)
    bpy.context.scene.update_tag()


def tighten() -> None:
    change_setting("error_tolerance", bpy.context.scene.penumbra.error_tolerance / 2)


def draw_border() -> None:
    _, _, space = view()
    space.render_border_min_x, space.render_border_max_x = 0.35, 0.6
    space.render_border_min_y, space.render_border_max_y = 0.375, 0.625
    space.use_render_border = True


def break_settings() -> None:
    change_setting("sampler", "SOBOL")


def mend_settings() -> None:
    change_setting("sampler", "OWEN_SOBOL")


def break_material() -> None:
    set_colour("Wood", (float("nan"), 0, 0, 1))


def mend_material() -> None:
    set_colour("Wood", (0.8, 0.8, 0.8, 1))


def clear_film() -> None:
    view()[2].use_render_border = False
    bpy.context.scene.render.film_transparent = True


def ask_too_much() -> None:
    """A picture of minutes, in blocks of 8 x 8 pixels of well below a second."""
    bpy.context.scene.penumbra.light_samples = MANY_SAMPLES
    change_setting("stop_rule", "FIXED")


def render_meanwhile() -> None:
    """A final render (F12), in a thread of Blender's, while the view goes on with its minutes."""
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = FINAL_SIZE
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.render.filepath = str(FOLDER / "final.exr")
    bpy.context.preferences.view.render_display_type = "NONE"
    bpy.ops.render.render("INVOKE_DEFAULT", write_still=True)


def is_rendered() -> bool:
    return (FOLDER / "final.exr").exists() and not bpy.app.is_job_running("RENDER")


def turn() -> None:
    view()[2].region_3d.view_rotation.rotate(Quaternion((1, 0, 0), 0.5))


def leave() -> None:
    view()[2].shading.type = "SOLID"


STEPS = {
    shade: is_settled, select_object: is_settled, orbit: is_settled, look_orthographically: is_settled,
    move_object: is_settled, dim_light: is_settled, paint: is_settled, deform: is_settled, hide: is_settled,
    show: is_settled, draw_border: is_settled, tighten: is_settled, break_settings: is_settled,
    mend_settings: is_settled, break_material: is_settled, mend_material: is_settled, clear_film: is_settled,
    ask_too_much: is_at_last_picture, render_meanwhile: is_rendered, turn: has_first_picture,
}  # fmt: skip
"""What is done, and what is waited for then."""


def session():
    """The steps; yields the seconds to wait before going on."""
    yield 0.5
    for step, is_awaited in STEPS.items():
        since = perf_counter()
        step()
        yield SETTLE_SECONDS
        while not is_awaited():
            assert perf_counter() - since < TIMEOUT_SECONDS, f"{step.__name__} takes too long"
            yield 0.05
        before = None
        while before is None or is_awaited is is_settled and (read_screen() != before).any():
            assert perf_counter() - since < TIMEOUT_SECONDS, f"the screen does not settle after {step.__name__}"
            before = read_screen()
            yield SETTLE_SECONDS
        record(step.__name__, since)
    leave()
    yield SETTLE_SECONDS
    recorded["left"] = len(viewport.viewports)
    (FOLDER / "session.json").write_text(json.dumps(recorded, indent=1))


def go_on():
    """One step of the session, called by Blender's timer."""
    try:
        return next(steps)
    except StopIteration:
        bpy.ops.wm.quit_blender()
    except Exception:
        traceback.print_exc()
        bpy.ops.wm.quit_blender()
    return None


bpy.context.preferences.view.show_splash = False  # Blender 4 greets whoever has no settings yet, files or not
steps = session()
bpy.app.timers.register(go_on)
