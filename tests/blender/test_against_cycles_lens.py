# SPDX-License-Identifier: GPL-3.0-or-later
"""Depth of field against Cycles in the same Blender: f-stop, blades, rotation, ratio, focus object and bone.

Ours traces eight times Cycles' rays a pixel, both through a filter of a hundredth of a pixel. Tolerances: the mean
within four of the noise that two seeds of Cycles tell and 0.1 %, the root mean square of the difference within 1.5 of
Cycles' noise.
"""

import bpy
import numpy as np
import pytest
from cycles_reference import colour, converge_cycles, relative_rmse, render_with_penumbra
from helpers import add_area_light, add_camera, add_cube, add_plane

SAMPLES = 128
LENSES = {
    "round": {},
    "wide open": {"aperture_fstop": 0.05},
    "triangle": {"aperture_blades": 3},
    "turned blades": {"aperture_blades": 5, "aperture_rotation": 0.5},
    "anamorphic": {"aperture_blades": 6, "aperture_ratio": 2.0},
    "near focus": {"focus_distance": 4.0},
}


@pytest.fixture
def blurred(scene):
    """A cube before and one behind the focus."""
    add_plane(scene, "Floor", size=12.0)
    add_cube(scene, "Near", size=0.6, location=(-0.6, -2.5, 0.3), rotation=(0, 0, 0.5))
    add_cube(scene, "Far", size=1.0, location=(1.2, 2.3, 0.5), rotation=(0, 0, 0.2))
    add_area_light(scene, size=1.0, power=400.0, location=(2.0, -2.0, 4.0), rotation=(0.3, 0.4, 0.0))
    dof = add_camera(scene, location=(0.3, -6.5, 2.2), rotation=(1.25, 0.0, 0.03)).data.dof
    dof.use_dof, dof.focus_distance, dof.aperture_fstop = True, 6.5, 0.1
    penumbra = scene.penumbra
    penumbra.pixel_samples, penumbra.filter_type, penumbra.filter_width = 8 * SAMPLES, "BOX", 0.01
    scene.render.resolution_x, scene.render.resolution_y = 32, 24
    return scene


def assert_as_in_cycles(scene) -> None:
    ours, (cycles, noise) = colour(render_with_penumbra(scene, light_samples=4)), converge_cycles(scene, SAMPLES)
    theirs = colour(cycles)
    scene.camera.data.dof.use_dof = False
    sharp = colour(render_with_penumbra(scene, light_samples=4))
    difference, noise_rmse = ours - theirs, relative_rmse(noise, theirs)
    assert relative_rmse(sharp - theirs, theirs) > 5 * noise_rmse  # the lens matters
    mean_noise = noise_rmse * theirs.mean() / np.sqrt(theirs[..., 0].size)
    assert abs(difference.mean()) < 4 * mean_noise + 1e-3 * theirs.mean()
    assert relative_rmse(difference, theirs) < 1.5 * noise_rmse


@pytest.mark.parametrize("settings", LENSES.values(), ids=LENSES)
def test_lens(blurred, settings):
    for name, value in settings.items():
        setattr(blurred.camera.data.dof, name, value)
    assert_as_in_cycles(blurred)


@pytest.mark.parametrize("clip_start", [0.1, 1.0])
def test_orthographic_lens(blurred, clip_start):
    """Where the distance to the focus is counted from depends on the version (see compat.py)."""
    data = blurred.camera.data
    data.type, data.ortho_scale, data.clip_start = "ORTHO", 4.0, clip_start
    data.dof.aperture_fstop, data.dof.focus_distance = 2.0, 4.0
    assert_as_in_cycles(blurred)


def test_focus_object(blurred):
    blurred.camera.data.dof.focus_object = blurred.objects["Near"]
    blurred.camera.scale = (2.0, 2.0, 2.0)
    assert_as_in_cycles(blurred)


def test_focus_bone(blurred):
    """An armature far behind, whose bone is at the nearer cube."""
    armature = bpy.data.objects.new("Rig", bpy.data.armatures.new("Rig"))
    blurred.collection.objects.link(armature)
    armature.location = (0.0, 20.0, 0.0)
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    bone = armature.data.edit_bones.new("tip")
    bone.head, bone.tail = (-0.6, -22.5, 0.3), (-0.6, -22.5, 1.3)
    bpy.ops.object.mode_set(mode="OBJECT")
    dof = blurred.camera.data.dof
    dof.focus_object, dof.focus_subtarget = armature, "tip"
    assert_as_in_cycles(blurred)


def test_one_ray_is_a_pinhole_and_says_so(blurred, capfd):
    blurred.penumbra.pixel_samples = 1
    ours = colour(render_with_penumbra(blurred, light_samples=4))
    assert "with one ray a pixel (pixel_samples 1) there is no depth of field" in capfd.readouterr().out
    blurred.camera.data.dof.use_dof = False
    np.testing.assert_array_equal(ours, colour(render_with_penumbra(blurred, light_samples=4)))
    assert "depth of field" not in capfd.readouterr().out
