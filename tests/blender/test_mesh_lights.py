# SPDX-License-Identifier: GPL-3.0-or-later
"""Emissive meshes against Cycles in the same Blender, and what becomes a luminaire."""

import bmesh
import bpy
import numpy as np
import pytest
from cycles_reference import colour, converge_cycles, relative_rmse, render_with_penumbra
from helpers import add_camera, add_cube, add_mesh, add_plane, diffuse_material, emissive_material, link, render_pixels
from recording import record

LAMPS = {
    "ball": lambda scene: add_ball(scene, location=(0.3, -0.2, 1.5)),
    "card": lambda scene: add_plane(scene, "Lamp", size=1.0, location=(0.5, 0, 1.2), rotation=(0.9, 0.3, 0.0)),
    "cube": lambda scene: add_cube(scene, "Lamp", size=0.5, location=(-0.5, 0.2, 1.0), scale=(1, 2, -0.5)),
}


def add_ball(scene, segments=48, **transform):
    """A sphere of radius 0.4."""
    mesh = bpy.data.meshes.new("Lamp")
    shape = bmesh.new()
    bmesh.ops.create_uvsphere(shape, u_segments=segments, v_segments=segments // 2, radius=0.4)
    shape.to_mesh(mesh)
    shape.free()
    return link(scene, "Lamp", mesh, **transform)


@pytest.mark.parametrize("rule", ["FIXED", "BOUNDED"])
@pytest.mark.parametrize("lamp", LAMPS.values(), ids=LAMPS)
def test_a_lamp_lights_the_floor_as_in_cycles(scene, lamp, rule):
    """Seen from below the lamp, so that only the floor shows. Tolerance 1 % in the mean; the relative RMSE at most
    0.5 % above 1.2 times Cycles' own noise, which is 6 % for a ball: Cycles 3 picks triangles of its far side, too."""
    add_plane(scene, "Floor", size=10.0)
    add_cube(scene, "Box", size=0.4, location=(0.9, -0.6, 0.2))
    lamp(scene).data.materials.append(emissive_material("Glow", (1.0, 0.6, 0.3), 8.0))
    add_camera(scene, location=(0, 0, 0.55), type="ORTHO", ortho_scale=6.0)
    cycles, noise = converge_cycles(scene, samples=512)
    ours, expected = colour(render_with_penumbra(scene)), colour(cycles)
    if rule == "BOUNDED":
        scene.penumbra.stop_rule, scene.penumbra.error_tolerance = "BOUNDED", 5e-4
        ours = colour(render_pixels(scene))
    assert expected.min() < 0.2 * expected.max()
    own_noise = relative_rmse(noise, expected)
    assert own_noise < 0.07
    np.testing.assert_allclose(ours.mean((0, 1)), expected.mean((0, 1)), rtol=1e-2)
    assert relative_rmse(ours - expected, expected) < 1.2 * own_noise + 5e-3


def test_slots_that_emit_are_luminaires(scene, monkeypatch):
    add_camera(scene)
    quad = add_mesh(scene, "Quads", [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 0), (2, 1, 0)],
                    [(0, 1, 2, 3), (1, 4, 5, 2)], location=(0, 0, 1))  # fmt: skip
    for material in (diffuse_material("Matt"), emissive_material("Glow", (1, 0.5, 0), 2.0)):
        quad.data.materials.append(material)
    quad.data.polygons[1].material_index = 1
    (light,) = record(scene, monkeypatch).lights
    assert light.radiance == (2.0, 1.0, 0.0) and len(light.triangles) == 2
    assert set(light.triangles.ravel()) == {1, 2, 4, 5}
    assert light.matrix[2, 3] == 1


@pytest.mark.parametrize("factor", [0.0, 0.25, 1.0])
def test_mixed_emission_is_weighted(scene, monkeypatch, factor):
    add_camera(scene)
    material = emissive_material("Glow", strength=4.0)
    tree = material.node_tree
    mix, matt = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeBsdfDiffuse")
    mix.inputs[0].default_value = factor
    tree.links.new(matt.outputs[0], mix.inputs[1])
    tree.links.new(tree.nodes["Emission"].outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    add_plane(scene).data.materials.append(material)
    lights = record(scene, monkeypatch).lights
    assert [light.radiance[0] for light in lights] == ([4.0 * factor] if factor else [])


def test_principled_emission(scene, monkeypatch):
    add_camera(scene)
    material = bpy.data.materials.new("Plastic")
    material.use_nodes = True
    add_plane(scene).data.materials.append(material)
    assert record(scene, monkeypatch).lights == []
    node = material.node_tree.nodes["Principled BSDF"]
    colour_socket = node.inputs.get("Emission Color") or node.inputs["Emission"]
    colour_socket.default_value = (0.5, 1, 0, 1)
    node.inputs["Emission Strength"].default_value = 3.0
    assert record(scene, monkeypatch).lights[0].radiance == (1.5, 3.0, 0.0)


def test_an_object_that_no_reflected_rays_see_lights_nothing(scene, monkeypatch):
    add_camera(scene)
    lamp = add_plane(scene)
    lamp.data.materials.append(emissive_material("Glow"))
    lamp.visible_diffuse = False
    (light,) = record(scene, monkeypatch).lights
    assert not light.role.diffuse and light.role.glossy
    lamp.visible_glossy = False
    assert record(scene, monkeypatch).lights == []
