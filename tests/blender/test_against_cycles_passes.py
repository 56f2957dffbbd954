# SPDX-License-Identifier: GPL-3.0-or-later
"""The passes of light, colour, index and matte against Cycles', by the same names.

What a pass shows without chance (colours, emission, mist, UV, indices) is equal but for single precision, away from
edges, where the two engines' centre rays may fall on different sides. Light is equal within Cycles' own noise.
"""

import json

import bpy
import numpy as np
import pytest
from helpers import (
    add_area_light,
    add_camera,
    add_cube,
    add_plane,
    diffuse_material,
    read_metadata,
    render_pixels,
    render_to_file,
)
from passes_scene import (
    GROUPS,
    SWITCHES,
    build,
    by_name,
    cycles_passes,
    mirror_material,
    penumbra_passes,
    switch_on,
    use_cycles_as_reference,
)
from penumbra.cryptomatte import matte_id

EXACT = ("Diffuse Color", "Glossy Color", "Emission", "Environment", "Mist", "UV", "Object Index", "Material Index")
LIGHT = ("Combined", "Diffuse Direct", "Glossy Direct", *(f"Combined_{group}" for group in GROUPS))
SHADOW = bpy.app.version < (4, 0, 0)
"""Cycles has no pass Shadow since Blender 4."""


def behind_pane(passes) -> np.ndarray:
    """(height, width) bool: two objects share the pixel; away from edges that is the pane's doing."""
    return passes["CryptoObject00"][..., 3] > 0.1


def inside(passes) -> np.ndarray:
    """(height, width) bool: pixels whose 8 neighbours show the same object and side of it, pane included."""
    pane = behind_pane(passes)[..., None]
    ids = np.sort(passes["CryptoObject00"][..., 0::2], axis=-1)  # in any order, of the pane and what is behind it
    image = np.concatenate([passes["Object Index"], np.where(pane, 0, passes["Normal"]).round(3), ids], axis=-1)
    height, width = image.shape[:2]
    grown = np.pad(image, ((1, 1), (1, 1), (0, 0)), mode="edge")
    same = [np.all(grown[y : y + height, x : x + width] == image, -1) for y in range(3) for x in range(3)]
    return np.all(same, axis=0)


@pytest.fixture(scope="module")
def pictures(engine):
    """(ours, Cycles', Cycles' with another seed), centre rays."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.engine = engine
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 64, 48, 100
    scene.view_settings.view_transform = "Standard"
    layer = scene.view_layers[0]
    layer.use_pass_z = layer.use_pass_normal = layer.use_pass_position = True
    build(scene)
    scene.penumbra.pixel_samples, scene.penumbra.error_tolerance = 1, 0.001
    return penumbra_passes(scene), cycles_passes(scene, 400, 0), cycles_passes(scene, 400, 1)


@pytest.mark.parametrize("name", EXACT)
def test_passes_without_chance_are_equal(pictures, name):
    """Behind the pane of glass Cycles draws lots; its UV there are those of the samples that went on."""
    ours, cycles, _ = pictures
    where, pane = inside(cycles), behind_pane(cycles)
    clear = where & ~pane
    assert clear.mean() > 0.5 and (where & pane).sum() >= 15
    assert cycles[name][clear].std() > 0.01  # it has something to tell
    np.testing.assert_allclose(ours[name][clear], cycles[name][clear], atol=2e-4)
    if name != "UV":
        np.testing.assert_allclose(ours[name][where & pane], cycles[name][where & pane], atol=0.01)


@pytest.mark.parametrize("name", LIGHT)
def test_light_is_equal_within_noise(pictures, name):
    """RMSE up to 1.3 times Cycles' noise (two seeds' difference has sqrt 2 times that of each, and ours has some,
    too); means within 1 % and four standard errors."""
    ours, cycles, other = (passes[name][..., :3] for passes in pictures)
    where = inside(pictures[1])
    noise = (cycles - other)[where] / np.sqrt(2)
    difference = (ours - (cycles + other) / 2)[where]
    expected = cycles[where].mean()
    assert expected > 0.001
    assert np.sqrt(np.mean(difference**2)) < 1.3 * np.sqrt(np.mean(noise**2)) + 0.002 * expected
    error_of_mean = np.sqrt(np.mean(noise**2) / noise.size)
    assert abs(difference.mean()) < 0.01 * expected + 4 * error_of_mean


@pytest.mark.skipif(not SHADOW, reason="Cycles has no pass Shadow since Blender 4")
def test_shadow_of_one_small_light_is_that_of_cycles(scene):
    """With one luminaire that looks equally bright from all over the floor both define the share alike."""
    switch_on(scene.view_layers[0], "Shadow")
    add_plane(scene, size=6.0)
    add_cube(scene, size=1.0, location=(0, 0, 1.0))
    add_area_light(scene, size=0.5, location=(0.5, 0.0, 4.0))
    add_camera(scene, location=(0, 0, 10))
    ours, cycles = penumbra_passes(scene)["Shadow"], cycles_passes(scene, 256)["Shadow"]
    lit = cycles.max(-1) > 0
    assert np.mean(cycles < 0.5) > 0.05
    assert abs(ours.mean() - cycles.mean()) < 0.005
    assert np.sqrt(np.mean((ours - cycles)[lit] ** 2)) < 0.03


def total(passes) -> np.ndarray:
    """Combined as Blender's manual has it, of direct light."""
    return (
        passes["Diffuse Direct"] * passes["Diffuse Color"]
        + (passes["Glossy Direct"] + passes["Glossy Indirect"]) * passes["Glossy Color"]
        + passes["Emission"]
        + passes["Environment"]
    )


@pytest.mark.parametrize("pixel_samples", [1, 16], ids=["centre", "antialiased"])
def test_the_passes_add_up_to_combined_and_do_not_change_it(scene, pixel_samples):
    build(scene)
    scene.penumbra.pixel_samples = pixel_samples
    ours = penumbra_passes(scene)
    np.testing.assert_allclose(total(ours), ours["Combined"][..., :3], rtol=1e-5, atol=1e-5)
    groups = sum(ours[f"Combined_{group}"] for group in GROUPS)
    np.testing.assert_allclose(groups, ours["Combined"][..., :3], rtol=1e-5, atol=1e-5)
    layer = scene.view_layers[0]
    for switch in SWITCHES.values():
        setattr(layer, f"use_pass_{switch}", False)
    for _ in GROUPS:
        bpy.ops.scene.view_layer_remove_lightgroup()
    alone = penumbra_passes(scene)
    assert set(alone) == {"Combined", "Depth", "Normal", "Position", "Light Samples", "Error Estimate"}
    assert np.array_equal(alone["Combined"], ours["Combined"])


def test_mirrors_are_told_as_cycles_tells_them(scene):
    """A mirror shows a lit floor (Glossy Indirect), a lamp and the sky (Glossy Direct)."""
    build(scene)
    mirror = add_plane(scene, "Wall", size=3.0, location=(0, 2.2, 1.2), rotation=(1.4, 0, 0))
    mirror.data.materials.append(mirror_material())
    scene.penumbra.pixel_samples = 1
    for name in ("Box", "Child"):  # rough glossy surfaces would mirror in Cycles, too
        bpy.data.objects.remove(bpy.data.objects[name])
    ours, cycles = penumbra_passes(scene), cycles_passes(scene, 256, bounces=4)
    np.testing.assert_allclose(total(ours), ours["Combined"][..., :3], rtol=1e-5, atol=1e-5)
    for name in ("Glossy Direct", "Glossy Indirect", "Glossy Color"):
        assert cycles[name].mean() > 0.002, name
        assert abs(ours[name].mean() - cycles[name].mean()) < 0.02 * cycles[name].mean(), name


def test_antialiased_colours_and_mattes_are_those_of_cycles(scene):
    """The same filter in both; 256 samples' coverage at an edge is within 0.5 x 256^-1/2 = 0.03 one time out of three.
    Ours come from 4 samples inside and 16 or more at edges, whose standard deviation is 0.5 x 16^-3/4 = 0.06."""
    build(scene)
    scene.penumbra.pixel_samples = 16
    ours = penumbra_passes(scene)
    cycles = cycles_filtered(scene, 256)
    for name in ("Diffuse Color", "Emission", "Mist"):
        assert np.sqrt(np.mean((ours[name] - cycles[name]) ** 2)) < 0.03, name
        assert abs(np.mean(ours[name] - cycles[name])) < 0.005, name
    for kind in ("CryptoObject00", "CryptoMaterial00", "CryptoAsset00"):
        mine, theirs = ours[kind], cycles[kind]
        ids = np.unique(theirs[..., 0::2])
        assert set(np.unique(mine[..., 0::2])) == set(ids), kind
        for one in ids[ids != 0]:
            error = coverage(mine, one) - coverage(theirs, one)
            assert np.sqrt(np.mean(error**2)) < 0.03 and abs(error.mean()) < 0.003, (kind, one)


def coverage(matte, matte_id) -> np.ndarray:
    """(height, width): how much of each pixel is the id's."""
    return np.where(matte[..., 0::2] == matte_id, matte[..., 1::2], 0.0).sum(-1)


def cycles_filtered(scene, samples: int) -> dict[str, np.ndarray]:
    """Cycles' passes with Penumbra's default pixel filter."""
    use_cycles_as_reference(scene, samples)
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BLACKMAN_HARRIS", 1.5
    return by_name(render_pixels(scene, "CYCLES"))


def test_cryptomattes_manifest_is_that_of_cycles(scene, tmp_path):
    build(scene)
    add_plane(scene, "Größe", size=0.2)  # other than ASCII, and without a material
    found = {}
    for engine in ("PENUMBRA", "CYCLES"):
        use_cycles_as_reference(scene, 1)
        render_to_file(scene, engine, tmp_path / f"{engine}.exr")
        metadata = read_metadata(tmp_path / f"{engine}.exr")
        found[engine] = {name: text for name, text in metadata.items() if name.startswith("cryptomatte/")}
    assert len(found["CYCLES"]) == 12
    assert set(found["PENUMBRA"]) == set(found["CYCLES"])
    for name, text in found["CYCLES"].items():
        if not name.endswith("/manifest"):
            assert found["PENUMBRA"][name] == text, name
            continue
        mine, theirs = json.loads(found["PENUMBRA"][name]), json.loads(text)
        assert mine and mine.items() <= theirs.items(), name


def test_blenders_cryptomatte_node_picks_an_object(scene):
    """Its matte of the box is the box's coverage, during the render and with the manifest's names."""
    build(scene)
    scene.penumbra.pixel_samples = 16
    expected = penumbra_passes(scene)["CryptoObject00"]
    tree, output = compositor(scene)
    tree.nodes.new("CompositorNodeRLayers")  # without one Blender renders nothing
    node = tree.nodes.new("CompositorNodeCryptomatteV2")
    node.source, node.scene = "RENDER", scene
    node.layer_name = f"{scene.view_layers[0].name}.CryptoObject"
    node.matte_id = "Box"
    tree.links.new(node.outputs["Matte"], output)
    matte = penumbra_passes(scene)["Composite.Combined"][..., 0]
    wanted = coverage(expected, np.float32(matte_id("Box")))
    assert 0.02 < wanted.mean() < 0.5
    np.testing.assert_allclose(matte, wanted, atol=1e-5)


def compositor(scene):
    """(tree, input socket of what becomes the picture)."""
    if hasattr(scene, "compositing_node_group"):  # Blender 5
        tree = scene.compositing_node_group = bpy.data.node_groups.new("Compositing", "CompositorNodeTree")
        tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
        return tree, tree.nodes.new("NodeGroupOutput").inputs[0]
    scene.use_nodes = True
    scene.node_tree.nodes.clear()
    return scene.node_tree, scene.node_tree.nodes.new("CompositorNodeComposite").inputs[0]


def test_a_light_groups_picture_is_that_of_its_lights_alone(scene):
    """Each group against a render where the others' lights are off: the same points, so equal but for rounding."""
    build(scene)
    scene.penumbra.stop_rule, scene.penumbra.pixel_samples = "FIXED", 1
    together = penumbra_passes(scene)
    for thing in ("Rim", "Lamp"):
        bpy.data.objects[thing].hide_render = True
    scene.world.node_tree.nodes["Background"].inputs[1].default_value = 0.0
    add_plane(scene, "Black lamp", size=0.9, location=(0.9, 1.2, 0.5), rotation=(1.3, 0, 0)).data.materials.append(
        diffuse_material("Black", (0, 0, 0))
    )
    alone = penumbra_passes(scene)["Combined"][..., :3]
    difference = together["Combined_key"] - alone
    assert alone.mean() > 0.05 and together["Combined_rest"].mean() > 0.02
    # Other points on the light, as its number is another: half the light's points' noise at 64 of them.
    assert np.sqrt(np.mean(difference**2)) < 0.01 * alone.mean()
    assert abs(difference.mean()) < 0.001 * alone.mean()
