# SPDX-License-Identifier: GPL-3.0-or-later
"""Previews of materials, lights and worlds, in a Blender with a window on a virtual screen (preview_session.py)."""

import shutil
from pathlib import Path

import bpy
import numpy as np
import pytest
from helpers import REPOSITORY, add_area_light, add_camera, add_plane, diffuse_material, emissive_material, run_blender


@pytest.fixture(scope="module")
def previews(engine, tmp_path_factory):
    """Name of a datablock -> (height, width, 4), and `seconds`."""
    if not shutil.which("xvfb-run"):
        pytest.skip("there is no xvfb-run (Debian: apt-get install xvfb xauth)")
    folder = tmp_path_factory.mktemp("previews")
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.engine = engine
    floor = add_plane(scene, size=20)
    for material in (diffuse_material("Red", (0.8, 0.02, 0.02)), emissive_material("Blue", (0.05, 0.05, 1.0))):
        floor.data.materials.append(material)
    add_area_light(scene, "Lamp", location=(0, 0, 4))
    add_camera(scene)
    scene.world = bpy.data.worlds.new("Green")
    scene.world.color = (0.05, 0.5, 0.05)
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "scene.blend"), check_existing=False)
    addons = folder / "scripts" / "addons"
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(REPOSITORY / "addon" / "penumbra", addons / "penumbra", ignore=ignored)
    process = run_blender(
        "--addons", "penumbra", folder / "scene.blend", "-P", Path(__file__).with_name("preview_session.py"),
        "--", folder / "previews.npz",
        within=["xvfb-run", "-a", "-s", "-screen 0 640x480x24 -ac +extension GLX +render -noreset"],
        options=["-p", "0", "0", "640", "480"],
        environment={"BLENDER_USER_SCRIPTS": str(addons.parent), "LIBGL_ALWAYS_SOFTWARE": "1"},
    )  # fmt: skip
    log = process.stdout + process.stderr
    assert (folder / "previews.npz").exists(), log
    assert "Traceback" not in log and "Penumbra note" not in log, log
    return dict(np.load(folder / "previews.npz"))


@pytest.mark.parametrize(("name", "channel"), [("Red", 0), ("Blue", 2)])
def test_a_material_shows_its_colour(previews, name, channel):
    """In the middle, where the ball is, that channel is far above the others: more than twice, but AgX, the view
    transform since 4.0, shows what is as bright as this blue at just twice them."""
    least = 1.5 if name == "Blue" and bpy.app.version >= (4, 0, 0) else 2
    picture = previews[name]
    height, width = picture.shape[:2]
    middle = picture[height // 3 : 2 * height // 3, width // 3 : 2 * width // 3, :3]
    others = np.delete(middle, channel, axis=-1).max(axis=-1)
    assert np.mean(middle[..., channel] > least * others) > 0.8
    assert np.median(middle[..., channel]) > 0.1


def test_lights_and_worlds_have_previews(previews):
    for name in ("Lamp", "Green"):
        assert np.ptp(previews[name][..., :3]) > 0.1 or previews[name][..., :3].max() > 0.1, name


def test_each_preview_takes_seconds_at_most(previews):
    """128 x 128 pixels of 4 rays. A minute is for a machine with much other work."""
    assert len(previews["seconds"]) == 4 and max(previews["seconds"]) < 60
