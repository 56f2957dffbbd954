# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's BRDF from Blender's nodes: mirror, Phong lobe and diffuse, and what they do to pixels."""

import math

import bpy
import numpy as np
import pytest
from helpers import add_area_light, add_camera, add_plane, diffuse_material, render_pixels, use_cycles_as_reference

RED, BLUE, WHITE = (0.6, 0.1, 0.1), (0.1, 0.1, 0.6), (1.0, 1.0, 1.0)
GLOSSY = "ShaderNodeBsdfGlossy" if hasattr(bpy.types, "ShaderNodeBsdfGlossy") else "ShaderNodeBsdfAnisotropic"


class Nodes:
    """A material built node by node; the last one made is at its surface."""

    def __init__(self, name="Material") -> None:
        self.material = bpy.data.materials.new(name)
        self.material.use_nodes = True
        self.tree = self.material.node_tree
        self.tree.nodes.clear()
        self.output = self.tree.nodes.new("ShaderNodeOutputMaterial")

    def _add(self, kind: str, *shaders, **values):
        node = self.tree.nodes.new(kind)
        for name, value in values.items():
            node.inputs[name].default_value = (*value, 1) if isinstance(value, tuple) else value
        sockets = [socket for socket in node.inputs if socket.type == "SHADER"]
        for socket, shader in zip(sockets, shaders, strict=False):
            self.tree.links.new(shader.outputs[0], socket)
        self.tree.links.new(node.outputs[0], self.output.inputs["Surface"])
        return node

    def diffuse(self, colour):
        return self._add("ShaderNodeBsdfDiffuse", Color=colour)

    def glossy(self, colour, roughness):
        node = self._add(GLOSSY, Color=colour, Roughness=roughness)
        node.distribution = "ASHIKHMIN_SHIRLEY"
        return node

    def mix(self, factor, first, second):
        return self._add("ShaderNodeMixShader", first, second, Fac=factor)

    def add(self, first, second):
        return self._add("ShaderNodeAddShader", first, second)


@pytest.fixture
def exported(lit_scene, recorded):
    """A function Nodes -> (exported material, notes)."""
    plane = add_plane(lit_scene)

    def export(nodes):
        plane.data.materials.clear()
        plane.data.materials.append(nodes.material)
        found = recorded()
        return found.materials[0], found.notes

    return export


def albedos(material) -> list:
    return [material.diffuse, material.phong, material.mirror]


@pytest.mark.parametrize("roughness", [0.0, 0.017])
def test_glossy_without_roughness_is_the_mirror(exported, roughness):
    nodes = Nodes()
    nodes.glossy(RED, roughness)
    material, notes = exported(nodes)
    np.testing.assert_allclose(albedos(material), [(0, 0, 0), (0, 0, 0), RED], rtol=1e-6)
    assert notes == []


@pytest.mark.parametrize(("roughness", "exponent"), [(1.0, 0.0), (0.5, 7.5), (0.2, 312.0)])
def test_glossy_roughness_is_a_phong_lobe(exported, roughness, exponent):
    nodes = Nodes()
    nodes.glossy(RED, roughness)
    material, notes = exported(nodes)
    np.testing.assert_allclose(albedos(material), [(0, 0, 0), RED, (0, 0, 0)], rtol=1e-6)
    assert material.phong_exponent == pytest.approx(exponent, rel=1e-5, abs=1e-6) and notes == []


def test_all_three_through_mix_shaders(exported):
    nodes = Nodes()
    inner = nodes.mix(0.25, nodes.diffuse(RED), nodes.glossy(WHITE, 0.5))
    nodes.mix(0.4, inner, nodes.glossy(BLUE, 0.0))
    material, notes = exported(nodes)
    expected = [0.6 * 0.75 * np.array(RED), 0.6 * 0.25 * np.array(WHITE), 0.4 * np.array(BLUE)]
    np.testing.assert_allclose(albedos(material), expected, rtol=1e-6)
    assert notes == []


def test_add_shader_sums(exported):
    nodes = Nodes()
    nodes.add(nodes.diffuse(RED), nodes.glossy((0.2, 0.2, 0.2), 0.3))
    material, notes = exported(nodes)
    np.testing.assert_allclose(albedos(material), [RED, (0.2, 0.2, 0.2), (0, 0, 0)], rtol=1e-6)
    assert notes == []


def test_more_than_all_light_is_scaled_down(exported):
    nodes = Nodes("Too bright")
    nodes.add(nodes.diffuse((0.9, 0.3, 0.0)), nodes.glossy((0.6, 0.3, 0.0), 0.3))
    material, notes = exported(nodes)
    np.testing.assert_allclose(albedos(material), [(0.6, 0.3, 0), (0.4, 0.3, 0), (0, 0, 0)], rtol=1e-6)
    assert notes == ["material 'Too bright': its albedos add up to more than 1 and were scaled down"]


def test_lobes_of_different_roughness_become_the_strongest(exported):
    nodes = Nodes("Two lobes")
    strong = nodes.glossy((0.5, 0.5, 0.5), 0.5)
    nodes.mix(0.3, strong, nodes.glossy((0.5, 0.5, 0.5), 0.2))
    material, notes = exported(nodes)
    np.testing.assert_allclose(material.phong, (0.5, 0.5, 0.5), rtol=1e-6)
    assert material.phong_exponent == pytest.approx(7.5)
    assert notes == [
        f"material 'Two lobes': its glossy nodes differ in roughness; that of {strong.name!r} was used for all"
    ]


def test_an_empty_socket_and_a_weight_of_nothing_add_nothing(exported):
    nodes = Nodes()
    unknown = nodes._add("ShaderNodeBsdfGlass")
    diffuse = nodes.diffuse(RED)
    nodes._add("ShaderNodeMixShader", nodes.mix(0.0, diffuse, unknown), Fac=0.5)
    material, notes = exported(nodes)
    np.testing.assert_allclose(albedos(material), [0.5 * np.array(RED), (0, 0, 0), (0, 0, 0)], rtol=1e-6)
    assert notes == []


def test_a_roughness_that_is_no_number_names_the_material(exported):
    nodes = Nodes("Odd")
    nodes.glossy(RED, float("nan"))
    with pytest.raises(RuntimeError, match="material 'Odd': its roughness is not a finite number"):
        exported(nodes)


def fixed(scene, points: int, reuse="SAME") -> None:
    scene.penumbra.pixel_samples = 1
    scene.penumbra.stop_rule, scene.penumbra.light_samples = "FIXED", points
    scene.penumbra.sampler, scene.penumbra.sample_reuse = "OWEN_SOBOL", reuse


def test_a_mirror_shows_the_wall_times_its_albedo(scene):
    """Oracle: the same wall seen by the camera's mirror image, below the floor, without the mirror."""
    fixed(scene, 256)
    wall = add_plane(scene, "Wall", 4.0, location=(3, 0, 1), rotation=(0, -math.pi / 2, 0))
    wall.data.materials.append(diffuse_material("Wall", (0.7, 0.5, 0.3)))
    add_area_light(scene, location=(0, 0, 2), rotation=(0, -math.pi / 2, 0), size=0.5)  # shines along +x
    mirror = add_plane(scene, "Mirror", 6.0)
    nodes = Nodes("Mirror")
    nodes.glossy((0.9, 0.6, 0.3), 0.0)
    mirror.data.materials.append(nodes.material)
    camera = add_camera(scene, location=(-1, 0, 1), rotation=(math.radians(60), 0, math.radians(-90)))
    reflected = render_pixels(scene)["Combined"][..., :3]
    bpy.data.objects.remove(mirror)
    camera.location, camera.rotation_euler = (-1, 0, -1), (math.radians(120), 0, math.radians(-90))
    direct = render_pixels(scene)["Combined"][::-1, :, :3]
    both = (reflected[..., 0] > 0) & (direct[..., 0] > 0)
    assert both.mean() > 0.2
    np.testing.assert_allclose(reflected[both], direct[both] * (0.9, 0.6, 0.3), rtol=1e-4)


@pytest.mark.parametrize("roughness", [1.0, 0.7, 0.4])
def test_a_phong_furnace_gives_back_its_albedo_or_less(scene, roughness):
    """Under a luminaire of form factor 0.988 the lobe sends back its albedo straight up, and less aslant."""
    fixed(scene, 1 << 18, "SCRAMBLED")
    scene.render.resolution_x = scene.render.resolution_y = 1
    nodes = Nodes()
    nodes.glossy((0.8, 0.8, 0.8), roughness)
    add_plane(scene, size=0.1).data.materials.append(nodes.material)
    light = add_area_light(scene, location=(0, 0, 1), size=16.0)
    radiance = light.data.energy / ((4 if bpy.app.version < (4, 0, 0) else math.pi) * 16.0**2)
    camera = add_camera(scene, type="ORTHO", ortho_scale=0.01)
    found = []
    for angle in np.radians([0, 30, 60, 80]):
        camera.rotation_euler = (0, angle, 0)
        camera.location = (0.2 * math.sin(angle), 0, 0.2 * math.cos(angle))
        found.append(float(render_pixels(scene)["Combined"][0, 0, 1]) / radiance)
    assert found[0] == pytest.approx(0.8, rel=1.5e-2)
    assert max(found) < 0.8 * 1.005 and found[-1] < 0.75


@pytest.mark.parametrize("roughness", [0.3, 0.5])
def test_a_lobe_is_about_as_wide_as_cycles_ggx(scene, roughness):
    """The mapping equates a Phong lobe with a Beckmann lobe; GGX has a narrower peak and longer tails. In the limit of
    small roughness the half-maximum radii are 0.83 alpha and 0.64 alpha: a ratio of 1.29."""
    scene.render.resolution_x, scene.render.resolution_y = 128, 1
    nodes = Nodes()
    nodes.glossy(WHITE, roughness)
    add_plane(scene, size=20.0).data.materials.append(nodes.material)
    add_area_light(scene, location=(0, 0, 4), size=0.05)
    add_camera(scene, location=(0, 0, 3), type="ORTHO", ortho_scale=8.0)
    fixed(scene, 64)
    use_cycles_as_reference(scene, 64)
    lobe = next(node for node in nodes.tree.nodes if node.bl_idname == GLOSSY)

    def half_maximum_radius(engine):
        lobe.distribution = "GGX" if engine == "CYCLES" else "ASHIKHMIN_SHIRLEY"
        row = render_pixels(scene, engine)["Combined"][0, :, 1]
        return (row > row.max() / 2).sum()

    assert 1.1 < half_maximum_radius("PENUMBRA") / half_maximum_radius("CYCLES") < 1.5
