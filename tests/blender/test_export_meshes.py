# SPDX-License-Identifier: GPL-3.0-or-later
"""Every mesh-like object arrives once, with its modifiers, normals and materials."""

import math

import bpy
import numpy as np
import pytest
from helpers import add_cube, add_mesh, add_plane, diffuse_material, link
from recording import record


def corner_normals_by_hand(mesh) -> np.ndarray:
    """(T, 3, 3) normals of flat shading, from the exported vertices."""
    corners = mesh.positions[mesh.triangles].astype(float)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return np.repeat(normals[:, None], 3, axis=1)


def uv_sphere(scene, name="Sphere", smooth=True, segments=32):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=segments, ring_count=segments // 2, radius=1.0)
    sphere = bpy.context.object
    sphere.name = name
    sphere.data.polygons.foreach_set("use_smooth", [smooth] * len(sphere.data.polygons))
    return sphere


def test_modifiers_are_applied(lit_scene, recorded):
    cube = add_cube(lit_scene, size=1.0)
    modifier = cube.modifiers.new("Array", "ARRAY")
    modifier.count = 3
    modifier.use_relative_offset = True
    modifier.relative_offset_displace = (2.0, 0.0, 0.0)
    found = recorded()
    assert len(found.mesh_of("Cube").triangles) == 3 * 12
    low, high = found.world_positions("Cube").min(0), found.world_positions("Cube").max(0)
    np.testing.assert_allclose([low, high], [[-0.5, -0.5, -0.5], [4.5, 0.5, 0.5]], atol=1e-6)


def add_curve(scene):
    curve = bpy.data.curves.new("Curve", "CURVE")
    curve.dimensions, curve.bevel_depth, curve.bevel_resolution = "3D", 0.1, 2
    spline = curve.splines.new("POLY")
    spline.points.add(1)
    spline.points[0].co, spline.points[1].co = (-1, 0, 0, 1), (1, 0, 0, 1)
    return link(scene, "Curve", curve), [[-1, -0.1, -0.1], [1, 0.1, 0.1]]


def add_text(scene):
    text = bpy.data.curves.new("Text", "FONT")
    text.body, text.extrude = "M", 0.25
    return link(scene, "Text", text), None


def add_metaball(scene):
    ball = bpy.data.metaballs.new("Metaball")
    ball.elements.new().radius = 1.0
    ball.render_resolution = 0.2
    return link(scene, "Metaball", ball), None


def add_surface(scene):
    bpy.ops.surface.primitive_nurbs_surface_sphere_add(radius=1.0)
    bpy.context.object.name = "Surface"
    return bpy.context.object, None


@pytest.mark.parametrize("add", [add_curve, add_text, add_metaball, add_surface])
def test_what_is_no_mesh_becomes_exactly_one(lit_scene, recorded, add):
    source, box = add(lit_scene)
    found = recorded()
    positions = found.world_positions(source.name)  # there is exactly one instance of that name
    evaluated = source.evaluated_get(bpy.context.evaluated_depsgraph_get())
    expected = np.array([vertex.co for vertex in evaluated.to_mesh().vertices])
    evaluated.to_mesh_clear()
    if add is not add_metaball:  # whose resolution differs between render and viewport
        assert len(positions) == len(expected)
    tolerance = 0.1 if add is add_metaball else 1e-5
    np.testing.assert_allclose(positions.min(0), expected.min(0), atol=tolerance)
    np.testing.assert_allclose(positions.max(0), expected.max(0), atol=tolerance)
    if box:
        np.testing.assert_allclose([positions.min(0), positions.max(0)], box, atol=1e-6)
    assert found.pixels["Depth"].min() < 10.0  # and it is seen


def test_a_curve_in_a_collection_instance_arrives_once_a_place(lit_scene, recorded):
    collection = bpy.data.collections.new("Group")
    curve, _ = add_curve(lit_scene)
    lit_scene.collection.objects.unlink(curve)
    collection.objects.link(curve)
    for x in (-2.0, 0.0, 2.0):
        empty = link(lit_scene, f"Place {x}", None, location=(x, 0, 0))
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
    found = recorded()
    assert len(found.meshes) == 1
    assert sorted(i.matrix[0, 3] for i in found.instances_of("Curve")) == [-2.0, 0.0, 2.0]


def test_flat_meshes_have_no_corner_normals(lit_scene, recorded):
    add_cube(lit_scene)
    uv_sphere(lit_scene, smooth=False)
    found = recorded()
    assert [mesh.corner_normals is None for mesh in found.meshes] == [True, True]


def test_smooth_normals_are_those_of_the_sphere(lit_scene, recorded):
    uv_sphere(lit_scene)
    mesh = recorded().mesh_of("Sphere")
    np.testing.assert_allclose(mesh.corner_normals, mesh.positions[mesh.triangles], atol=0.01)


def test_smooth_cube_and_split_cube(lit_scene, recorded):
    smooth, split = add_cube(lit_scene, "Smooth"), add_cube(lit_scene, "Split", location=(3, 0, 0))
    for cube in (smooth, split):
        cube.data.polygons.foreach_set("use_smooth", [True] * 6)
    if hasattr(split.data, "use_auto_smooth"):
        split.data.use_auto_smooth, split.data.auto_smooth_angle = True, math.radians(30)
    else:
        split.data.set_sharp_from_angle(angle=math.radians(30))
    found = recorded()
    mesh = found.mesh_of("Smooth")
    np.testing.assert_allclose(mesh.corner_normals, mesh.positions[mesh.triangles] / math.sqrt(3), atol=1e-6)
    mesh = found.mesh_of("Split")
    if mesh.corner_normals is not None:  # Blender 4.1+ knows that it is flat
        np.testing.assert_allclose(mesh.corner_normals, corner_normals_by_hand(mesh), atol=1e-6)


def test_one_flat_face_among_smooth_ones(lit_scene, recorded):
    cube = add_cube(lit_scene)
    cube.data.polygons.foreach_set("use_smooth", [True] * 5 + [False])
    mesh = recorded().mesh_of("Cube")
    flat = corner_normals_by_hand(mesh)
    is_flat = np.isclose(mesh.corner_normals, flat, atol=1e-6).all(axis=(1, 2))
    assert is_flat.sum() == 2  # the two triangles of that face


def test_custom_normals(lit_scene, recorded):
    plane = add_plane(lit_scene)
    plane.data.polygons.foreach_set("use_smooth", [True])
    tilted = np.array([0.6, 0.0, 0.8])
    if hasattr(plane.data, "use_auto_smooth"):
        plane.data.use_auto_smooth = True
    plane.data.normals_split_custom_set([tilted] * 4)
    np.testing.assert_allclose(recorded().mesh_of("Plane").corner_normals, np.full((2, 3, 3), tilted), atol=2e-4)


def test_slots_linked_to_data_and_to_the_object(lit_scene, recorded):
    red, green, blue = (diffuse_material(n, c) for n, c in (("R", (1, 0, 0)), ("G", (0, 1, 0)), ("B", (0, 0, 1))))
    cube = add_cube(lit_scene, "First")
    cube.data.materials.append(red)
    cube.data.materials.append(green)
    cube.data.polygons.foreach_set("material_index", [0, 1, 0, 1, 0, 1])
    other = link(lit_scene, "Second", cube.data, location=(3, 0, 0))
    other.material_slots[1].link = "OBJECT"
    other.material_slots[1].material = blue
    found = recorded()
    assert len(found.meshes) == 1  # shared although the materials differ
    assert np.array_equal(np.sort(found.meshes[0].material_slots), np.repeat([0, 1], 6))
    names = {i.name: [found.materials[m].name for m in i.materials] for i in found.instances}
    assert names == {"First": ["R", "G"], "Second": ["R", "B"]}


def test_no_slot_and_an_empty_slot_are_the_same(lit_scene, monkeypatch):
    add_cube(lit_scene, "None")
    empty = add_cube(lit_scene, "Empty", location=(3, 0, 0))
    empty.data.materials.append(None)
    found = record(lit_scene, monkeypatch, lambertian=False)
    assert [m.name for m in found.materials] == ["(no material)"]
    assert [i.materials for i in found.instances] == [[0], [0]]
    assert found.notes == []


def test_an_object_in_edit_mode_is_rendered_as_edited(lit_scene, recorded):
    cube = add_cube(lit_scene)
    bpy.context.view_layer.objects.active = cube
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide()
    try:
        assert len(recorded().mesh_of("Cube").triangles) == 4 * 12
    finally:
        bpy.ops.object.mode_set(mode="OBJECT")


def test_empty_mesh_and_loose_vertices_yield_nothing(lit_scene, recorded):
    add_mesh(lit_scene, "Loose", [(0, 0, 0), (1, 0, 0)], [])
    add_mesh(lit_scene, "Nothing", [], [])
    assert recorded().instances == []
