# SPDX-License-Identifier: GPL-3.0-or-later
"""Area lights: size, place, radiance by the version's law; what is left out is noted, what is broken is an error."""

import math

import bpy
import numpy as np
import pytest
from helpers import add_area_light, add_camera, add_plane, link, render_pixels
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


@pytest.mark.parametrize("kind", ["POINT", "SUN", "SPOT"])
def test_other_lights_are_left_out_with_one_note(scene, recorded, capfd, kind):
    data = bpy.data.lights.new("Data", kind)
    for name in ("Lamp A", "Lamp B"):
        link(scene, name, data)
    found = recorded()
    assert found.lights == []
    assert found.notes == [
        f"light 'Lamp {x}': {kind.lower()} lights are not supported yet and were left out" for x in "AB"
    ]
    assert capfd.readouterr().out.count("Penumbra note: light 'Lamp A'") == 1


def test_ignored_features_share_one_note(scene, recorded):
    light = add_area_light(scene).data
    light.spread = math.radians(90)
    light.use_nodes = True
    light.node_tree.nodes["Emission"].inputs["Strength"].default_value = 2.0
    assert recorded().notes == ["light 'Light': spread below 180 degrees, nodes not supported yet and ignored"]


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


@pytest.mark.parametrize("name", ["size", "color", "location"])
def test_the_largest_values_that_blender_holds_leave_a_finite_picture(scene, name):
    add_plane(scene)
    add_camera(scene)
    set_first(add_area_light(scene), name, math.inf)  # Blender makes the largest float of it
    assert np.isfinite(render_pixels(scene)["Combined"]).all()
