# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's scenes, made in Blender. The paper gives no measures: these are this project's own, in metres.

All surfaces but those of the BRDF's scene are Lambertian; white is 1: the exposure puts the brightest unshadowed pixel
there, so errors and tolerances are on the display's 0 ... 1 scale.
"""

import math

import bpy
import make_four_objects
import numpy as np
import penumbra_addon
from engine import ExportedScene

LIGHT_HEIGHT, LIGHT_SIDE, SPHERE_RADIUS = 3.6, 1.6, 0.8
SHAPES = {"square": ("SQUARE", 1.6, 1.6), "disk": ("DISK", 1.8054, 1.8054), "4:1 rectangle": ("RECTANGLE", 3.2, 0.8)}
"""Fig. 6's luminaires of equal area: Blender's shape and size."""


def new_scene(picture: tuple[int, int]):
    """An empty scene with Penumbra as its engine, black world, one ray through each pixel's centre."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.engine = penumbra_addon.ENGINE
    scene.render.resolution_x, scene.render.resolution_y = picture
    scene.render.resolution_percentage = 100
    scene.view_settings.view_transform = "Standard"
    scene.penumbra.pixel_samples = 1
    return scene


def add_camera(scene, location, target, vertical_degrees: float) -> None:
    camera = bpy.data.cameras.new("Camera")
    camera.sensor_fit, camera.angle = "VERTICAL", math.radians(vertical_degrees)
    scene.camera = bpy.data.objects.new("Camera", camera)
    scene.camera.location = location
    make_four_objects.look_at(scene.camera, target)
    scene.collection.objects.link(scene.camera)


def add_luminaire(scene, shape=SHAPES["square"], centre=(0.0, 0.0, LIGHT_HEIGHT)) -> None:
    """A luminaire of Blender's (shape, size, size_y) that faces down, 100 W."""
    light = bpy.data.lights.new("Luminaire", "AREA")
    light.energy = 100.0
    light.shape, light.size, light.size_y = shape
    light_object = bpy.data.objects.new("Luminaire", light)
    light_object.location = centre
    scene.collection.objects.link(light_object)


def sphere_on_ground(picture: tuple[int, int], shape: str = "square", sphere: bool = True):
    """Fig. 4: the ground, a sphere that rests on it, and one luminaire above; without the sphere nothing occludes."""
    scene = new_scene(picture)
    bpy.ops.mesh.primitive_plane_add(size=60)
    make_four_objects.finish("Ground", (0.8, 0.8, 0.8))
    if sphere:
        bpy.ops.mesh.primitive_uv_sphere_add(
            segments=128, ring_count=64, radius=SPHERE_RADIUS, location=(0, 0, SPHERE_RADIUS)
        )
        make_four_objects.finish("Sphere", (0.7, 0.7, 0.7), smooth=True)
    add_luminaire(scene, SHAPES[shape])
    add_camera(scene, (0.0, -5.5, 4.5), (0.0, 0.0, 0.3), 44)
    expose(scene)
    return scene


def four_objects(picture: tuple[int, int]):
    """Fig. 8: four objects, a floor and a square luminaire: the scene "S0" of this project's first measurements."""
    scene = new_scene(picture)
    add, finish = bpy.ops.mesh, make_four_objects.finish
    add.primitive_plane_add(size=24)
    finish("Floor", (0.8, 0.8, 0.8))
    add.primitive_uv_sphere_add(segments=64, ring_count=32, radius=0.6, location=(-1.1, -0.4, 0.6))
    finish("Sphere", (0.7, 0.7, 0.7), smooth=True)
    add.primitive_cube_add(size=1, location=(0.9, 0.5, 0.45), rotation=(0, 0, 0.5), scale=(0.8, 0.8, 0.9))
    finish("Box", (0.7, 0.7, 0.7))
    add.primitive_cylinder_add(vertices=64, radius=0.3, depth=0.8, location=(0.5, -0.9, 0.4))
    finish("Cylinder", (0.7, 0.7, 0.7))
    add.primitive_cone_add(vertices=64, radius1=0.5, depth=1.4, location=(-0.3, 1.1, 0.7))
    finish("Cone", (0.7, 0.7, 0.7))
    add_luminaire(scene, ("SQUARE", 1.8, 1.8), (1.2, -1.0, 3.4))
    add_camera(scene, (0.0, -5.2, 3.2), (0.0, 0.0, 0.3), 32)
    expose(scene)
    return scene


def four_objects_of_the_examples(picture: tuple[int, int]):
    """The scene of examples/make_four_objects.py: coloured objects, the luminaire twice as far away."""
    scene = new_scene(picture)
    make_four_objects.add_objects()
    make_four_objects.add_light(scene)
    make_four_objects.add_camera(scene)
    expose(scene)
    return scene


def shadows(scene, on: bool) -> None:
    """Lets the luminaires cast shadows or not."""
    for light in bpy.data.lights:
        light.use_shadow = on
        if hasattr(getattr(light, "cycles", None), "cast_shadow"):  # a second switch in older Blenders
            light.cycles.cast_shadow = on
    bpy.context.view_layer.update()


def unshadowed(scene) -> ExportedScene:
    """The scene as it would be lit if nothing hid anything."""
    shadows(scene, False)
    exported = ExportedScene(scene)
    shadows(scene, True)
    return exported


def expose(scene) -> None:
    """Exposure that makes the brightest unshadowed value, largest of r, g, b, white."""
    picture = unshadowed(scene).render(stop_rule="FIXED", light_samples=1024)
    scene.view_settings.exposure = -math.log2(np.max(picture.passes["Combined"][..., :3]))
