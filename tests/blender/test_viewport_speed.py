# SPDX-License-Identifier: GPL-3.0-or-later
"""How soon the 3D view shows something: 100,000 triangles at 1280 x 720 on a virtual screen (viewport_speed.py).

Seconds mean little on a machine that others use, so the figures are recorded (README.md has them), and what is tested
is that a change of the scene costs little more than one of the view, for which nothing is exported.
"""

import json
import shutil
from pathlib import Path
from statistics import median

import bpy
import numpy as np
import pytest
from helpers import REPOSITORY, add_area_light, add_camera, add_cube, add_mesh, diffuse_material, run_blender

SCREEN = (1280, 720)
SIDE = 224


def make_scene(scene) -> None:
    """A cube over waves of 100,352 triangles."""
    x, y = (a.ravel() for a in np.meshgrid(*[np.linspace(-5, 5, SIDE + 1)] * 2))
    corner = (np.arange(SIDE)[:, None] * (SIDE + 1) + np.arange(SIDE)).ravel()
    faces = np.stack([corner, corner + 1, corner + SIDE + 2, corner + SIDE + 1], axis=-1)
    waves = add_mesh(scene, "Waves", np.stack([x, y, 0.2 * np.sin(3 * x) * np.cos(2 * y)], axis=-1), faces)
    waves.data.materials.append(diffuse_material("Paint"))
    waves.data.polygons.foreach_set("use_smooth", np.ones(len(faces), dtype=bool))
    add_cube(scene, size=1.5, location=(0, 0, 1.5))
    add_area_light(scene, location=(2, 0, 5), power=100)
    add_camera(scene, location=(0, -8, 6), rotation=(0.9, 0, 0))


@pytest.fixture(scope="module")
def measured(engine, tmp_path_factory):
    if not shutil.which("xvfb-run"):
        pytest.skip("there is no xvfb-run (Debian: apt-get install xvfb xauth)")
    folder = tmp_path_factory.mktemp("speed")
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.world, scene.render.engine = None, engine
    make_scene(scene)
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "scene.blend"), check_existing=False)
    addons = folder / "scripts" / "addons"
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(REPOSITORY / "addon" / "penumbra", addons / "penumbra", ignore=ignored)
    width, height = SCREEN
    process = run_blender(
        "--addons", "penumbra", folder / "scene.blend", "-P", Path(__file__).with_name("viewport_speed.py"),
        "--", folder / "speed.json",
        within=["xvfb-run", "-a", "-s", f"-screen 0 {width}x{height}x24 -ac +extension GLX +render -noreset"],
        options=["-p", "0", "0", str(width), str(height)], timeout=1200,
        environment={"BLENDER_USER_SCRIPTS": str(addons.parent), "LIBGL_ALWAYS_SOFTWARE": "1"},
    )  # fmt: skip
    log = process.stdout + process.stderr
    assert (folder / "speed.json").exists(), log
    assert "Traceback" not in log, log
    return json.loads((folder / "speed.json").read_text())


def middle(entries, name: str) -> float:
    return median(entry[name] for entry in entries)


@pytest.mark.parametrize("change", ["move", "dim", "paint", "deform"])
def test_a_change_of_the_scene_is_seen_nearly_as_soon_as_one_of_the_view(measured, change, record_property):
    """What "nearly" is, viewport_speed.py has."""
    size = measured["size"]
    assert size[0] * size[1] > 0.9 * SCREEN[0] * SCREEN[1]
    for name in ("orbit", change):
        for what in ("first", "shown"):
            text = f"{middle(measured[name], what):.3f} (best {min(e[what] for e in measured[name]):.3f})"
            record_property(f"seconds, {name}, {what}", text)
            print(f"viewport: {name:8} {what:6} {text}")
    assert all(entry["read"] == (2 if change == "deform" else 0) for entry in measured[change])
    assert change not in measured["slow"]
