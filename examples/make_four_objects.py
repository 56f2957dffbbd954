# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes examples/four_objects.blend: a floor, four objects and one square area light, after the paper's Fig. 8.

Run it as `blender -b --factory-startup -P examples/make_four_objects.py`.
"""

import math
import sys
from pathlib import Path

import bpy
from mathutils import Vector

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER))

import penumbra_addon  # noqa: E402  (found through the line above)


def diffuse(name: str, colour: tuple[float, float, float]):
    """A Lambertian material; colour is scene linear."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    bsdf, output = nodes.new("ShaderNodeBsdfDiffuse"), nodes.new("ShaderNodeOutputMaterial")
    bsdf.inputs["Color"].default_value = (*colour, 1.0)
    material.node_tree.links.new(bsdf.outputs["BSDF"], output.inputs["Surface"])
    return material


def finish(name: str, colour: tuple[float, float, float], smooth: bool = False) -> None:
    """Names, colours and smooths the object that was just added."""
    new_object = bpy.context.object
    new_object.name = name
    new_object.data.materials.append(diffuse(name, colour))
    new_object.data.polygons.foreach_set("use_smooth", [smooth] * len(new_object.data.polygons))


def look_at(scene_object, target: tuple[float, float, float]) -> None:
    """Turns an object's -z axis towards a point, +y up."""
    direction = Vector(target) - scene_object.location
    scene_object.rotation_euler = direction.to_track_quat("-Z", "Y").to_euler()


def add_objects() -> None:
    add = bpy.ops.mesh
    add.primitive_plane_add(size=30)
    finish("Floor", (0.75, 0.75, 0.75))
    add.primitive_uv_sphere_add(segments=64, ring_count=32, radius=1.0, location=(-1.9, 0.4, 1.0))
    finish("Sphere", (0.65, 0.22, 0.16), smooth=True)
    add.primitive_cube_add(size=1.5, location=(0.6, 1.9, 0.75), rotation=(0, 0, math.radians(28)))
    finish("Cube", (0.22, 0.40, 0.70))
    add.primitive_cone_add(vertices=96, radius1=0.8, depth=2.0, location=(2.5, 0.1, 1.0))
    finish("Cone", (0.80, 0.62, 0.20))
    add.primitive_torus_add(major_segments=64, minor_segments=24, major_radius=0.75, minor_radius=0.25,
                            location=(0.35, -1.2, 0.25))  # fmt: skip
    finish("Torus", (0.30, 0.60, 0.30), smooth=True)


def add_light(scene) -> None:
    light = bpy.data.lights.new("Luminaire", "AREA")
    light.shape, light.size, light.energy = "SQUARE", 2.0, 600.0
    light_object = bpy.data.objects.new("Luminaire", light)
    light_object.location = (-2.8, -1.8, 6.8)
    look_at(light_object, (0.2, 0.3, 0.0))
    scene.collection.objects.link(light_object)


def add_camera(scene) -> None:
    camera = bpy.data.cameras.new("Camera")
    camera.lens = 45.0
    scene.camera = bpy.data.objects.new("Camera", camera)
    scene.camera.location = (0.4, -8.6, 6.0)
    look_at(scene.camera, (0.25, -0.1, 0.35))
    scene.collection.objects.link(scene.camera)


def main() -> None:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    penumbra_addon.load()
    scene = bpy.context.scene
    add_objects()
    add_light(scene)
    add_camera(scene)
    scene.world = bpy.data.worlds.new("Black")
    scene.world.color = (0.0, 0.0, 0.0)
    scene.render.engine = penumbra_addon.ENGINE
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 640, 480, 100
    scene.view_settings.view_transform = "Standard"
    scene.render.filepath = "//output/four_objects"
    bpy.context.preferences.filepaths.save_version = 0
    bpy.ops.wm.save_as_mainfile(filepath=str(FOLDER / "four_objects.blend"), compress=True, check_existing=False)


if __name__ == "__main__":
    try:
        main()
    except Exception as error:
        print(f"make_four_objects.py: {error}", file=sys.stderr)
        sys.exit(1)
