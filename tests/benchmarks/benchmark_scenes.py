# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes for the benchmarks, made inside Blender: solid objects, texture, thin wires, a million leaf triangles.

Each function fills an empty scene; white is the largest unshadowed value of a floor of albedo 0.8.
"""

import math
import sys
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

sys.path[:0] = [str(Path(__file__).resolve().parents[1] / "blender")]

from helpers import add_area_light, add_camera, add_mesh, add_plane, diffuse_material  # noqa: E402

ALBEDO = 0.8


def colour(scene_object, albedo=ALBEDO):
    scene_object.data.materials.append(diffuse_material(f"{scene_object.name} {albedo}", (albedo,) * 3))
    return scene_object


def luminaire(scene, location, size):
    """Faces straight down; its power makes the floor below it 1 (E = L A / z^2 far away)."""
    power = math.pi / ALBEDO * math.pi * location[2] ** 2
    add_area_light(scene, size=size, power=power, location=location)


def floor_and_camera(scene, floor=True):
    if floor:
        colour(add_plane(scene, "Floor", 40.0))
    eye, target = Vector((5, -9, 7)), Vector((0, 0, 0.5))
    rotation = (target - eye).to_track_quat("-Z", "Y").to_euler()
    scene.camera = add_camera(scene, location=eye, rotation=rotation, lens=45.0)


def smooth(scene_object):
    polygons = scene_object.data.polygons
    polygons.foreach_set("use_smooth", [True] * len(polygons))
    return scene_object


def added(name):
    """The object that an operator of bpy.ops.mesh just added."""
    bpy.context.object.name = name
    return colour(bpy.context.object)


def sphere(scene):
    floor_and_camera(scene)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, location=(0, 0, 1))
    smooth(added("Sphere"))
    luminaire(scene, (-2.8, -1.8, 6.0), 2.0)


def objects(scene):
    add = bpy.ops.mesh
    add.primitive_uv_sphere_add(segments=64, ring_count=32, location=(-1.9, 0.4, 1.0))
    smooth(added("Sphere"))
    add.primitive_cube_add(size=1.5, location=(0.6, 1.9, 0.75), rotation=(0, 0, 0.5))
    added("Cube")
    add.primitive_cone_add(vertices=96, radius1=0.8, depth=2.0, location=(2.5, 0.1, 1.0))
    added("Cone")
    add.primitive_torus_add(major_segments=64, minor_segments=24, major_radius=0.75, location=(0.35, -1.2, 0.25))
    smooth(added("Torus"))
    luminaire(scene, (-2.8, -1.8, 6.8), 2.0)


def four_objects(scene):
    floor_and_camera(scene)
    objects(scene)


def checker(scene):
    """The four objects on a floor of light and dark squares."""
    floor_and_camera(scene, floor=False)
    objects(scene)
    n = 40
    place = np.linspace(-20, 20, n + 1)
    x, y = np.meshgrid(place, place)
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    faces = [(i * (n + 1) + j, i * (n + 1) + j + 1, (i + 1) * (n + 1) + j + 1, (i + 1) * (n + 1) + j)
             for i in range(n) for j in range(n)]  # fmt: skip
    squares = colour(add_mesh(scene, "Squares", vertices, faces))
    colour(squares, 0.3)
    squares.data.polygons.foreach_set("material_index", [(k // n + k % n) % 2 for k in range(n * n)])


def bar(scene, name, half, location, turn=0.0):
    vertices = [(x, y, z) for z in (-half[2], half[2]) for y in (-half[1], half[1]) for x in (-half[0], half[0])]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return colour(add_mesh(scene, name, vertices, faces, location=location, rotation=(0, 0, turn)))


def wires(scene):
    """A fence and wires down to a tenth of a pixel."""
    floor_and_camera(scene)
    for i in range(40):
        bar(scene, f"Bar {i}", (0.02, 0.015, 0.8), (-3 + 0.15 * i, 0, 0.8))
    random = np.random.default_rng(5)
    for i in range(20):
        half = 0.001 + 0.01 * random.random()
        place = (*random.uniform(-2, 2, 2), random.uniform(0.3, 1.5))
        bar(scene, f"Wire {i}", (2, half, half), place, random.uniform(0, math.pi))
    luminaire(scene, (-1.0, 4.0, 5.0), 1.7)


def plants(scene, leaves=500_000, size=0.02):
    """Rhombi of two triangles each, of random place and direction."""
    floor_and_camera(scene)
    random = np.random.default_rng(3)
    centre = random.uniform([-2.5, -2.5, 0.05], [2.5, 2.5, 1.2], (leaves, 3))
    a, b = random.normal(size=(2, leaves, 3))
    a *= size / np.linalg.norm(a, axis=1, keepdims=True)
    b = np.cross(a, b)
    b *= 0.4 * size / np.linalg.norm(b, axis=1, keepdims=True)
    mesh = bpy.data.meshes.new("Leaves")
    positions = np.stack([centre - a, centre + b, centre + a, centre - b], axis=1).reshape(-1)
    mesh.vertices.add(4 * leaves)
    mesh.vertices.foreach_set("co", positions.astype(np.float32))
    mesh.loops.add(4 * leaves)
    mesh.loops.foreach_set("vertex_index", np.arange(4 * leaves, dtype=np.int32))
    mesh.polygons.add(leaves)
    mesh.polygons.foreach_set("loop_start", np.arange(0, 4 * leaves, 4, dtype=np.int32))
    mesh.polygons.foreach_set("loop_total", np.full(leaves, 4, np.int32))
    mesh.update(calc_edges=True)
    leaf_object = bpy.data.objects.new("Leaves", mesh)
    scene.collection.objects.link(leaf_object)
    colour(leaf_object)
    luminaire(scene, (2.0, 1.0, 6.0), 2.0)


def open_floor(scene):
    floor_and_camera(scene)
    luminaire(scene, (-2.8, -1.8, 6.0), 2.0)


def many_lights(scene, side=8, half=8.0):
    """side x side small lamps over furniture; the floor's light is about 1 between its shadows."""
    floor_and_camera(scene)
    random = np.random.default_rng(7)
    for i in range(60):
        x, y = random.uniform(-6, 6, 2)
        w, h = random.uniform(0.15, 0.5), random.uniform(0.2, 0.8)
        bar(scene, f"Furniture {i}", (w, w, h), (x, y, h), random.uniform(0, math.pi))
    flux = math.pi / ALBEDO * (2 * half) ** 2 / side**2  # of each: E = flux / area
    for i in range(side * side):
        x, y = (2 * half * ((k + 0.5) / side - 0.5) for k in (i % side, i // side))
        add_area_light(scene, name=f"Lamp {i}", size=0.3, power=flux, location=(x, y, 4.0))


SCENES = {"sphere": sphere, "four objects": four_objects, "checker": checker, "wires": wires, "plants": plants,
          "open floor": open_floor, "64 lights": many_lights}  # fmt: skip


def make(name):
    """Blender's scene becomes the one of that name."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.view_settings.view_transform = "Standard"
    SCENES[name](scene)
    return scene
