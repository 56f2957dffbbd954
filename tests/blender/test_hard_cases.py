# SPDX-License-Identifier: GPL-3.0-or-later
"""The rows of the catalogue of hard cases in which Blender has a say (the others: tests/hard_cases): what cannot be
rendered is an error that names its object; odd but legal scenes render."""

import bpy
import numpy as np
import pytest
from helpers import add_area_light, add_camera, add_cube, add_mesh, add_plane, fails, link, render_pixels
from penumbra import native, statistics


def test_d40_no_camera(scene):
    fails(scene, "no camera")  # Blender's own check comes first


def test_panoramic_camera(scene):
    add_camera(scene, "Fisheye", type="PANO")
    fails(scene, "camera 'Fisheye': pano cameras are not supported")


def test_a_lamp_as_camera(scene):
    scene.camera = link(scene, "Lamp", bpy.data.lights.new("Lamp", "AREA"))
    fails(scene, "camera 'Lamp' is no camera")


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_d41_camera_at_no_place(scene, value):
    add_camera(scene, "Lost").matrix_world[0][3] = value
    fails(scene, "camera 'Lost': its position or rotation is not a finite number")


@pytest.mark.parametrize(
    ("settings", "text"),
    [
        ({"clip_start": 5.0, "clip_end": 2.0}, "clip start 5 m is not below clip end 2 m"),
        ({"clip_start": 2.0, "clip_end": 2.0}, "clip start 2 m is not below clip end 2 m"),
    ],
)
def test_d41_degenerate_cameras(scene, settings, text):
    add_camera(scene, "Odd", **settings)
    fails(scene, f"camera 'Odd': .*{text}")


def test_d41_orthographic_scale_of_zero(scene):
    add_camera(scene, "Odd", type="ORTHO", ortho_scale=0.0)
    if bpy.app.version < (5, 0, 0):
        fails(scene, "camera 'Odd': .* leaves nothing to see")
    else:  # Blender sees a nanometre then
        assert np.isfinite(render_pixels(scene)["Combined"]).all()


def test_d41_camera_of_no_scale(scene):
    add_camera(scene, "Flat").scale = (1, 0, 1)
    fails(scene, "camera 'Flat': its scale is zero")


def test_stereoscopy(scene):
    add_camera(scene)
    scene.render.use_multiview = True
    fails(scene, "camera 'Camera': stereoscopy")


def test_d36_a_vertex_that_is_no_number_names_the_object(lit_scene):
    broken = add_mesh(lit_scene, "Broken mesh", [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    broken.data.vertices[1].co.x = float("nan")
    fails(lit_scene, "Broken mesh: vertex 1 is not finite")


def test_settings_that_do_not_fit_are_both_named(lit_scene):
    lit_scene.penumbra.sampler, lit_scene.penumbra.stop_rule = "SPRS", "PAPER"
    fails(lit_scene, "(?s)SPRS.*stop_rule")
    lit_scene.penumbra.stop_rule, lit_scene.penumbra.light_samples = "FIXED", 60
    fails(lit_scene, "(?s)SPRS.*light_samples")


def test_d47_names_with_odd_characters(lit_scene):
    name = "Ünï 'quoted'\nline %s {x} 光"
    broken = add_mesh(lit_scene, name, [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    render_pixels(lit_scene)
    broken.data.vertices[1].co.x = float("nan")
    fails(lit_scene, "(?s)Ünï 'quoted'\nline %s {x} 光")


def test_an_unexpected_failure_is_an_error_too(lit_scene, monkeypatch):
    class Broken:
        def Scene(self):  # noqa: N802
            raise ZeroDivisionError("on purpose")

    monkeypatch.setattr(native, "module", Broken())
    fails(lit_scene, "internal failure: ZeroDivisionError: on purpose")


def test_a_worker_that_fails_is_an_error(lit_scene, monkeypatch):
    class Failing:
        """A render whose threads fail after a few buckets, as after an error inside Embree."""

        def __init__(self, render):
            self._render = render

        def __getattr__(self, name):
            return getattr(self._render, name)

        def finish(self):
            self._render.finish()
            raise RuntimeError("embree: out of memory")

    class Module:
        def __getattr__(self, name):
            return getattr(real, name)

        def Render(self, *arguments):  # noqa: N802
            return Failing(real.Render(*arguments))

    real = native.module
    monkeypatch.setattr(native, "module", Module())
    fails(lit_scene, "embree: out of memory")


def test_d40_an_empty_scene_is_its_background(scene):
    add_camera(scene)
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.25, 0.5, 1, 1)
    pixels = render_pixels(scene)["Combined"]
    np.testing.assert_allclose(pixels, np.broadcast_to([0.25, 0.5, 1, 1], pixels.shape))


def test_d40_no_lights_are_black(scene):
    add_camera(scene)
    add_plane(scene)
    assert not render_pixels(scene)["Combined"][..., :3].any()


@pytest.mark.parametrize("size", [(4, 4), (5, 300), (300, 5), (65, 63)])
def test_d45_odd_sizes(lit_scene, size):
    add_cube(lit_scene)
    lit_scene.render.resolution_x, lit_scene.render.resolution_y = size
    assert render_pixels(lit_scene)["Combined"].shape == (size[1], size[0], 4)


def test_d42_camera_inside_an_object(lit_scene):
    add_cube(lit_scene, size=40)
    assert np.isfinite(render_pixels(lit_scene)["Combined"]).all()


def test_a16_a_light_of_no_size_is_named_in_a_note(lit_scene):
    add_plane(lit_scene)
    lit_scene.objects["Light"].data.size = 0
    assert not render_pixels(lit_scene)["Combined"][..., :3].any()
    assert any("light 'Light': its area is zero" in note for note in statistics.last_render["warnings"])


@pytest.mark.parametrize("place", [0, 2**10, 2**20, 2**23])
def test_c31_places_that_float32_holds(scene, place):
    """Blender's matrices are float32: at multiples of a metre up to 2^23 m it knows them exactly, and the picture is
    that at the origin but for rounding in the camera's window, which moves single points across the cube's edges."""
    pictures = []
    for x in (0, place):
        for name in ("Floor", "Box", "Sun", "Eye"):
            if name in scene.objects:
                bpy.data.objects.remove(scene.objects[name])
        add_plane(scene, "Floor", size=32, location=(x, -x, 0))
        add_cube(scene, "Box", size=2, location=(x, -x, 1))
        add_area_light(scene, "Sun", size=2.0, power=400, location=(x + 3, -x, 6))
        add_camera(scene, "Eye", location=(x, -x, 16), type="ORTHO", ortho_scale=8.0)
        pictures.append(render_pixels(scene)["Combined"][..., 0])
    assert (np.abs(pictures[1] - pictures[0]) > 1e-3 * pictures[0].max()).mean() <= 0.01
    assert pictures[0].min() < 0.5 * pictures[0].max()


def test_d37_faces_without_area_are_counted_and_named(lit_scene):
    add_plane(lit_scene, size=20)
    add_mesh(lit_scene, "Sliver", [(0, 0, 1), (1, 0, 1), (2, 0, 1), (0, 0, 1)], [(0, 1, 2), (0, 1, 3)])
    assert np.isfinite(render_pixels(lit_scene)["Combined"]).all()
    assert "2 triangles without area were left out: 'Sliver'" in statistics.last_render["warnings"]


def test_d39_scale_zero_is_counted_and_named(lit_scene):
    add_plane(lit_scene, size=20)
    add_cube(lit_scene, "Flat", scale=(1, 0, 1))
    render_pixels(lit_scene)
    notes = statistics.last_render["warnings"]
    assert "1 objects whose scale is zero in some direction were left out: 'Flat'" in notes


def test_d39_hair_on_an_object_of_scale_zero_is_named(lit_scene):
    """Found by fuzzing: an internal failure."""
    add_plane(lit_scene, size=20)
    fur = add_plane(lit_scene, "Fur", scale=(1, 0, 1)).modifiers.new("Hair", "PARTICLE_SYSTEM").particle_system.settings
    fur.type, fur.count = "HAIR", 10
    assert np.isfinite(render_pixels(lit_scene)["Combined"]).all()
    notes = statistics.last_render["warnings"]
    assert "object 'Fur': its scale is zero in some direction, so it has no hair" in notes


def test_d45_an_empty_border(lit_scene):
    """Blender refuses it before the engine is asked."""
    render = lit_scene.render
    render.use_border, render.border_min_x, render.border_max_x = True, 0.5, 0.5
    fails(lit_scene, "too small")


def test_d49_a_stack_of_identical_faces(lit_scene):
    """50,000 squares at one place: modelling accidents do that. Rendered at once, counted and named."""
    corners = [(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)]
    faces = [tuple(range(i, i + 4)) for i in range(0, 200_000, 4)]
    add_mesh(lit_scene, "Stack", corners * 50_000, faces)
    picture = render_pixels(lit_scene)["Combined"]
    assert picture[..., :3].min() > 0
    text = "99998 triangles that are copies of others were left out: 'Stack'"
    assert text in statistics.last_render["warnings"]


@pytest.mark.parametrize("degrees", [180, 90, 1])
def test_a19_spread(scene, degrees):
    """From the whole hemisphere to a beam, the narrowest Blender has included: finite, without a note, and the narrower
    the brighter straight below the light, since its power stays the same (test_against_cycles_points.py has figures).
    """
    add_plane(scene, size=20)
    add_camera(scene, location=(0, 0, 3))
    light = add_area_light(scene, "Lamp", location=(0, 0, 4)).data
    widest = render_pixels(scene)["Combined"][..., 0]
    light.spread = np.radians(degrees)
    picture = render_pixels(scene)["Combined"][..., 0]
    assert np.isfinite(picture).all() and not statistics.last_render["warnings"]
    below = picture.shape[0] // 2, picture.shape[1] // 2
    assert picture[below] > 1.2 * widest[below] if degrees < 180 else (picture == widest).all()
