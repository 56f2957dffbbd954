# SPDX-License-Identifier: GPL-3.0-or-later
"""The ways people start the engine, in a Blender of its own: --addons, another package name, animations."""

import re

import bpy
import numpy as np
import pytest
from helpers import add_area_light, add_camera, add_plane, animate, command_line, read_exr, run_blender


@pytest.mark.parametrize("name", ["penumbra", "soft_shadows_2"])
def test_command_line_under_any_package_name(blend_file, scripts, name):
    _, environment = scripts(name)
    process = run_blender(*command_line(name, blend_file), environment=environment)
    assert process.returncode == 0, process.stdout + process.stderr
    pixels = read_exr(blend_file.parent / "out_0001.exr")["Combined"]
    assert pixels.shape == (48, 64, 4) and pixels[..., :3].min() > 0


def test_words_that_farms_fail_on_stay_out_of_the_log(blend_file, scripts):
    _, environment = scripts()
    process = run_blender(*command_line("penumbra", blend_file), environment=environment)
    lines = (process.stdout + process.stderr).splitlines()
    ours = [line for line in lines if "system.path" not in line]  # Blender 5's own, about mounted file systems
    assert not re.search("warning|error:", "\n".join(ours), re.IGNORECASE)


def test_a_failing_scene_exits_with_1_and_leaves_no_picture(scene, tmp_path, scripts):
    add_camera(scene, "Round", type="PANO")
    path = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), check_existing=False)
    _, environment = scripts()
    process = run_blender(*command_line("penumbra", path), environment=environment)
    assert process.returncode == 1
    assert "camera 'Round'" in process.stdout + process.stderr
    assert not list(tmp_path.glob("out_*"))


def test_an_animation_from_the_command_line(scene, tmp_path, scripts):
    add_plane(scene, size=20)
    light = add_area_light(scene, location=(0, 0, 3))
    animate(light.data, "energy", {1: 100.0, 3: 300.0})
    add_camera(scene)
    scene.penumbra.stop_rule = "FIXED"
    path = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), check_existing=False)
    _, environment = scripts()
    arguments = ["--addons", "penumbra", path, "-o", tmp_path / "f", "-F", "OPEN_EXR", "-s", "1", "-e", "3", "-a"]
    process = run_blender(*arguments, environment=environment)
    assert process.returncode == 0
    means = [read_exr(tmp_path / f"f{frame:04d}.exr")["Combined"][..., 0].mean() for frame in (1, 2, 3)]
    np.testing.assert_allclose(np.array(means) / means[0], [1, 2, 3], rtol=1e-3)
