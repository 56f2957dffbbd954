# SPDX-License-Identifier: GPL-3.0-or-later
"""The 3D view in rendered shading, in a Blender with a window on a virtual screen (viewport_session.py works in it)."""

import json
import shutil
from pathlib import Path
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from helpers import (
    REPOSITORY,
    add_area_light,
    add_camera,
    add_cube,
    add_plane,
    diffuse_material,
    link,
    read_exr,
    render_pixels,
    run_blender,
)
from penumbra import progressive
from penumbra.export import view

SCREEN = (960, 600)
TOLERANCE = 0.02
DISPLAY_STEPS = 2.5 / 255
"""Blender dithers by up to one step of 8 bits, its texture and the screen round by half a step each."""


def make_scene(scene) -> None:
    """A cube on a floor: lit, penumbra, full shadow, and beyond the floor nothing."""
    floor = add_plane(scene, "Floor", size=20)
    floor.data.materials.append(diffuse_material("Paint"))
    cube = add_cube(scene, size=1.5, location=(0, 0, 1))
    cube.data.materials.append(diffuse_material("Wood"))
    add_area_light(scene, location=(2, 0, 5), power=100)
    add_camera(scene, location=(0, -8, 6), rotation=(0.9, 0, 0))
    scene.penumbra.error_tolerance = TOLERANCE
    scene.penumbra.pixel_samples = 1


def srgb(linear: np.ndarray) -> np.ndarray:
    """What the view transform "Standard" makes of scene-linear colours (IEC 61966-2-1)."""
    x = np.clip(linear, 0.0, 1.0)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 0.0031308) ** (1 / 2.4) - 0.055)


@pytest.fixture(scope="module")
def session(engine, tmp_path_factory):
    """What viewport_session.py recorded: name of a step -> its figures, `picture` and `screen`."""
    if not shutil.which("xvfb-run"):
        pytest.skip("there is no xvfb-run (Debian: apt-get install xvfb xauth)")
    folder = tmp_path_factory.mktemp("viewport")
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.world, scene.render.engine, scene.view_settings.view_transform = None, engine, "Standard"
    make_scene(scene)
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "scene.blend"), check_existing=False)
    addons = folder / "scripts" / "addons"
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(REPOSITORY / "addon" / "penumbra", addons / "penumbra", ignore=ignored)
    width, height = SCREEN
    # -fbdir: the server's memory is a file
    server = f"-screen 0 {width}x{height}x24 -ac +extension GLX +render -noreset -fbdir {folder}"
    process = run_blender(
        "--addons", "penumbra", folder / "scene.blend", "-P", Path(__file__).with_name("viewport_session.py"),
        "--", folder / "Xvfb_screen0", folder,
        within=["xvfb-run", "-a", "-s", server], options=["-p", "0", "0", str(width), str(height)], timeout=1200,
        environment={"BLENDER_USER_SCRIPTS": str(addons.parent), "LIBGL_ALWAYS_SOFTWARE": "1"},
    )  # fmt: skip
    log = process.stdout + process.stderr
    assert (folder / "session.json").exists(), log
    assert "Traceback" not in log, log
    recorded = json.loads((folder / "session.json").read_text())
    recorded["final"] = read_exr(folder / "final.exr")["Combined"]
    for name in recorded.keys() - {"left", "final"}:
        recorded[name] |= np.load(folder / f"{name}.npz")
    return recorded


def test_the_picture_is_a_final_render_from_there(session, scene):
    """In the view "orbit": 12 m above the floor; Blender's view has a sensor of 72 mm and a lens of 50 mm."""
    orbit = session["orbit"]
    make_scene(scene)
    add_camera(scene, location=(0, 0, 12), lens=50, sensor_width=72)
    scene.render.resolution_x, scene.render.resolution_y = orbit["size"]
    final = render_pixels(scene)["Combined"]
    assert orbit["picture"].shape == final.shape
    off = abs(orbit["picture"] - final).max(axis=-1)
    assert np.mean(off > 2 * TOLERANCE) < 0.01  # each keeps the tolerance in 99 % of the pixels
    assert 0.05 < np.mean(final[..., 0] > 0.1) < 0.95 and np.mean(final[..., 0] == 0) > 0.005  # lit and unlit places


@pytest.mark.parametrize("step", ["shade", "orbit", "look_orthographically", "move_object"])
def test_the_screen_shows_the_picture_through_colour_management(session, step):
    off = abs(session[step]["screen"] - srgb(session[step]["picture"][..., :3])).max(axis=-1)
    assert np.mean(off > DISPLAY_STEPS) < 0.02  # mouse pointer, rounded corners, frame of the camera


def test_only_a_change_of_the_scene_is_exported(session):
    exports = {name: figures["exports"] for name, figures in session.items() if name not in ("left", "final")}
    assert exports["shade"] == exports["select_object"] == exports["orbit"] == exports["look_orthographically"] == 1
    steps = ("move_object", "dim_light", "paint", "deform", "hide", "show")
    assert [exports[step] for step in steps] == [2, 3, 4, 5, 6, 7]
    assert exports["draw_border"] == exports["tighten"] == exports["mend_settings"] == 7
    moved = abs(session["move_object"]["picture"] - session["look_orthographically"]["picture"]).max(axis=-1)
    assert 0.005 < np.mean(moved > 0.1) < 0.5


def test_only_meshes_that_may_have_changed_are_read(session):
    """A transform, a light and a material leave both meshes alone. What is hidden and shown again may have got another
    address: then all that is there is read, and found to be what it was."""
    read = {name: figures["meshes_read"] for name, figures in session.items() if isinstance(figures, dict)}
    assert read["shade"] == read["move_object"] == read["dim_light"] == read["paint"] == 2
    assert (read["deform"], read["hide"], read["show"]) == (4, 5, 7)


@pytest.mark.parametrize(("step", "before"), [
    ("dim_light", "move_object"), ("paint", "dim_light"), ("deform", "paint"), ("hide", "deform"),
])  # fmt: skip
def test_each_change_is_seen(session, step, before):
    changed = abs(session[step]["picture"] - session[before]["picture"]).max(axis=-1)
    assert np.mean(changed > 0.02) > 0.004


def test_what_comes_back_is_what_it_was(session):
    np.testing.assert_array_equal(session["show"]["picture"], session["deform"]["picture"])


def test_a_border_is_cut_out_of_the_whole_picture(session):
    """Border and whole see the same pixels; of both, 99 % keep the tolerance."""
    width, height = session["draw_border"]["size"]
    x, y = round(0.35 * width), round(0.375 * height)
    part = session["draw_border"]["picture"]
    rows, columns = part.shape[:2]
    assert abs(columns - width / 4) <= 1 and abs(rows - height / 4) <= 1
    off = abs(part - session["show"]["picture"][y : y + rows, x : x + columns]).max(axis=-1)
    assert np.mean(off > 2 * TOLERANCE) < 0.01
    # Below it there is the background alone, and at most a line of Blender's own text.
    grey = {name: session[name]["screen"][: y - 3].mean(axis=-1) for name in ("draw_border", "show")}
    other = {name: np.mean(abs(values - np.median(values)) > 0.05) for name, values in grey.items()}
    assert other["draw_border"] < 0.02 < 0.1 < other["show"]


def test_settings_refine_fail_with_a_sentence_and_come_back(session):
    assert "estimated error" in session["tighten"]["status"]
    assert abs(session["tighten"]["picture"] - session["draw_border"]["picture"]).max() > 0
    assert "sampler" in session["break_settings"]["failure"] and "SOBOL" in session["break_settings"]["failure"]
    assert session["mend_settings"]["failure"] == "" and session["mend_settings"]["step"] == progressive.STEPS


def test_a_broken_scene_is_told_of_and_the_last_picture_stays(session):
    assert session["break_material"]["failure"].startswith("material 'Wood'")
    changed = (session["break_material"]["screen"] != session["mend_settings"]["screen"]).any(axis=-1)
    assert np.mean(changed) < 0.01  # Blender's own arrows at the region's edges come and go
    assert session["mend_material"]["failure"] == ""
    np.testing.assert_array_equal(session["mend_material"]["picture"], session["mend_settings"]["picture"])


def test_a_transparent_film_shows_the_background_of_the_view(session):
    alpha = session["clear_film"]["picture"][..., 3]
    assert set(np.unique(alpha)) == {0.0, 1.0}
    before, after = (session[name]["screen"][alpha == 0] for name in ("show", "clear_film"))
    assert np.median(before) == 0 and np.median(after) > 0.1


def test_a_change_cancels_what_runs_and_leaving_frees_it(session):
    """ "ask_too_much" would take minutes; 20 s for the first picture of another view are for a busy machine."""
    assert session["turn"]["seconds_to_first_picture"] < 20
    assert abs(session["turn"]["picture"] - session["ask_too_much"]["picture"]).max() > 0.1
    assert session["left"] == 0


def test_a_final_render_while_the_view_renders(session, scene):
    """Both at once: the final picture is the one that Blender renders alone; the view was at work when it began."""
    make_scene(scene)
    scene.objects["Cube"].location.x += 1.5
    bpy.data.lights["Light"].energy /= 2
    floor = bpy.data.materials["Paint"].node_tree.nodes["Diffuse BSDF"]
    floor.inputs["Color"].default_value = (0.2, 0.5, 0.1, 1)
    for vertex in scene.objects["Cube"].data.vertices:
        vertex.co.z *= 1.5
    scene.render.film_transparent = True
    scene.penumbra.stop_rule, scene.penumbra.light_samples = "FIXED", 65536
    scene.render.resolution_y, scene.render.resolution_x = session["final"].shape[:2]
    np.testing.assert_array_equal(session["final"], render_pixels(scene)["Combined"])
    assert not session["ask_too_much"]["done"] and session["render_meanwhile"]["failure"] == ""


def test_the_time_to_the_first_picture_is_known(session, record_property):
    for name in ("shade", "orbit", "move_object"):
        seconds = session[name]["seconds_to_first_picture"]
        record_property(f"seconds to the first picture, {name}", seconds)
        assert 0 < seconds < session[name]["seconds"]


@pytest.mark.parametrize(("size", "start", "count"), [(1280, 0, 1280), (101, 0, 101), (101, 37, 20), (3, 1, 1)])
def test_a_coarse_row_spans_the_whole_one(size, start, count):
    small, shown = progressive.shrunk(size, start, count, 4)
    centres = (np.arange(start, start + count) + 0.5) / size
    assert small == max(size // 4, 1) and len(shown) == count
    assert (abs(centres - (shown + 0.5) / small) <= 0.5 / small + 1e-12).all()


def test_clip_is_that_of_the_projection():
    """Perspective and orthographic projection matrices of clip 0.1 ... 50 (OpenGL's glFrustum and glOrtho)."""
    near, far = 0.1, 50.0
    perspective, flat = np.eye(4), np.eye(4)
    perspective[2:, 2:] = [[-(far + near) / (far - near), -2 * far * near / (far - near)], [-1, 0]]
    flat[2, 2:] = -2 / (far - near), -(far + near) / (far - near)
    np.testing.assert_allclose(view.clip_of(perspective, "PERSPECTIVE"), (near, far), rtol=1e-9)
    np.testing.assert_allclose(view.clip_of(flat, "ORTHOGRAPHIC"), (near, far), rtol=1e-9)


def test_the_border_of_a_camera_view_lies_in_the_frame(scene):
    """A camera whose frame fills the region's width: the frame's middle half is the region's middle half in x."""
    camera = add_camera(scene, location=(0, 0, 5))
    scene.render.resolution_x, scene.render.resolution_y = 200, 100
    scene.render.use_border = True
    scene.render.border_min_x, scene.render.border_max_x = 0.25, 0.75
    scene.render.border_min_y, scene.render.border_max_y = 0.0, 1.0
    depsgraph = bpy.context.evaluated_depsgraph_get()
    projection = np.array(camera.calc_matrix_camera(depsgraph, x=200, y=200))
    space = SimpleNamespace(camera=None, use_render_border=False)
    looks_through = SimpleNamespace(view_perspective="CAMERA")
    assert view.border_of(space, looks_through, scene, (200, 200), projection) == (50, 50, 100, 100)
    beside = SimpleNamespace(camera=link(scene, "Empty", None), use_render_border=False)
    assert view.border_of(beside, looks_through, scene, (200, 200), projection) == (0, 0, 200, 200)
