# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion blur against Cycles in the same Blender: camera, transforms, instances, deformation, shutter and position.

Tolerances as in test_against_cycles_lens.py: both trace the light of many rays through a filter of a hundredth of a
pixel; the mean within four of Cycles' noise and 0.2 %, the root mean square of the difference within 1.7 of it (our own
noise is in it, too).
"""

import math

import bpy
import numpy as np
import pytest
from cycles_reference import colour, converge_cycles, relative_rmse, render_with_penumbra
from helpers import add_area_light, add_camera, add_cube, add_plane, animate, link
from penumbra import compat

SAMPLES = 128


@pytest.fixture
def shutter(scene):
    """A cube on a floor, the shutter open for a frame around frame 10."""
    add_plane(scene, "Floor", size=14.0)
    add_cube(scene, "Cube", size=1.2, location=(0.0, 0.0, 0.6))
    add_area_light(scene, size=1.0, power=500.0, location=(2.0, -2.0, 4.0), rotation=(0.3, 0.4, 0.0))
    add_camera(scene, location=(0.0, -6.5, 3.2), rotation=(1.15, 0.0, 0.0))
    scene.frame_set(10)
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
    penumbra = scene.penumbra
    penumbra.pixel_samples, penumbra.filter_type, penumbra.filter_width = 4 * SAMPLES, "BOX", 0.01
    scene.render.resolution_x, scene.render.resolution_y = 32, 24
    return scene


def assert_as_in_cycles(scene) -> None:
    ours, (cycles, noise) = colour(render_with_penumbra(scene, light_samples=4)), converge_cycles(scene, SAMPLES)
    theirs = colour(cycles)
    assert scene.frame_current_final == 10.0
    scene.render.use_motion_blur = False
    sharp = colour(render_with_penumbra(scene, light_samples=4))
    difference, noise_rmse = ours - theirs, relative_rmse(noise, theirs)
    assert relative_rmse(sharp - theirs, theirs) > 5 * noise_rmse  # the blur matters
    mean_noise = noise_rmse * theirs.mean() / np.sqrt(theirs[..., 0].size)
    assert abs(difference.mean()) < 4 * mean_noise + 2e-3 * theirs.mean()
    assert relative_rmse(difference, theirs) < 1.7 * noise_rmse


def move(scene, name="Cube") -> None:
    animate(scene.objects[name], "location", {8: (-2.0, 0, 0.6), 12: (2.0, 0, 0.6)})
    scene.frame_set(10)


def set_position(scene, position) -> None:
    owner = scene.render if hasattr(scene.render, "motion_blur_position") else scene.cycles
    owner.motion_blur_position = position
    assert compat.motion_blur_position(scene) == position


@pytest.mark.parametrize("position", ["START", "CENTER", "END"])
def test_position_of_the_shutter(shutter, position):
    move(shutter)
    set_position(shutter, position)
    assert_as_in_cycles(shutter)


def test_short_shutter(shutter):
    move(shutter)
    shutter.render.motion_blur_shutter = 0.5
    assert_as_in_cycles(shutter)


def test_shutter_curve(shutter):
    move(shutter)
    curve = shutter.render.motion_blur_shutter_curve
    curve.curves[0].points[0].location, curve.curves[0].points[-1].location = (0.0, 0.0), (1.0, 1.0)
    curve.update()
    assert_as_in_cycles(shutter)


@pytest.mark.parametrize("steps", [1, 3])
def test_turning_object(shutter, steps):
    cube = shutter.objects["Cube"]
    cube.scale = (1.6, 0.3, 1.0)
    cube.cycles.motion_steps = steps
    animate(cube, "rotation_euler", {9: (0, 0, 0), 11: (0, 0, math.radians(200))})
    shutter.frame_set(10)
    assert_as_in_cycles(shutter)


def test_camera(shutter):
    animate(shutter.camera, "location", {9: (-0.8, -6.5, 3.2), 11: (0.8, -6.5, 3.2)})
    animate(shutter.camera, "rotation_euler", {9: (1.15, 0, 0.2), 11: (1.15, 0.1, -0.1)})
    shutter.frame_set(10)
    assert_as_in_cycles(shutter)


def test_zooming_camera(shutter):
    animate(shutter.camera.data, "lens", {9: 35.0, 11: 65.0})
    shutter.frame_set(10)
    assert_as_in_cycles(shutter)


def test_shape_keys(shutter):
    cube = shutter.objects["Cube"]
    cube.shape_key_add(name="Basis")
    key = cube.shape_key_add(name="Up")
    for point in key.data:
        point.co.z += 1.5 if point.co.z > 0 else 0.0
    key.value = 0.0
    key.keyframe_insert("value", frame=9)
    key.value = 1.0
    key.keyframe_insert("value", frame=11)
    shutter.frame_set(10)
    assert_as_in_cycles(shutter)


def test_collection_instances(shutter):
    collection = bpy.data.collections.new("Group")
    source = shutter.objects["Cube"]
    shutter.collection.objects.unlink(source)
    collection.objects.link(source)
    source.scale = (0.5, 0.5, 0.5)
    for i in range(2):
        empty = link(shutter, f"Empty {i}", None, location=(2.0 * i - 1, 0, 0))
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
        animate(empty, "location", {9: (2.0 * i - 1, 0, 0), 11: (2.0 * i - 1, 1.0 - 2 * i, 0.5)})
    shutter.frame_set(10)
    assert_as_in_cycles(shutter)


def test_objects_may_opt_out(shutter):
    """The cube's blur is switched off, the camera's is not there: a sharp picture."""
    move(shutter)
    shutter.objects["Cube"].cycles.use_motion_blur = False
    blurred = colour(render_with_penumbra(shutter, light_samples=4))
    shutter.render.use_motion_blur = False
    np.testing.assert_array_equal(blurred, colour(render_with_penumbra(shutter, light_samples=4)))


def test_a_scene_that_stands_still_is_the_same_bit_for_bit(shutter):
    blurred = colour(render_with_penumbra(shutter, light_samples=4))
    shutter.render.use_motion_blur = False
    np.testing.assert_array_equal(blurred, colour(render_with_penumbra(shutter, light_samples=4)))


def test_notes(shutter, capfd):
    """A moving light stays; one ray a pixel blurs nothing; the rolling shutter is left out."""
    light = next(o for o in shutter.objects if o.type == "LIGHT")
    animate(light, "location", {9: (-2, -2, 4), 11: (2, -2, 4)})
    shutter.frame_set(10)
    shutter.cycles.rolling_shutter_type = "TOP"
    shutter.penumbra.pixel_samples = 4
    render_with_penumbra(shutter, light_samples=4)
    told = capfd.readouterr().out
    assert "'Light': it gives light and moves; it stays where it is at the shutter's centre" in told
    assert "the rolling shutter is not supported" in told
    shutter.penumbra.pixel_samples = 1
    render_with_penumbra(shutter, light_samples=4)
    assert "with one ray a pixel (pixel_samples 1) there is no motion blur" in capfd.readouterr().out
