# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene with many features at once beside Cycles' picture of it (see whole_scene.py for what is in it), and what it
brought to light.

Centre rays. Tolerances: each channel's mean within 1 % (Principled's share; seen in Blender 3.4: 0.2 %) and four of
Cycles' noise; the root mean square of the difference within 1.3 of Cycles' noise and an eighth of BOUNDED's tolerance
(seen: 0.0029 at a noise of 0.0019; it was 0.008 while shadows of leaves that share a mesh had no holes).
"""

import numpy as np
import pytest
import whole_scene
from helpers import (
    add_area_light,
    add_camera,
    add_mesh,
    add_plane,
    diffuse_material,
    link,
    render_pixels,
    use_cycles_as_reference,
)
from penumbra import statistics

TOLERANCE = 0.02


def picture_of_cycles(scene, seed: int) -> np.ndarray:
    use_cycles_as_reference(scene, 128)
    scene.cycles.seed = seed
    return render_pixels(scene, "CYCLES")["Combined"][..., :3].astype(float)


def test_as_in_cycles(scene):
    whole_scene.build(scene)
    scene.cycles_curves.shape = "RIBBONS"
    scene.render.resolution_x, scene.render.resolution_y = 64, 48
    scene.penumbra.error_tolerance, scene.penumbra.pixel_samples = TOLERANCE, 1
    ours = render_pixels(scene, "PENUMBRA")["Combined"][..., :3].astype(float)
    assert statistics.last_render["warnings"] == []  # nothing is left out
    first, second = picture_of_cycles(scene, 0), picture_of_cycles(scene, 1)
    noise, theirs = (first - second) / 2, (first + second) / 2
    difference = ours - theirs
    of_mean = np.sqrt((noise**2).mean((0, 1)) / noise[..., 0].size)
    assert (np.abs(difference.mean((0, 1))) < 0.01 * theirs.mean((0, 1)) + 4 * of_mean).all()
    assert np.sqrt((difference**2).mean()) < 1.3 * np.sqrt((noise**2).mean()) + TOLERANCE / 8


@pytest.mark.parametrize("moves", [False, True])
def test_holes_of_a_shared_mesh_cast_the_shadows_of_its_own(scene, moves):
    """Two leaves with holes cut by alpha, turned, sheared by their parent and moved: as instances of one mesh, whose
    shadow rays Embree hands on in the mesh's space, and with a mesh each. Moving, all are instances of Embree's: there
    the mean is Cycles' (0.3 % for 64 samples; without holes it is 2.8 % less)."""
    add_plane(scene, "Floor", size=6)
    add_area_light(scene, power=200, location=(0, 1, 4), size=0.5)
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0.3), (0, 1, 0)]
    leaf = add_mesh(scene, "Leaf", corners, [(0, 1, 2, 3)], location=(-1, 0, 0.5), rotation=(0.5, -0.3, 0.4))
    leaf.data.uv_layers.new().data.foreach_set("uv", np.array([0, 0, 1, 0, 1, 1, 0, 1], np.float32))
    leaf.data.materials.append(whole_scene.painted("Leaf", alpha=True))
    parent = link(scene, "Parent", None, scale=(1, 1.7, 0.8), rotation=(0, 0.2, 0))
    other = link(scene, "Other", leaf.data, location=(0.4, -0.2, 1.2), rotation=(1.2, 0.4, -0.9))
    other.parent = parent
    add_camera(scene, location=(0, -4, 4), rotation=(0.75, 0, 0))
    if moves:
        scene.render.use_motion_blur = True
        for thing in (leaf, other):
            thing.keyframe_insert("location", frame=0)
            thing.location.x += 0.4
            thing.keyframe_insert("location", frame=2)
        scene.frame_set(1)
    scene.render.resolution_x, scene.render.resolution_y = 64, 48
    scene.penumbra.stop_rule, scene.penumbra.light_samples, scene.penumbra.pixel_samples = "FIXED", 16, 4
    shared = render_pixels(scene)["Combined"]
    other.data = leaf.data.copy()
    single = render_pixels(scene)["Combined"]
    if moves:
        use_cycles_as_reference(scene, 64)
        assert shared[..., :3].mean() == pytest.approx(
            render_pixels(scene, "CYCLES")["Combined"][..., :3].mean(), rel=0.003
        )
    leaf.data.materials[0] = other.data.materials[0] = diffuse_material("Solid", (0.5, 0.5, 0.5))
    solid = render_pixels(scene)["Combined"]
    difference = np.abs(shared - single)[..., :3]
    assert np.mean(np.abs(solid - single)[..., 1] > 0.05) > 0.02, "the holes do not matter here"
    assert np.mean(difference > 0.01) < 0.003 and difference.mean() < 3e-4  # grazed edges fall either way
