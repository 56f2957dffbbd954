# SPDX-License-Identifier: GPL-3.0-or-later
"""The passes, against Cycles and against each other; view layers; the same pixels however the render is cut up."""

import bpy
import numpy as np
import pytest
from helpers import add_area_light, add_cube, add_plane, render_pixels, use_cycles_as_reference

OWN = {"Combined", "Depth", "Normal", "Position", "Light Samples", "Error Estimate"}


@pytest.fixture
def cube_scene(lit_scene):
    """A cube on a floor that fills a part of the picture."""
    add_plane(lit_scene, size=5.0)
    add_cube(lit_scene, size=1.5, location=(0, 0, 0.75), rotation=(0.2, 0.3, 0.4))
    return lit_scene


def away_from_edges(depth: np.ndarray) -> np.ndarray:
    """Pixels whose neighbours all lie on the same face, near enough: (H, W) bool."""
    bend = np.zeros(depth.shape, bool)
    for axis in (0, 1):
        step = np.abs(np.diff(depth, 2, axis=axis)) > 1e-3 * np.abs(depth).min()
        inside = [slice(None), slice(None)]
        for start in (0, 1, 2):
            inside[axis] = slice(start, start + step.shape[axis])
            bend[tuple(inside)] |= step
    return ~bend


def test_depth_normal_and_position_are_those_of_cycles(cube_scene):
    ours = render_pixels(cube_scene)
    use_cycles_as_reference(cube_scene, samples=1)
    cycles = render_pixels(cube_scene, "CYCLES")
    compare = away_from_edges(cycles["Depth"][..., 0])
    assert compare.mean() > 0.6
    hit = compare & (cycles["Depth"][..., 0] < 1e9)
    miss = compare & ~hit
    np.testing.assert_allclose(ours["Depth"][hit], cycles["Depth"][hit], rtol=1e-3)
    np.testing.assert_allclose(ours["Position"][hit], cycles["Position"][hit], atol=2e-3)
    np.testing.assert_allclose(ours["Normal"][hit], cycles["Normal"][hit], atol=1e-4)
    for name in ("Depth", "Normal", "Position"):
        assert np.array_equal(ours[name][miss], cycles[name][miss]), name


def test_every_pass_is_delivered_finite_and_can_be_switched_off(cube_scene):
    pixels = render_pixels(cube_scene)
    assert set(pixels) == OWN
    assert all(np.isfinite(p).all() for p in pixels.values())
    layer = cube_scene.view_layers[0]
    layer.use_pass_z = layer.use_pass_normal = layer.use_pass_position = False
    layer.penumbra.use_pass_light_samples = layer.penumbra.use_pass_error_estimate = False
    alone = render_pixels(cube_scene)
    assert set(alone) == {"Combined"}
    assert np.array_equal(alone["Combined"], pixels["Combined"])


def test_light_samples_count_points(cube_scene):
    cube_scene.penumbra.stop_rule, cube_scene.penumbra.light_samples = "FIXED", 48
    add_area_light(cube_scene, "Second", location=(0, 2, 4))
    pixels = render_pixels(cube_scene)
    floor = (np.abs(pixels["Position"][..., 2]) < 1e-4) & (pixels["Depth"][..., 0] < 1e9)
    assert np.all(pixels["Light Samples"][floor] == 2 * 48)
    assert np.all(pixels["Light Samples"][pixels["Depth"][..., 0] > 1e9] == 0)


def test_exposure_changes_the_error_estimate_and_nothing_else(cube_scene):
    cube_scene.penumbra.stop_rule = "FIXED"
    before = render_pixels(cube_scene)
    cube_scene.view_settings.exposure = 2.0
    after = render_pixels(cube_scene)
    for name in OWN - {"Error Estimate"}:
        assert np.array_equal(before[name], after[name]), name
    np.testing.assert_allclose(after["Error Estimate"], 4 * before["Error Estimate"], rtol=1e-5)


def test_view_layers_are_rendered_each_with_its_own_objects(cube_scene):
    alone = render_pixels(cube_scene)
    collection = bpy.data.collections.new("Second")
    cube_scene.collection.children.link(collection)
    cube = add_cube(cube_scene, "Other", size=0.5, location=(-2, 0, 1))
    cube_scene.collection.objects.unlink(cube)
    collection.objects.link(cube)
    first = cube_scene.view_layers[0]
    second = cube_scene.view_layers.new("Second")
    second.penumbra.use_pass_error_estimate = False
    first.layer_collection.children["Second"].exclude = True
    pixels = render_pixels(cube_scene)
    for name in OWN:
        assert np.array_equal(pixels[f"{first.name}.{name}"], alone[name]), name
    assert "Second.Error Estimate" not in pixels
    assert not np.array_equal(pixels["Second.Combined"], alone["Combined"])


def test_the_number_of_threads_changes_no_bit(cube_scene):
    cube_scene.render.threads_mode = "FIXED"
    pictures = []
    for threads in (1, 2, 5):
        cube_scene.render.threads = threads
        pictures.append(render_pixels(cube_scene))
    for other in pictures[1:]:
        assert all(np.array_equal(pictures[0][name], other[name]) for name in OWN)


@pytest.mark.parametrize(
    ("stop_rule", "reuse"),
    [
        ("BOUNDED", "SCRAMBLED"),
        ("VARIANCE", "SCRAMBLED"),
        ("PAPER", "SAME"),
        ("PAPER", "CONTINUED"),
        ("PAPER", "ROTATED"),
        ("PAPER", "SCRAMBLED"),
    ],
)
def test_two_borders_join_to_the_whole_picture(cube_scene, stop_rule, reuse):
    cube_scene.penumbra.stop_rule, cube_scene.penumbra.sample_reuse = stop_rule, reuse
    whole = render_pixels(cube_scene)
    render = cube_scene.render
    render.use_border, render.use_crop_to_border = True, True
    halves = []
    for render.border_min_x, render.border_max_x in ((0.0, 0.4), (0.4, 1.0)):
        halves.append(render_pixels(cube_scene))
    for name in OWN:
        joined = np.concatenate([half[name] for half in halves], axis=1)
        assert np.array_equal(joined, whole[name]), name
