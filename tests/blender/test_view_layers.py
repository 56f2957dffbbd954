# SPDX-License-Identifier: GPL-3.0-or-later
"""View layers, each with its own collections, holdouts, indirect-only objects, override, samples and passes."""

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
    use_cycles_as_reference,
)
from passes_scene import mirror_material, switch_on
from penumbra import statistics


@pytest.fixture
def two_layers(scene):
    """A floor, and a cube in the collection "Cubes"; (scene, first layer, second layer "Second")."""
    add_plane(scene, "Floor", size=6.0)
    collection = bpy.data.collections.new("Cubes")
    scene.collection.children.link(collection)
    cube = add_cube(scene, "Cube", size=1.0, location=(0, 0, 0.8))
    scene.collection.objects.unlink(cube)
    collection.objects.link(cube)
    add_area_light(scene, location=(0.5, 0.0, 4.0))
    add_camera(scene, location=(0, -3, 6), rotation=(0.45, 0, 0))
    first, second = scene.view_layers[0], scene.view_layers.new("Second")
    first.name = "First"
    return scene, first, second


def cubes(layer):
    return layer.layer_collection.children["Cubes"]


def both_engines(scene):
    """(ours, Cycles') passes, centre rays, every object with an index of its own."""
    for number, thing in enumerate(scene.objects, 1):
        thing.pass_index = number
    for layer in scene.view_layers:
        switch_on(layer, "Object Index")
        layer.use_pass_z = True
    use_cycles_as_reference(scene, 64)
    return render_pixels(scene, "PENUMBRA"), render_pixels(scene, "CYCLES")


def away_from_steps(values) -> np.ndarray:
    """(height, width) bool: no neighbour of the pixel differs."""
    step = np.zeros(values.shape[:2], bool)
    for axis in (0, 1):
        jump = np.any(np.diff(values, axis=axis) != 0, axis=-1)
        low, high = [slice(None)] * 2, [slice(None)] * 2
        low[axis], high[axis] = slice(None, -1), slice(1, None)
        step[tuple(low)] |= jump
        step[tuple(high)] |= jump
    return ~step


@pytest.mark.parametrize("switch", ["exclude", "holdout", "indirect_only"])
@pytest.mark.parametrize("transparent", [False, True], ids=["opaque film", "transparent film"])
def test_a_layer_collections_switches_are_those_of_cycles(two_layers, switch, transparent):
    """Alpha is equal away from edges, Combined within Cycles' noise at 64 samples; the other layer has the cube."""
    scene, first, second = two_layers
    setattr(cubes(second), switch, True)
    scene.render.film_transparent = transparent
    ours, cycles = both_engines(scene)
    for layer in ("First", "Second"):
        mine, theirs = ours[f"{layer}.Combined"], cycles[f"{layer}.Combined"]
        where = away_from_steps(theirs[..., 3:]) & away_from_steps(cycles[f"First.{index_name(cycles)}"])
        assert where.mean() > 0.6
        np.testing.assert_allclose(mine[where][:, 3], theirs[where][:, 3], atol=1e-3)
        difference = (mine - theirs)[where][:, :3]
        assert np.sqrt(np.mean(difference**2)) < 0.02 * theirs[where][:, :3].mean()
        depth = np.s_[f"{layer}.Depth"]
        near = where & (cycles[depth][..., 0] < 1e9)
        assert np.array_equal(ours[depth][where] > 1e9, cycles[depth][where] > 1e9)
        np.testing.assert_allclose(ours[depth][near], cycles[depth][near], rtol=1e-3)
    assert not np.array_equal(ours["First.Combined"], ours["Second.Combined"])
    if switch == "holdout":
        assert (ours["Second.Combined"][..., 3] == 0).sum() > (ours["First.Combined"][..., 3] == 0).sum()


def index_name(passes) -> str:
    (name,) = {name.partition(".")[2] for name in passes} & {"IndexOB", "Object Index"}
    return name


def test_an_objects_own_holdout_is_a_hole_that_mirrors_do_not_have(two_layers):
    """The held-out cube has alpha 0 and no colour to the camera, and is seen in a mirror as it is without it."""
    scene, first, second = two_layers
    scene.view_layers.remove(second)
    mirror = add_plane(scene, "Mirror", size=3.0, location=(0, 1.5, 1.5), rotation=(1.4, 0, 0))
    mirror.data.materials.append(mirror_material())
    before = render_pixels(scene)
    bpy.data.objects["Cube"].is_holdout = True
    after = render_pixels(scene)
    hole = after["Combined"][..., 3] == 0
    assert 50 < hole.sum() < 1500
    assert not after["Combined"][hole].any()
    assert (before["Combined"][..., 3] == 1).all()
    assert np.array_equal(after["Combined"][~hole], before["Combined"][~hole])


def test_antialiased_holdouts_have_smooth_edges(two_layers):
    """Alpha of a held-out cube against 256 fixed rays' (standard deviation of one pixel 0.5 x 256^-3/4 = 0.008)."""
    scene, first, second = two_layers
    scene.view_layers.remove(second)
    cubes(first).holdout = True
    scene.penumbra.pixel_samples = 16
    bounded = render_pixels(scene)["Combined"]
    scene.penumbra.stop_rule, scene.penumbra.pixel_samples, scene.penumbra.light_samples = "FIXED", 256, 4
    fixed = render_pixels(scene)["Combined"]
    partial = (fixed[..., 3] > 0.02) & (fixed[..., 3] < 0.98)
    assert partial.sum() > 50
    error = (bounded[..., 3] - fixed[..., 3])[partial]
    assert np.abs(error.mean()) < 0.002 and np.sqrt(np.mean(error**2)) < 0.016


def test_material_override_and_samples_of_a_layer(two_layers):
    """The second layer is all white, and of more rays with the rule of fixed counts."""
    scene, first, second = two_layers
    second.material_override = diffuse_material("White", (1, 1, 1))
    scene.penumbra.stop_rule, scene.penumbra.light_samples = "FIXED", 16
    second.samples = 4
    switch_on(first, "Diffuse Color")
    switch_on(second, "Diffuse Color", "CryptoMaterial00")
    ours = render_pixels(scene)
    colour = {layer: ours[name] for layer in ("First", "Second") for name in ours
              if name.startswith(layer) and name.endswith(("DiffCol", "Diffuse Color"))}  # fmt: skip
    np.testing.assert_allclose(colour["First"], 0.8, rtol=1e-6)
    np.testing.assert_allclose(colour["Second"], 1.0, rtol=1e-6)
    rays = [layer["primary_rays"] for layer in statistics.last_render["view_layers"].values()]
    assert rays[1] == 4 * rays[0]


def test_a_layer_that_is_not_used_is_not_rendered(two_layers):
    scene, first, second = two_layers
    second.use = False
    ours = render_pixels(scene)
    assert "Combined" in ours and not any("Second" in name for name in ours)


def test_a_multilayer_file_has_each_layers_passes_and_manifests(two_layers, tmp_path):
    scene, first, second = two_layers
    switch_on(first, "Diffuse Direct", "CryptoObject00")
    switch_on(second, "Emission", "CryptoAsset00")
    first.pass_cryptomatte_depth, second.pass_cryptomatte_depth = 6, 3
    path = tmp_path / "layers.exr"
    render_to_file(scene, "PENUMBRA", path)
    from helpers import read_exr
    from penumbra import compat

    passes = set(read_exr(path))
    always = {"Combined", "Light Samples", "Error Estimate"}
    of_first = always | {"Depth", "Normal", "Position", compat.pass_name("Diffuse Direct")}
    of_first |= {f"CryptoObject{number:02d}" for number in range(3)}
    of_second = always | {compat.pass_name("Emission"), "CryptoAsset00", "CryptoAsset01"}
    assert passes == {f"First.{name}" for name in of_first} | {f"Second.{name}" for name in of_second}
    names = {text for name, text in read_metadata(path).items() if name.startswith("cryptomatte/") and "/name" in name}
    assert names == {"First.CryptoObject", "Second.CryptoAsset"}


def test_unsupported_passes_are_named_in_a_note(two_layers):
    scene, first, second = two_layers
    first.use_pass_vector = first.use_pass_ambient_occlusion = True
    render_pixels(scene)
    (note,) = [text for text in statistics.last_render["warnings"] if "there is no pass" in text]
    assert note == "view layer 'First': there is no pass Vector, Ambient Occlusion"


def test_a_shader_aov_is_named_in_a_note(two_layers):
    scene, first, _ = two_layers
    first.aovs.add().name = "Wetness"
    render_pixels(scene)
    (note,) = [text for text in statistics.last_render["warnings"] if "there is no pass" in text]
    assert note == "view layer 'First': there is no pass 'Wetness' (a shader AOV)"


def test_a_shadow_catcher_is_rendered_as_it_is_with_a_note(two_layers):
    scene, _, second = two_layers
    scene.view_layers.remove(second)
    plain = render_pixels(scene)["Combined"]
    scene.objects["Floor"].is_shadow_catcher = True
    assert np.array_equal(render_pixels(scene)["Combined"], plain)
    assert "object 'Floor': shadow catcher not supported yet and ignored" in statistics.last_render["warnings"]


def test_a_checkpoint_with_other_passes_is_refused_and_its_own_holds_them(two_layers, tmp_path):
    scene, first, second = two_layers
    scene.view_layers.remove(second)
    switch_on(first, "Diffuse Direct", "CryptoObject00", "UV")
    scene.penumbra.checkpoint_folder = str(tmp_path)
    whole = render_pixels(scene)
    again = render_pixels(scene)
    assert statistics.last_render["seconds"]["render"] == 0  # all from the checkpoint
    assert set(again) == set(whole) and all(np.array_equal(again[name], whole[name]) for name in whole)
    switch_on(first, "Emission")
    with pytest.raises(RuntimeError, match="cannot be continued"):
        render_pixels(scene)


def test_baking_is_refused_with_a_sentence(two_layers):
    scene, _, _ = two_layers
    floor = bpy.data.objects["Floor"]
    floor.data.uv_layers.new(name="UVMap")
    floor.select_set(True)
    bpy.context.view_layer.objects.active = floor
    with pytest.raises(RuntimeError, match="does not support baking"):
        bpy.ops.object.bake(type="DIFFUSE")
