# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials become Lambert's law with the right colour, and one note says what was left out."""

import bpy
import numpy as np
import pytest
from helpers import add_plane, diffuse_material

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


def test_principled(colour_of):
    material, node, _ = shader("ShaderNodeBsdfPrincipled")
    node.inputs["Base Color"].default_value = (*ORANGE, 1)
    colour, notes = colour_of(material)
    np.testing.assert_allclose(colour, ORANGE, rtol=1e-6)
    assert notes == []


def test_principled_beyond_its_base_colour(colour_of):
    material, node, _ = shader("ShaderNodeBsdfPrincipled")
    node.inputs["Metallic"].default_value = 1.0
    node.inputs["Alpha"].default_value = 0.5
    _, notes = colour_of(material)
    assert notes == ["material 'Material': Alpha, Metallic of 'Principled BSDF' not supported yet and ignored"]


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


def test_a_texture_falls_back_to_the_sockets_colour(colour_of):
    material, node, tree = shader("ShaderNodeBsdfDiffuse")
    node.inputs["Color"].default_value = (*ORANGE, 1)
    noise = tree.nodes.new("ShaderNodeTexNoise")
    tree.links.new(noise.outputs["Color"], node.inputs["Color"])
    colour, notes = colour_of(material)
    np.testing.assert_allclose(colour, ORANGE, rtol=1e-6)
    assert notes == [
        "material 'Material': node 'Noise Texture' at 'Color' is not supported yet; the socket's own colour was used"
    ]


def test_a_group_takes_its_first_diffuse(colour_of):
    material, _, tree = shader("ShaderNodeBsdfDiffuse")
    inside = tree.nodes.new("ShaderNodeGroup")
    group = bpy.data.node_groups.new("Inside", "ShaderNodeTree")
    if hasattr(group, "interface"):
        group.interface.new_socket("BSDF", in_out="OUTPUT", socket_type="NodeSocketShader")
    else:
        group.outputs.new("NodeSocketShader", "BSDF")
    diffuse, last = group.nodes.new("ShaderNodeBsdfDiffuse"), group.nodes.new("NodeGroupOutput")
    diffuse.inputs["Color"].default_value = (*ORANGE, 1)
    group.links.new(diffuse.outputs[0], last.inputs[0])
    inside.node_tree = group
    tree.links.new(inside.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    colour, notes = colour_of(material)
    np.testing.assert_allclose(colour, ORANGE, rtol=1e-6)
    assert notes == ["material 'Material': node 'Group' is not supported yet; the colour of 'Diffuse BSDF' was used"]


def test_a_shader_without_diffuse_is_grey(colour_of):
    material, _, _ = shader("ShaderNodeBsdfGlass")
    assert colour_of(material) == (
        (0.8, 0.8, 0.8),
        ["material 'Material': node 'Glass BSDF' is not supported yet; rendered as 80 % grey"],
    )


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
