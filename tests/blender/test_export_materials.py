# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials become Lambert's law with the right colour, and one note says what was left out."""

import bpy
import numpy as np
import pytest
from helpers import add_plane, diffuse_material, render_pixels
from penumbra import compat

ORANGE = (0.8, 0.4, 0.1)


@pytest.fixture
def colour_of(lit_scene, recorded):
    """A function material -> (exported diffuse colour, notes)."""
    plane = add_plane(lit_scene)

    def export(material):
        plane.data.materials.clear()
        plane.data.materials.append(material)
        found = recorded()
        return found.materials[0].diffuse, found.notes

    return export


@pytest.fixture
def notes_of(lit_scene, recorded):
    """A function material -> notes."""
    plane = add_plane(lit_scene)

    def export(material):
        plane.data.materials.clear()
        plane.data.materials.append(material)
        return recorded().notes

    return export


def shader(kind: str, name="Material"):
    """A material with this shader node at its surface: (material, node, node tree)."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    node, output = tree.nodes.new(kind), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    return material, node, tree


def test_diffuse(colour_of):
    colour, notes = colour_of(diffuse_material("Orange", ORANGE))
    np.testing.assert_allclose(colour, ORANGE, rtol=1e-6)
    assert notes == []


def test_principled_notes_what_it_leaves_out(notes_of):
    material, node, _ = shader("ShaderNodeBsdfPrincipled")
    node.inputs["Anisotropic"].default_value = 0.5
    assert notes_of(material) == [
        "material 'Material': node 'Principled BSDF': Anisotropic not supported yet and ignored"
    ]


@pytest.mark.skipif(
    compat.PRINCIPLED_HAS_LAYERS, reason="diffuse takes the light that is let through since Blender 4.0"
)
def test_glass_is_black_and_a_note_says_so(lit_scene, notes_of):
    material, node, _ = shader("ShaderNodeBsdfPrincipled")
    node.inputs["Transmission"].default_value = 1.0
    (note,) = notes_of(material)
    assert note.startswith("material 'Material': node 'Principled BSDF': Transmission is not supported yet; its share")
    assert render_pixels(lit_scene)["Combined"][..., :3].max() == 0
    node.inputs["Transmission"].default_value = 0.0
    assert render_pixels(lit_scene)["Combined"][..., :3].max() > 0.01


@pytest.mark.skipif(bpy.app.version >= (5, 0), reason="materials always use nodes from Blender 5.0 on")
def test_without_nodes(colour_of):
    material = bpy.data.materials.new("Plain")
    material.diffuse_color = (*ORANGE, 1)
    colour, notes = colour_of(material)
    np.testing.assert_allclose(colour, ORANGE, rtol=1e-6)
    assert notes == []


def test_colour_from_an_rgb_node_through_reroutes(colour_of):
    material, node, tree = shader("ShaderNodeBsdfDiffuse")
    rgb, reroute = tree.nodes.new("ShaderNodeRGB"), tree.nodes.new("NodeReroute")
    rgb.outputs[0].default_value = (*ORANGE, 1)
    tree.links.new(rgb.outputs[0], reroute.inputs[0])
    tree.links.new(reroute.outputs[0], node.inputs["Color"])
    colour, notes = colour_of(material)
    np.testing.assert_allclose(colour, ORANGE, rtol=1e-6)
    assert notes == []


@pytest.mark.parametrize(("second", "noted"), [("Transparent", 0.9), ("Transparent", 0.1), ("Diffuse", 0.9)])
def test_a_sum_of_transparent_shaders_above_one_is_noted(notes_of, second, noted):
    material, add, tree = shader("ShaderNodeAddShader")
    for socket, kind in zip(add.inputs, ("Transparent", second), strict=True):
        node = tree.nodes.new(f"ShaderNodeBsdf{kind}")
        node.inputs["Color"].default_value = (noted, 0.5, 0.5, 1)
        tree.links.new(node.outputs[0], socket)
    too_much = second == "Transparent" and noted == 0.9
    assert notes_of(material) == too_much * [
        "material 'Material': node 'Add Shader': adds transparent shaders; in shadows no more than all light goes "
        "through"
    ]


def test_an_unknown_node_falls_back_to_the_sockets_value(notes_of, lit_scene):
    material, node, tree = shader("ShaderNodeBsdfDiffuse")
    node.inputs["Color"].default_value = (*ORANGE, 1)
    tree.links.new(tree.nodes.new("ShaderNodeTexVoronoi").outputs["Color"], node.inputs["Color"])
    assert notes_of(material) == [
        "material 'Material': node 'Voronoi Texture' is not supported yet at 'Color'; the socket's own value was used"
    ]
    falling_back = render_pixels(lit_scene)["Combined"]
    lit_scene.objects["Plane"].data.materials[0] = diffuse_material("Orange", ORANGE)
    np.testing.assert_array_equal(falling_back, render_pixels(lit_scene)["Combined"])


def test_an_unknown_shader_is_diffuse_of_its_colour(notes_of, lit_scene):
    material, node, _ = shader("ShaderNodeBsdfGlass")
    node.inputs["Color"].default_value = (*ORANGE, 1)
    assert notes_of(material) == [
        "material 'Material': node 'Glass BSDF': is not supported yet; rendered with its colour as diffuse"
    ]
    falling_back = render_pixels(lit_scene)["Combined"]
    lit_scene.objects["Plane"].data.materials[0] = diffuse_material("Orange", ORANGE)
    np.testing.assert_array_equal(falling_back, render_pixels(lit_scene)["Combined"])


def test_a_material_without_varying_inputs_costs_nothing(recorded, lit_scene):
    """No attribute is exported, and the picture is that of the plain constant, bit for bit."""
    material, node, tree = shader("ShaderNodeBsdfDiffuse")
    maths = tree.nodes.new("ShaderNodeMath")
    maths.operation = "MULTIPLY"
    maths.inputs[0].default_value, maths.inputs[1].default_value = 0.5, 0.5
    tree.links.new(maths.outputs[0], node.inputs["Color"])
    plane = add_plane(lit_scene)
    plane.data.uv_layers.new(name="UVMap")
    plane.data.materials.append(material)
    computed = recorded()
    assert computed.mesh_of("Plane").attributes == {}
    plane.data.materials[0] = diffuse_material("Quarter", (0.25, 0.25, 0.25))
    np.testing.assert_array_equal(computed.pixels["Combined"], recorded().pixels["Combined"])


def test_no_surface_is_black_as_in_cycles(colour_of):
    material, _, tree = shader("ShaderNodeBsdfDiffuse")
    tree.links.clear()
    colour, notes = colour_of(material)
    assert colour == (0, 0, 0) and len(notes) == 1


def test_colours_are_clamped_to_what_reflects(colour_of):
    colour, notes = colour_of(diffuse_material("Bright", (1.5, 0.5, 0.0)))
    assert colour == (1.0, 0.5, 0.0)
    assert notes == ["material 'Bright': its colour was clamped to 0 ... 1"]


def test_one_note_for_a_material_used_by_many(lit_scene, recorded):
    material, _, _ = shader("ShaderNodeBsdfGlass")
    for x in range(5):
        add_plane(lit_scene, f"Plane {x}", location=(x, 0, 0)).data.materials.append(material)
    found = recorded()
    assert len(found.materials) == 1 and len(found.notes) == 1


def test_the_view_layers_override_replaces_every_material(lit_scene, recorded):
    add_plane(lit_scene).data.materials.append(diffuse_material("Own", (1, 0, 0)))
    lit_scene.view_layers[0].material_override = diffuse_material("Override", ORANGE)
    found = recorded()
    assert [material.name for material in found.materials] == ["Override"]


def test_a_colour_that_is_no_number_names_the_material(colour_of):
    with pytest.raises(RuntimeError, match="material 'Odd': its colour is not a finite number"):
        colour_of(diffuse_material("Odd", (float("nan"), 0.5, 0.5)))


def test_transparent_film(lit_scene, recorded):
    add_plane(lit_scene, size=1.0)
    lit_scene.render.film_transparent = True
    pixels = recorded().pixels["Combined"]
    assert pixels[0, 0].tolist() == [0, 0, 0, 0]
    assert pixels[24, 32, 3] == 1
