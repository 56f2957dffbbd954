# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights: shape, place, power by the version's law; what is left out is noted, what is broken is an error."""

import math

import bpy
import numpy as np
import pytest
from helpers import add_area_light, add_camera, add_light, add_plane, link, render_pixels
from recording import record

WATTS_PER_RADIANCE = 4.0 if bpy.app.version < (4, 0) else math.pi
"""P = this x A x L, measured against Cycles (test_against_cycles.py checks it in the running Blender)."""

AREAS = {
    "SQUARE": (2.0, 3.0, 4.0),
    "RECTANGLE": (2.0, 3.0, 6.0),
    "DISK": (2.0, 3.0, math.pi),
    "ELLIPSE": (2.0, 3.0, 1.5 * math.pi),
}


@pytest.fixture
def recorded(scene, monkeypatch):
    add_camera(scene)
    return lambda: record(scene, monkeypatch)


@pytest.mark.parametrize("scale", [(1, 1, 1), (0.5, 3.0, 7.0), (-2.0, 1.0, 1.0)])
@pytest.mark.parametrize("shape", AREAS)
def test_radiance_follows_from_power_and_true_area(scene, recorded, shape, scale):
    size_x, size_y, area = AREAS[shape]
    add_area_light(scene, shape=shape, size=size_x, size_y=size_y, power=50.0, color=(1.0, 0.5, 0.25),
                   rotation=(0.4, 0.5, 0.6), scale=scale)  # fmt: skip
    (light,) = recorded().lights
    area *= abs(scale[0] * scale[1])
    np.testing.assert_allclose(light.radiance, 50 / (WATTS_PER_RADIANCE * area) * np.array([1, 0.5, 0.25]), rtol=1e-6)
    assert light.shape == ("RECTANGLE" if shape in ("SQUARE", "RECTANGLE") else "ELLIPSE")
    assert light.size == (2.0, 2.0 if shape in ("SQUARE", "DISK") else 3.0)


def test_radiance_on_the_floor_is_that_of_the_closed_form(scene):
    """1 m below the middle of a 1 x 1 m light: L_out = albedo L F, F = 4 x the form factor of its 0.5 x 0.5 corner."""
    add_plane(scene, size=50.0)
    add_area_light(scene, size=1.0, power=100.0, location=(0, 0, 1))
    add_camera(scene, location=(0, 0, 0.5), type="ORTHO", ortho_scale=1e-3)
    scene.penumbra.stop_rule, scene.penumbra.light_samples = "FIXED", 4096
    x = 0.5
    factor = 4 / (2 * math.pi) * 2 * x / math.sqrt(1 + x * x) * math.atan(x / math.sqrt(1 + x * x))
    expected = 0.8 * 100 / WATTS_PER_RADIANCE * factor
    np.testing.assert_allclose(render_pixels(scene)["Combined"][..., :3], expected, rtol=1e-5)


def set_first(light, name: str, value: float) -> None:
    """Sets a property of a light, or its first component."""
    owner = light if name == "location" else light.data
    current = getattr(owner, name)
    setattr(owner, name, value if isinstance(current, float) else (value, *tuple(current)[1:]))


def test_instanced_lights_shine_from_each_place(scene, recorded):
    collection = bpy.data.collections.new("Lamps")
    light = add_area_light(scene, location=(0, 0, 1))
    scene.collection.objects.unlink(light)
    collection.objects.link(light)
    for x in (1.0, 2.0):
        empty = link(scene, f"Lamp {x}", None, location=(x, 0, 0))
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
    assert sorted(light.matrix[0, 3] for light in recorded().lights) == [1.0, 2.0]


def test_shadow_switch(scene, recorded):
    add_area_light(scene, "Casts")
    add_area_light(scene, "Does not").data.use_shadow = False
    assert {light.name: light.cast_shadow for light in recorded().lights} == {"Casts": True, "Does not": False}


@pytest.mark.parametrize("change", [{"energy": 0.0}, {"color": (0, 0, 0)}, {"size": 0.0}])
def test_lights_that_give_no_light_are_left_out(scene, recorded, change):
    light = add_area_light(scene)
    for name, value in change.items():
        setattr(light.data, name, value)
    found = recorded()
    assert found.lights == []
    assert not found.pixels["Combined"][..., :3].any()


def test_negative_power_takes_light_away(scene):
    add_plane(scene, size=20)
    add_camera(scene)
    add_area_light(scene, "Strong", power=200.0, location=(1, 0, 3))
    scene.penumbra.stop_rule = "FIXED"
    strong = render_pixels(scene)["Combined"][..., :3]
    add_area_light(scene, "Weak", power=-50.0, location=(1, 0, 3))
    np.testing.assert_allclose(render_pixels(scene)["Combined"][..., :3], 0.75 * strong, rtol=0.02)


def test_point_and_spot(scene, recorded):
    """Intensity P / (4 pi), whatever the radius; the spot's full angle in radians."""
    add_light(scene, "POINT", power=20.0, color=(1.0, 0.5, 0.0), data={"shadow_soft_size": 0.3}, location=(1, 2, 3))
    add_light(scene, "SPOT", "Spot", power=20.0, data={"spot_size": 1.2, "spot_blend": 0.4, "shadow_soft_size": 0.0})
    point, spot = recorded().lights
    np.testing.assert_allclose(point.intensity, 20 / (4 * math.pi) * np.array([1, 0.5, 0]), rtol=1e-6)
    np.testing.assert_allclose(spot.intensity, 20 / (4 * math.pi), rtol=1e-6)
    assert (point.radius, spot.radius) == (pytest.approx(0.3), 0.0)
    assert list(point.matrix[:3, 3]) == [1, 2, 3]
    assert not hasattr(point, "spot") and spot.spot == pytest.approx((1.2, 0.4))
    before_4 = bpy.app.version < (4, 0)
    assert point.shape == ("FACING_DISK" if before_4 or point_is_soft(scene) else "SPHERE")
    assert spot.cosine_falloff == before_4


def point_is_soft(scene) -> bool:
    return getattr(scene.objects["Light"].data, "use_soft_falloff", False)


def test_sun_shines_along_its_local_minus_z(scene, recorded):
    add_light(scene, "SUN", power=3.0, data={"angle": 0.01}, rotation=(math.pi / 2, 0, 0), scale=(2, 2, 2))
    (sun,) = recorded().lights
    np.testing.assert_allclose(sun.to_sun / np.linalg.norm(sun.to_sun), (0, -1, 0), atol=1e-6)
    assert sun.angle == pytest.approx(0.01)
    np.testing.assert_allclose(sun.irradiance, 3.0, rtol=1e-4)  # a flat disk's mean cosine, in Blender 3


def test_a_sun_as_wide_as_the_sky_needs_no_note(scene, recorded):
    """180 degrees in single precision, as Blender keeps them, are a little more; it takes no more than those."""
    add_light(scene, "SUN", power=3.0, data={"angle": 6.0})
    found = recorded()
    assert found.lights[0].angle == math.pi and found.notes == []


@pytest.mark.parametrize("kind", ["POINT", "SPOT", "SUN"])
def test_lights_without_power_are_left_out(scene, recorded, kind):
    add_light(scene, kind, power=0.0)
    assert recorded().lights == []


def test_spread(scene, recorded):
    add_area_light(scene).data.spread = math.radians(90)
    found = recorded()
    assert found.lights[0].spread == pytest.approx(math.pi / 2) and found.notes == []


def test_roles(scene, recorded):
    """Who sees a light, and what it lights, follows its ray visibility."""
    light = add_light(scene, "POINT")
    role = recorded().lights[0].role
    assert (role.to_camera, role.in_mirrors, role.diffuse, role.glossy) == (False, True, True, True)
    light.visible_camera = True
    light.visible_glossy = light.visible_diffuse = False
    found = recorded()
    role = found.lights[0].role
    assert (role.to_camera, role.in_mirrors, role.diffuse, role.glossy) == (True, False, False, False)
    assert found.notes == []


def test_emission_nodes_multiply(scene, recorded):
    light = add_light(scene, "POINT", power=4 * math.pi, color=(1.0, 0.5, 0.25)).data
    light.use_nodes = True
    emission = light.node_tree.nodes["Emission"]
    emission.inputs["Strength"].default_value = 2.0
    emission.inputs["Color"].default_value = (0.5, 1.0, 1.0, 1.0)
    found = recorded()
    np.testing.assert_allclose(found.lights[0].intensity, (1.0, 1.0, 0.5), rtol=1e-6)
    assert found.notes == []


@pytest.mark.parametrize(("node", "socket"), [("ShaderNodeTexChecker", "Color"), ("ShaderNodeTexIES", "Strength")])
def test_textured_emission_is_named(scene, recorded, node, socket):
    light = add_light(scene, "POINT", power=4 * math.pi).data
    light.use_nodes = True
    tree = light.node_tree
    texture = tree.nodes.new(node)
    tree.links.new(texture.outputs[0], tree.nodes["Emission"].inputs[socket])
    (note,) = recorded().notes
    assert note.startswith(f"light 'Light': node {texture.name!r}")
    assert "is not supported yet" in note and f"at {socket!r}" in note and "own" in note


def test_nodes_that_come_to_a_constant(scene, recorded):
    """A group around a Math node, a Blackbody and a Light Falloff node; unlinked light of the world is none."""
    light = add_light(scene, "POINT", power=4 * math.pi).data
    light.use_nodes = True
    tree = light.node_tree
    emission = tree.nodes["Emission"]
    falloff, double = tree.nodes.new("ShaderNodeLightFalloff"), tree.nodes.new("ShaderNodeMath")
    double.operation = "MULTIPLY"
    double.inputs[0].default_value, double.inputs[1].default_value = 3.0, 0.5
    tree.links.new(double.outputs[0], falloff.inputs["Strength"])
    tree.links.new(falloff.outputs["Quadratic"], emission.inputs["Strength"])
    mix = tree.nodes.new("ShaderNodeMixShader")
    mix.inputs[0].default_value = 0.5
    tree.links.new(emission.outputs[0], mix.inputs[1])
    tree.links.new(mix.outputs[0], tree.nodes["Light Output"].inputs["Surface"])
    found = recorded()
    np.testing.assert_allclose(found.lights[0].intensity, (0.75, 0.75, 0.75), rtol=1e-6)
    assert found.notes == []
    tree.links.new(falloff.outputs["Constant"], emission.inputs["Strength"])
    (note,) = recorded().notes
    assert "only quadratic" in note and "'Light Falloff'" in note


def test_a_light_whose_output_is_not_linked_is_dark(scene, recorded):
    light = add_light(scene, "POINT").data
    light.use_nodes = True
    light.node_tree.links.clear()
    assert recorded().lights == []


def test_untouched_nodes_are_no_reason_for_a_note(scene, recorded):
    add_area_light(scene).data.use_nodes = True
    found = recorded()
    assert found.notes == [] and len(found.lights) == 1


@pytest.mark.parametrize(
    ("name", "value"),
    [("energy", math.nan), ("energy", math.inf), ("size", math.nan), ("color", math.nan), ("location", math.nan)],
)
def test_values_that_are_no_numbers_are_an_error_that_names_the_light(scene, name, value):
    add_camera(scene)
    set_first(add_area_light(scene, "Broken lamp"), name, value)
    with pytest.raises(RuntimeError, match="light 'Broken lamp': its .* is not a finite number"):
        render_pixels(scene)


@pytest.mark.parametrize(
    ("kind", "name"), [("POINT", "shadow_soft_size"), ("SPOT", "spot_blend"), ("SUN", "angle"), ("SUN", "energy")]
)
def test_other_lights_of_no_finite_size_are_an_error_too(scene, kind, name):
    add_camera(scene)
    light = add_light(scene, kind, "Broken lamp")
    setattr(light.data, name, math.nan)
    if not math.isnan(getattr(light.data, name)):
        pytest.skip("Blender itself corrects the value")
    with pytest.raises(RuntimeError, match="light 'Broken lamp': its .* is not a finite number"):
        render_pixels(scene)


@pytest.mark.parametrize("name", ["size", "color", "location"])
def test_the_largest_values_that_blender_holds_leave_a_finite_picture(scene, name):
    add_plane(scene)
    add_camera(scene)
    set_first(add_area_light(scene), name, math.inf)  # Blender makes the largest float of it
    assert np.isfinite(render_pixels(scene)["Combined"]).all()
