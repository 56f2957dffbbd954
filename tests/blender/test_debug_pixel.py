# SPDX-License-Identifier: GPL-3.0-or-later
"""render.py --debug-pixel: one pixel told, no picture."""

import bpy
from helpers import REPOSITORY, add_area_light, add_camera, add_plane, last_line, run_blender

SCRIPT = REPOSITORY / "examples" / "render.py"


def test_debug_pixel(scene, tmp_path):
    add_plane(scene, "Floor", size=100)
    add_plane(scene, "Plate", size=1, location=(0, 0, 1))
    add_area_light(scene, "Lamp", location=(0, 0, 3))
    add_camera(scene, location=(0, 0, 10))
    scene.render.filepath = str(tmp_path / "picture")
    path = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), check_existing=False)
    before = sorted(tmp_path.iterdir())
    told = run_blender(path, "-P", SCRIPT, "--", "--debug-pixel", "32,24")
    assert told.returncode == 0, told.stderr
    for text in ("pixel 32,24 (Plate), ray through its centre", "luminaire 'Lamp': form factor without shadows 0.0",
                 "16 points ################", "wholly seen: 4 points", "tolerance 0.004"):  # fmt: skip
        assert text in told.stdout
    for pixel, text in (("64,0", "debug_pixel: 64,0 is not in the rendered region"), ("1;2", "is not of the form X,Y")):
        refused = run_blender(path, "-P", SCRIPT, "--", "--debug-pixel", pixel)
        assert refused.returncode != 0 and text in last_line(refused)
    assert sorted(tmp_path.iterdir()) == before
