# SPDX-License-Identifier: GPL-3.0-or-later
"""One scene with as much of Blender as fits: ways to make objects, ways to place them, materials, luminaires."""

import math

import bpy
import numpy as np
from helpers import (
    add_area_light,
    add_camera,
    add_light,
    add_mesh,
    add_plane,
    diffuse_material,
    emissive_material,
    link,
)
from material_scenes import PRINCIPLED, Tree
from test_export_instances import geometry_nodes


def painted(name: str, alpha: bool = False):
    """An Image Texture by UV map: a picture packed into the file; alpha: its holes are cut out."""
    image = bpy.data.images.new(name, 32, 32, alpha=alpha)
    x, y = np.meshgrid(np.linspace(0, 1, 32), np.linspace(0, 1, 32))
    hole = (np.hypot(x - 0.5, y - 0.5) < 0.3) if alpha else np.zeros_like(x)
    image.pixels.foreach_set(np.stack([0.3 + 0.6 * x, 0.8 - 0.5 * y, 0.4 + 0 * x, 1 - hole], -1).astype("f").ravel())
    image.pack()
    tree = Tree(name)
    texture = tree.add("ShaderNodeTexImage", {"Vector": tree.coordinates("UV")}, image=image)
    inputs = {"Base Color": texture.outputs["Color"], "Roughness": 0.7}
    return tree.finish(tree.add(PRINCIPLED, inputs | ({"Alpha": texture.outputs["Alpha"]} if alpha else {})).outputs[0])


def polished(name: str, colour):
    tree = Tree(name)
    return tree.finish(tree.add(PRINCIPLED, {"Base Color": colour, "Metallic": 1.0, "Roughness": 0.4}).outputs[0])


def glass(name: str, tint):
    tree = Tree(name)
    return tree.finish(tree.add("ShaderNodeBsdfTransparent", {"Color": tint}).outputs[0])


def ball(scene, name: str, radius: float, **transform):
    """Coarse and without smoothing, to be subdivided."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=1, radius=radius)
    made = bpy.context.object
    mesh = made.data
    bpy.data.objects.remove(made)
    return link(scene, name, mesh, **transform)


def add_shapes(scene) -> None:
    """Curve, text, metaballs, subdivision, shape key, armature: each with a material of its own."""
    curve = bpy.data.curves.new("Arch", "CURVE")
    curve.dimensions, curve.bevel_depth, curve.use_fill_caps = "3D", 0.06, True
    spline = curve.splines.new("BEZIER")
    spline.bezier_points.add(2)
    for point, at in zip(spline.bezier_points, ((-0.5, 0, 0), (0, 0, 0.9), (0.5, 0, 0)), strict=True):
        point.co, point.handle_left_type, point.handle_right_type = at, "AUTO", "AUTO"
    link(scene, "Arch", curve, location=(-1.6, 0.6, 0)).data.materials.append(polished("Brass", (0.9, 0.6, 0.2)))

    text = bpy.data.curves.new("Text", "FONT")
    text.body, text.extrude, text.size = "Penumbra", 0.05, 0.45
    link(scene, "Text", text, location=(-0.9, -1.5, 0.02), rotation=(1.2, 0, 0))
    text.materials.append(diffuse_material("Ink", (0.2, 0.3, 0.7)))

    blobs = bpy.data.metaballs.new("Blobs")
    blobs.resolution = blobs.render_resolution = 0.08
    for x in (-0.2, 0.2):
        element = blobs.elements.new()
        element.co, element.radius = (x, 0, 0), 0.35
    link(scene, "Blobs", blobs, location=(1.5, 0.7, 0.35))
    blobs.materials.append(diffuse_material("Clay", (0.7, 0.4, 0.3)))

    smooth = ball(scene, "Subdivided", 0.4, location=(-0.3, 0.5, 0.4))
    smooth.modifiers.new("Subdivision", "SUBSURF").render_levels = 3
    smooth.data.polygons.foreach_set("use_smooth", [True] * len(smooth.data.polygons))
    smooth.data.materials.append(diffuse_material("Chalk", (0.8, 0.8, 0.75)))

    key = ball(scene, "Key", 0.25, location=(0.6, 0.3, 0.25))
    key.shape_key_add(name="Basis")
    high = key.shape_key_add(name="High")
    for point in high.data:
        point.co.z *= 2.5
    high.value = 0.6
    key.data.materials.append(diffuse_material("Leek", (0.3, 0.7, 0.3)))
    add_bent_pole(scene)


def add_bent_pole(scene) -> None:
    """A pole whose upper half an armature's bone has turned."""
    heights = np.linspace(0, 1, 9)
    vertices = [(0.07 * x, 0.07 * y, z) for z in heights for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    faces = [
        (4 * k + i, 4 * k + (i + 1) % 4, 4 * k + 4 + (i + 1) % 4, 4 * k + 4 + i) for k in range(8) for i in range(4)
    ]
    pole = add_mesh(scene, "Pole", vertices, [*faces, (32, 33, 34, 35)], location=(1.1, -0.6, 0))
    pole.data.materials.append(diffuse_material("Wood", (0.5, 0.35, 0.2)))
    rig = link(scene, "Rig", bpy.data.armatures.new("Rig"), location=(1.1, -0.6, 0))
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    for name, low, top in (("Low", 0.0, 0.5), ("High", 0.5, 1.0)):
        bone = rig.data.edit_bones.new(name)
        bone.head, bone.tail = (0, 0, low), (0, 0, top)
    bpy.ops.object.mode_set(mode="OBJECT")
    rig.pose.bones["High"].rotation_mode, rig.pose.bones["High"].rotation_euler = "XYZ", (0.9, 0, 0.4)
    for name, of in (("Low", lambda z: z < 0.5), ("High", lambda z: z >= 0.5)):
        pole.vertex_groups.new(name=name).add([i for i, v in enumerate(vertices) if of(v[2])], 1.0, "REPLACE")
    pole.modifiers.new("Rig", "ARMATURE").object = rig


def add_instances(scene) -> None:
    """A mirrored copy, a collection placed twice, particles, points of geometry nodes, hair."""
    wedge = add_mesh(scene, "Wedge", [(0, 0, 0), (0.4, 0, 0), (0, 0.3, 0), (0, 0, 0.4)],
                     [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)], location=(-0.9, -0.5, 0))  # fmt: skip
    wedge.data.materials.append(diffuse_material("Plum", (0.5, 0.2, 0.5)))
    link(scene, "Mirrored", wedge.data, location=(-1.0, -0.5, 0), scale=(-1, 1, 1.3))
    group = bpy.data.collections.new("Group")
    group.objects.link(bpy.data.objects.new("Grouped", wedge.data))
    for i in range(2):
        empty = link(scene, f"Empty {i}", None, location=(0.1 + 0.8 * i, 1.4, 0), rotation=(0, 0, i), scale=(0.8,) * 3)
        empty.instance_type, empty.instance_collection = "COLLECTION", group

    leaf = add_mesh(scene, "Leaf", [(0, 0, 0), (0.25, 0, 0), (0.25, 0.25, 0.1), (0, 0.25, 0)], [(0, 1, 2, 3)],
                    location=(0, 0, -5))  # fmt: skip
    leaf.data.uv_layers.new().data.foreach_set("uv", np.array([0, 0, 1, 0, 1, 1, 0, 1], np.float32))
    leaf.data.materials.append(painted("Leaf", alpha=True))
    meadow = add_plane(scene, "Meadow", size=1.0, location=(-1.9, -0.9, 0.01))
    meadow.modifiers.new("Leaves", "PARTICLE_SYSTEM")
    settings = meadow.particle_systems[0].settings
    settings.type, settings.count, settings.hair_length = "HAIR", 12, 1.0
    settings.render_type, settings.instance_object, settings.particle_size = "OBJECT", leaf, 1.0

    tree, first, last = geometry_nodes("Scatter")
    to_instances, of = tree.nodes.new("GeometryNodeInstanceOnPoints"), tree.nodes.new("GeometryNodeObjectInfo")
    of.inputs["Object"].default_value = wedge
    tree.links.new(first, to_instances.inputs["Points"])
    tree.links.new(of.outputs["Geometry"], to_instances.inputs["Instance"])
    tree.links.new(to_instances.outputs[0], last)
    places = [(0.35 * i, 0.1 * math.sin(2 * i), 0.0) for i in range(6)]
    add_mesh(scene, "Row", places, [], location=(-0.6, 2.0, 0.0)).modifiers.new("Scatter", "NODES").node_group = tree

    tuft = add_plane(scene, "Tuft", size=0.5, location=(1.9, -0.3, 0.01))
    tuft.data.materials.append(diffuse_material("Straw", (0.7, 0.6, 0.2)))
    tuft.modifiers.new("Hair", "PARTICLE_SYSTEM")
    hair = tuft.particle_systems[0].settings
    hair.type, hair.count, hair.hair_length, hair.radius_scale = "HAIR", 60, 0.5, 0.02


def add_luminaires(scene) -> None:
    add_area_light(scene, "Area", size=1.2, power=120.0, location=(-1.5, -2.0, 3.2), rotation=(0.5, -0.4, 0))
    add_light(scene, "POINT", "Bulb", 30.0, (1.0, 0.7, 0.4), location=(2.2, 1.2, 1.6)).data.shadow_soft_size = 0.2
    spot = add_light(scene, "SPOT", "Spot", 150.0, (0.5, 0.7, 1.0), location=(0.5, 2.5, 2.8), rotation=(-0.7, 0.1, 0))
    spot.data.spot_size, spot.data.spot_blend, spot.data.shadow_soft_size = 0.9, 0.4, 0.1
    sun = add_light(scene, "SUN", "Sun", 0.6, location=(0, 0, 5), rotation=(0.6, 0.5, 0))
    sun.data.angle = 0.1
    lamp = add_plane(scene, "Panel", size=0.6, location=(0.2, 2.6, 0.8), rotation=(1.57, 0, 0))
    lamp.data.materials.append(emissive_material("Panel", (0.4, 1.0, 0.6), 6.0))
    world = scene.world = bpy.data.worlds.new("World")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs[0].default_value = (0.05, 0.07, 0.1, 1.0)


def build(scene):
    floor = add_plane(scene, "Floor", size=9.0)
    floor.data.materials.append(painted("Floor"))
    add_shapes(scene)
    add_instances(scene)
    pane = add_plane(scene, "Pane", size=0.9, location=(0.2, -0.9, 0.8), rotation=(0.9, 0.3, 0))
    pane.data.materials.append(glass("Pane", (0.9, 0.4, 0.1)))
    add_luminaires(scene)
    add_camera(scene, location=(0.0, -5.2, 3.2), rotation=(1.05, 0, 0), lens=36)
    return scene
