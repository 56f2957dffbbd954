# SPDX-License-Identifier: GPL-3.0-or-later
"""Passes where strands, points and things on the move are seen: against Cycles, and that they add up.

Tolerances as of the same comparison without them (test_against_cycles_passes.py), on means of 4 x 4 pixels: strands and
streaks are everywhere an edge, and there both engines draw their samples.
"""

import numpy as np
import pytest
from helpers import add_camera, add_light, add_plane, animate, diffuse_material
from passes_scene import build, cycles_passes, penumbra_passes, switch_on
from test_against_cycles_passes import coverage, cycles_filtered, total


@pytest.fixture
def lively(scene):
    """The scene of passes; the box is furry, its child and the pane of glass move."""
    build(scene)
    box, child, pane = (scene.objects[name] for name in ("Box", "Child", "Pane"))
    box.data.materials.append(diffuse_material("Fur", (0.8, 0.3, 0.2)))
    box.data.materials[1].pass_index = 60
    box.modifiers.new("Fur", "PARTICLE_SYSTEM")
    fur = box.particle_systems[0].settings
    fur.type, fur.count, fur.hair_length, fur.material, fur.radius_scale = "HAIR", 80, 0.6, 2, 0.03
    animate(child, "location", {9: (-0.5, 0, 0.8), 11: (0.7, 0, 0.9)})
    animate(pane, "location", {9: (0.6, -0.6, 0.7), 11: (1.0, -0.6, 0.8)})
    scene.frame_set(10)
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
    scene.view_layers[0].use_pass_z = scene.view_layers[0].use_pass_normal = True
    scene.cycles_curves.shape = "RIBBONS"
    scene.penumbra.pixel_samples, scene.penumbra.error_tolerance = 16, 0.01
    return scene


def blocks(values) -> np.ndarray:
    """(height, width, ...) -> means of 4 x 4 pixels."""
    height, width = (4 * (n // 4) for n in values.shape[:2])
    cut = values[:height, :width].reshape(height // 4, 4, width // 4, 4, *values.shape[2:])
    return cut.mean((1, 3))


def test_as_in_cycles(lively):
    ours, cycles = penumbra_passes(lively), cycles_filtered(lively, 256)
    for name in ("Diffuse Color", "Emission", "Mist"):
        difference = blocks(ours[name]) - blocks(cycles[name])
        assert np.sqrt(np.mean(difference**2)) < 0.02, name
        assert abs(difference.mean()) < 0.005, name
    for kind in ("CryptoObject00", "CryptoMaterial00", "CryptoAsset00"):
        ids = np.unique(cycles[kind][..., 0::2])
        assert set(np.unique(ours[kind][..., 0::2])) == set(ids), kind
        for one in ids[ids != 0]:
            difference = blocks(coverage(ours[kind], one)) - blocks(coverage(cycles[kind], one))
            assert np.sqrt(np.mean(difference**2)) < 0.04, kind
            assert abs(difference.mean()) < 0.005, kind


def test_what_a_sample_sees_is_one_of_what_is_there(lively):
    """Indices, depths and normals come from the surface of one sample: never a mixture, wherever strands are thin."""
    ours = penumbra_passes(lively)
    objects = {thing.pass_index for thing in lively.objects if thing.type == "MESH"}
    assert set(np.unique(ours["Object Index"])) <= objects | {0}
    assert {0, 10, 20, 30, 50, 60} <= set(np.unique(ours["Material Index"])) <= set(range(0, 70, 10))
    depth, length = ours["Depth"][..., 0], np.linalg.norm(ours["Normal"], axis=-1)
    seen = ours["Object Index"][..., 0] > 0
    assert np.isfinite(ours["Depth"]).all() and depth[seen].min() > 2 and depth[seen].max() < 30
    np.testing.assert_allclose(length[seen], 1, atol=1e-5)


def test_passes_add_up(lively):
    ours = penumbra_passes(lively)
    np.testing.assert_allclose(total(ours), ours["Combined"][..., :3], atol=2e-5)


def test_data_of_strands_through_pixels_centres(scene):
    """Indices as in Cycles, pixel by pixel; UV of the ground likewise. Strands know none of their roots: theirs are 0
    (README)."""
    switch_on(scene.view_layers[0], "UV", "Object Index", "Material Index")
    lawn = add_plane(scene, "Lawn", size=2)
    corners = np.array([0, 0, 1, 0, 1, 1, 0, 1], dtype=np.float32)
    lawn.data.uv_layers.new(name="UVMap").data.foreach_set("uv", corners)
    for number, name in enumerate(("Ground", "Fur"), 1):
        lawn.data.materials.append(diffuse_material(name))
        lawn.data.materials[-1].pass_index = 10 * number
    lawn.pass_index = 3
    lawn.modifiers.new("Fur", "PARTICLE_SYSTEM")
    fur = lawn.particle_systems[0].settings
    fur.type, fur.count, fur.hair_length, fur.material, fur.radius_scale = "HAIR", 60, 0.5, 2, 0.06
    add_light(scene, "POINT", location=(0, 0, 3))
    add_camera(scene, location=(0, -3, 2), rotation=(0.98, 0, 0))
    scene.cycles_curves.shape = "RIBBONS"
    ours, cycles = penumbra_passes(scene), cycles_passes(scene, 1)
    for name in ("Object Index", "Material Index"):
        assert (ours[name] != cycles[name]).mean() < 0.005, name
    strands, ground = (
        (ours["Material Index"][..., 0] == index) & (cycles["Material Index"][..., 0] == index) for index in (20, 10)
    )
    assert strands.sum() > 300 and ground.sum() > 300
    assert (ours["UV"][strands] == 0).all() and cycles["UV"][strands].max() > 0.5
    np.testing.assert_allclose(ours["UV"][ground], cycles["UV"][ground], atol=1e-5)
