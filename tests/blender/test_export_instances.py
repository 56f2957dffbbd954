# SPDX-License-Identifier: GPL-3.0-or-later
"""Instances are shared, land where Blender puts them, and what is hidden from render stays away."""

import bpy
import numpy as np
import pytest
from helpers import (
    add_area_light,
    add_cube,
    add_mesh,
    add_plane,
    diffuse_material,
    link,
    render_pixels,
    use_cycles_as_reference,
)
from mathutils import Euler, Matrix
from penumbra import statistics


def geometry_nodes(name: str):
    """A new geometry node group with one geometry in and one out: (group, input socket, output socket)."""
    group = bpy.data.node_groups.new(name, "GeometryNodeTree")
    if hasattr(group, "interface"):  # Blender 4.0+
        for in_out in ("INPUT", "OUTPUT"):
            group.interface.new_socket("Geometry", in_out=in_out, socket_type="NodeSocketGeometry")
    else:
        group.inputs.new("NodeSocketGeometry", "Geometry")
        group.outputs.new("NodeSocketGeometry", "Geometry")
    first, last = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    return group, first.outputs[0], last.inputs[0]


def add_grid(scene, name: str, side: int, **transform):
    """side x side loose points, 1 m apart."""
    points = [(x - side / 2, y - side / 2, 0) for x in range(side) for y in range(side)]
    return add_mesh(scene, name, points, [], **transform)


def test_objects_that_share_a_mesh_share_the_export(lit_scene, recorded):
    cube = add_cube(lit_scene, "First")
    link(lit_scene, "Second", cube.data, location=(3, 0, 0))
    link(lit_scene, "Modified", cube.data, location=(6, 0, 0)).modifiers.new("S", "SUBSURF")
    found = recorded()
    mesh = {instance.name: instance.mesh for instance in found.instances}
    assert mesh["First"] == mesh["Second"] != mesh["Modified"]
    assert len(found.meshes) == 2


def test_nested_collection_instances(lit_scene, recorded):
    inner, outer = bpy.data.collections.new("Inner"), bpy.data.collections.new("Outer")
    cube = add_cube(lit_scene, location=(1, 0, 0))
    lit_scene.collection.objects.unlink(cube)
    inner.objects.link(cube)
    for y in (0.0, 5.0):
        empty = bpy.data.objects.new(f"Inner {y}", None)
        empty.location, empty.instance_type, empty.instance_collection = (0, y, 0), "COLLECTION", inner
        outer.objects.link(empty)
    for z in (0.0, -7.0):
        empty = link(lit_scene, f"Outer {z}", None, location=(0, 0, z), scale=(2, 2, 2))
        empty.instance_type, empty.instance_collection = "COLLECTION", outer
    found = recorded()
    assert len(found.meshes) == 1
    places = sorted(tuple(instance.matrix[:3, 3]) for instance in found.instances)
    assert places == [(2, 0, -7), (2, 0, 0), (2, 10, -7), (2, 10, 0)]


def test_ten_thousand_geometry_nodes_instances_are_one_mesh(lit_scene, recorded):
    group, geometry_in, geometry_out = geometry_nodes("Scatter")
    cube, place = group.nodes.new("GeometryNodeMeshCube"), group.nodes.new("GeometryNodeInstanceOnPoints")
    paint = group.nodes.new("GeometryNodeSetMaterial")
    paint.inputs["Material"].default_value = diffuse_material("Paint", (0.1, 0.2, 0.3))
    cube.inputs["Size"].default_value = (0.5, 0.5, 0.5)
    group.links.new(geometry_in, place.inputs["Points"])
    group.links.new(cube.outputs[0], paint.inputs["Geometry"])
    group.links.new(paint.outputs[0], place.inputs["Instance"])
    group.links.new(place.outputs[0], geometry_out)
    add_grid(lit_scene, "Scatter", 100).modifiers.new("Nodes", "NODES").node_group = group
    found = recorded()
    assert len(found.meshes) == 1
    assert len(found.instances) == 10_000
    colours = {tuple(np.round(found.materials[i.materials[s]].diffuse, 6))
               for i in found.instances for s in found.meshes[0].material_slots[:1]}  # fmt: skip
    assert colours == {(0.1, 0.2, 0.3)}
    assert statistics.last_render["seconds"]["export"] < 5.0


def test_particles(lit_scene, recorded):
    cube = add_cube(lit_scene, size=0.5, location=(0, 0, -20))
    emitter = add_plane(lit_scene, "Emitter")
    particles = emitter.modifiers.new("Particles", "PARTICLE_SYSTEM").particle_system.settings
    particles.count, particles.frame_start, particles.frame_end = 25, 1, 1
    particles.render_type, particles.instance_object = "OBJECT", cube
    emitter.show_instancer_for_render = False
    found = recorded()
    assert len(found.meshes) == 1
    assert len(found.instances_of("Cube")) == 1 + 25  # the original and its particles
    assert found.instances_of("Emitter") == []


def test_vertex_instancer_hidden_from_render(lit_scene, recorded):
    parent = add_plane(lit_scene, "Parent")
    child = add_cube(lit_scene, "Child", size=0.1)
    child.parent = parent
    parent.instance_type = "VERTS"
    for visible in (True, False):
        parent.show_instancer_for_render = visible
        found = recorded()
        assert len(found.instances_of("Child")) == 4
        assert len(found.instances_of("Parent")) == int(visible)


def test_hidden_objects_are_left_out(lit_scene, recorded):
    add_cube(lit_scene, "Shown")
    add_cube(lit_scene, "Hidden").hide_render = True
    add_area_light(lit_scene, "Hidden light").hide_render = True
    add_cube(lit_scene, "Eye closed").hide_set(True)  # hides in the viewport alone
    excluded = bpy.data.collections.new("Excluded")
    lit_scene.collection.children.link(excluded)
    cube = add_cube(lit_scene, "Excluded")
    lit_scene.collection.objects.unlink(cube)
    excluded.objects.link(cube)
    bpy.context.view_layer.layer_collection.children["Excluded"].exclude = True
    group = bpy.data.collections.new("Group")
    for name in ("Member", "Hidden member"):
        group.objects.link(bpy.data.objects.new(name, cube.data))
    group.objects["Hidden member"].hide_render = True
    empty = link(lit_scene, "Empty", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", group
    found = recorded()
    assert sorted(i.name for i in found.instances) == ["Eye closed", "Member", "Shown"]
    assert [light.name for light in found.lights] == ["Light"]


@pytest.mark.parametrize("scale", [(1, 2, 0.5), (-1, 1, 1), (-1, -2, -0.5), (0.3, 0.3, -2)])
def test_scaled_and_mirrored_objects_have_the_position_and_normals_of_cycles(lit_scene, scale):
    bpy.ops.mesh.primitive_uv_sphere_add(radius=1.5, location=(0, 0, 0), rotation=(0.3, 0.2, 0.1))
    sphere = bpy.context.object
    sphere.scale = scale
    sphere.data.polygons.foreach_set("use_smooth", [True] * len(sphere.data.polygons))
    ours = render_pixels(lit_scene)
    use_cycles_as_reference(lit_scene, samples=1)
    cycles = render_pixels(lit_scene, "CYCLES")
    inside = (ours["Depth"][..., 0] < 100) & (cycles["Depth"][..., 0] < 100)
    assert inside.mean() > 0.01
    distance = np.linalg.norm(ours["Position"] - cycles["Position"], axis=2)[inside]
    angle = np.degrees(np.arccos(np.clip((ours["Normal"] * cycles["Normal"]).sum(2)[inside], -1, 1)))
    assert np.percentile(distance, 95) < 2e-3  # Cycles' ray is up to 0.005 pixels off the centre
    # Cycles transforms the corner normals before it interpolates them: within a facet the two differ, by less.
    assert np.percentile(angle, 50) < 0.5 and np.percentile(angle, 95) < 3


def test_zero_scale_is_no_failure(lit_scene, recorded):
    add_cube(lit_scene, "Point", scale=(0, 0, 0))
    add_cube(lit_scene, "Sheet", scale=(1, 1, 0))
    pixels = recorded().pixels
    assert np.isfinite(pixels["Combined"]).all()


def test_sheared_parents(lit_scene, recorded):
    parent = link(lit_scene, "Parent", None, scale=(1, 3, 1))
    add_cube(lit_scene, size=1.0, rotation=(0, 0, np.pi / 4)).parent = parent
    (instance,) = recorded().instances_of("Cube")
    expected = Matrix.Diagonal((1, 3, 1, 1)) @ Euler((0, 0, np.pi / 4)).to_matrix().to_4x4()
    np.testing.assert_allclose(instance.matrix, np.array(expected), atol=1e-6)
