# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair against Cycles in the same Blender: particle strands, Curves objects, point clouds; thickness, shape, materials.

Many rays a pixel through a box filter of one pixel in both. Tolerances: the mean within four of Cycles' noise and 1 %,
which is what its ribbons of three straight pieces a segment, and shadow rays that pass their own strand, differ by; the
root mean square of the difference within 2 of its noise and 1 %.
"""

import math

import bpy
import numpy as np
import pytest
from cycles_reference import colour, converge_cycles, relative_rmse, render_with_penumbra
from helpers import add_area_light, add_camera, add_mesh, add_plane, diffuse_material, link, use_cycles_as_reference

SAMPLES = 128


@pytest.fixture
def stage(scene):
    """A dark floor, a light from above at the side, a camera."""
    floor = add_plane(scene, "Floor", size=14.0)
    floor.data.materials.append(diffuse_material("Dark", (0.2, 0.2, 0.2)))
    add_area_light(scene, size=1.0, power=500.0, location=(2.0, -1.0, 4.0), rotation=(0.2, 0.45, 0.0))
    add_camera(scene, location=(0.0, -4.0, 2.4), rotation=(1.1, 0.0, 0.0), lens=45.0)
    scene.cycles_curves.shape = "RIBBONS"
    penumbra = scene.penumbra
    penumbra.pixel_samples, penumbra.filter_type, penumbra.filter_width = 2 * SAMPLES, "BOX", 1.0
    scene.render.resolution_x, scene.render.resolution_y = 48, 36
    return scene


def converged(scene):
    """Cycles' picture and noise, through a box filter of a pixel."""
    import cycles_reference

    def with_box(scene_, samples):
        use_cycles_as_reference(scene_, samples)
        scene_.cycles.pixel_filter_type = "BOX"

    cycles_reference.use_cycles_as_reference = with_box
    try:
        return converge_cycles(scene, SAMPLES)
    finally:
        cycles_reference.use_cycles_as_reference = use_cycles_as_reference


def assert_as_in_cycles(scene, without) -> None:
    """`without` takes the hair away: it must matter."""
    ours, (cycles, noise) = colour(render_with_penumbra(scene, light_samples=4)), converged(scene)
    theirs = colour(cycles)
    without()
    bare = colour(render_with_penumbra(scene, light_samples=4))
    difference, noise_rmse = ours - theirs, relative_rmse(noise, theirs)
    assert relative_rmse(bare - theirs, theirs) > 5 * noise_rmse
    mean_noise = noise_rmse * theirs.mean() / np.sqrt(theirs[..., 0].size)
    assert abs(difference.mean()) < 4 * mean_noise + 0.01 * theirs.mean()
    assert relative_rmse(difference, theirs) < 2 * noise_rmse + 0.01


def furry(scene, **settings):
    """A low dome with a hundred strands and children of a material of their own."""
    rings = [(0.9 * math.cos(a), 0.9 * math.sin(a), 0.0) for a in np.linspace(0, 2 * math.pi, 12, endpoint=False)]
    dome = add_mesh(scene, "Dome", [*rings, (0, 0, 0.4)], [(i, (i + 1) % 12, 12) for i in range(12)])
    dome.data.materials.append(diffuse_material("Skin", (0.5, 0.3, 0.2)))
    dome.data.materials.append(diffuse_material("Fur", (0.8, 0.7, 0.3)))
    dome.modifiers.new("Fur", "PARTICLE_SYSTEM")
    fur = dome.particle_systems[0].settings
    fur.type, fur.count, fur.hair_length, fur.material = "HAIR", 60, 0.8, 2
    fur.radius_scale, fur.root_radius, fur.tip_radius = 0.05, 1.0, 0.2
    for name, value in settings.items():
        setattr(fur, name, value)
    return dome


FUR = {
    "parents": {},
    "children": {"child_type": "SIMPLE", "rendered_child_count": 6, "radius_scale": 0.03},
    "shaped": {"shape": 0.6, "use_close_tip": True},
    "blunt": {"shape": -0.5, "tip_radius": 0.6},
    "cut": {"child_type": "SIMPLE", "rendered_child_count": 6, "child_length": 0.4, "radius_scale": 0.03},
    "kinked": {"child_type": "SIMPLE", "rendered_child_count": 3, "kink": "SPIRAL", "radius_scale": 0.03},
}


@pytest.mark.parametrize("settings", FUR.values(), ids=FUR)
def test_particle_hair(stage, settings):
    dome = furry(stage, **settings)
    assert_as_in_cycles(stage, lambda: dome.modifiers.clear())


def test_tubes(stage):
    stage.cycles_curves.shape = "THICK"
    dome = furry(stage)
    assert_as_in_cycles(stage, lambda: dome.modifiers.clear())


def test_hidden_emitter_and_scaled_instances(stage):
    """The emitter is not rendered; its hair is, also where a collection places it turned and scaled."""
    dome = furry(stage)
    dome.show_instancer_for_render = False
    collection = bpy.data.collections.new("Group")
    collection.objects.link(dome)
    empty = link(stage, "Empty", None, location=(1.2, 0.6, 0.1), rotation=(0.2, 0, 1.0), scale=(0.6, 0.6, 0.6))
    empty.instance_type, empty.instance_collection = "COLLECTION", collection

    def without():
        dome.modifiers.clear()

    assert_as_in_cycles(stage, without)


@pytest.mark.skipif(not hasattr(bpy.data, "hair_curves"), reason="no Curves objects in this Blender")
@pytest.mark.parametrize("radius", [None, 0.02])
def test_curves_object(stage, radius):
    curves = bpy.data.hair_curves.new("Hair")
    rng = np.random.default_rng(3)
    if not hasattr(curves, "add_curves"):
        pytest.skip("Blender before 4.3 gives scripts no way to make Curves")
    curves.add_curves([6] * 40)
    root = rng.uniform(-0.8, 0.8, (40, 1, 3)) * [1, 1, 0]
    keys = root + np.linspace(0, 0.8, 6)[None, :, None] * [[0.3, 0.1, 1.0]] + rng.normal(0, 0.03, (40, 6, 3))
    curves.attributes["position"].data.foreach_set("vector", keys.astype(np.float32).ravel())
    if radius:
        curves.attributes.new("radius", "FLOAT", "POINT").data.foreach_set("value", np.full(240, radius, np.float32))
    curves.materials.append(diffuse_material("Hair", (0.8, 0.3, 0.3)))
    hair = link(stage, "Hair", curves, location=(0, 0.3, 0))
    assert_as_in_cycles(stage, lambda: stage.collection.objects.unlink(hair))


def test_point_cloud_of_geometry_nodes(stage):
    """Mesh to Points makes one in every version."""
    rng = np.random.default_rng(4)
    cloud = add_mesh(stage, "Cloud", rng.uniform([-0.9, -0.6, 0.2], [0.9, 0.6, 1.2], (60, 3)), [])
    cloud.data.materials.append(diffuse_material("Dots", (0.3, 0.7, 0.4)))
    tree = bpy.data.node_groups.new("Points", "GeometryNodeTree")
    if hasattr(tree, "interface"):
        for direction in ("INPUT", "OUTPUT"):
            tree.interface.new_socket("Geometry", in_out=direction, socket_type="NodeSocketGeometry")
    else:
        tree.inputs.new("NodeSocketGeometry", "Geometry")
        tree.outputs.new("NodeSocketGeometry", "Geometry")
    nodes, links = tree.nodes, tree.links
    start, points, paint, end = (nodes.new(kind) for kind in (
        "NodeGroupInput", "GeometryNodeMeshToPoints", "GeometryNodeSetMaterial", "NodeGroupOutput"))  # fmt: skip
    points.inputs["Radius"].default_value = 0.12
    paint.inputs["Material"].default_value = cloud.data.materials[0]
    links.new(start.outputs[0], points.inputs["Mesh"])
    links.new(points.outputs[0], paint.inputs["Geometry"])
    links.new(paint.outputs[0], end.inputs[0])
    cloud.modifiers.new("Points", "NODES").node_group = tree
    assert_as_in_cycles(stage, lambda: stage.collection.objects.unlink(cloud))
