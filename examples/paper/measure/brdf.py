# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's BRDF, mirror + Phong + diffuse, from Blender's nodes: a picture, a furnace, and the width of a lobe."""

import bpy
import make_four_objects
import numpy as np
import scenes
from engine import ExportedScene, penumbra, render_in_blender
from methods import OWEN_SOBOL
from sizes import Size
from tables import Data, Row

ROUGHNESSES = (0.2, 0.35, 0.5)
FURNACE_ALBEDO, FURNACE_SIDE, FURNACE_POINTS = 0.8, 16.0, 1 << 18
FURNACE_ROUGHNESSES, FURNACE_DEGREES = (1.0, 0.7, 0.5, 0.35), (0, 30, 45, 60, 75)
GLOSSY = "ShaderNodeBsdfGlossy" if hasattr(bpy.types, "ShaderNodeBsdfGlossy") else "ShaderNodeBsdfAnisotropic"


def measure(data: Data, size: Size) -> None:
    data.write_pictures("brdf", picture=render_in_blender(three_terms(tuple(3 * n for n in size.picture))))
    data.write("brdf_furnace", furnace())
    data.write("brdf_lobes", lobes())


def glossy(name: str, colour, roughness: float, diffuse=None):
    """A Glossy BSDF, or half of it and half of a Diffuse BSDF of colour `diffuse`, through a Mix Shader."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    output, shader = nodes.new("ShaderNodeOutputMaterial"), nodes.new(GLOSSY)
    shader.distribution = "ASHIKHMIN_SHIRLEY"  # what Penumbra renders as the paper's Phong lobe
    shader.name = "Lobe"
    shader.inputs["Color"].default_value = (*colour, 1)
    shader.inputs["Roughness"].default_value = roughness
    if diffuse:
        base, mix = nodes.new("ShaderNodeBsdfDiffuse"), nodes.new("ShaderNodeMixShader")
        base.inputs["Color"].default_value = (*diffuse, 1)
        links.new(base.outputs[0], mix.inputs[1])
        links.new(shader.outputs[0], mix.inputs[2])
        shader = mix
    links.new(shader.outputs[0], output.inputs["Surface"])
    return material


def three_terms(picture: tuple[int, int]):
    """Three spheres of growing roughness, diffuse and Phong, before a mirror that stands on the floor."""
    scene = scenes.new_scene(picture)
    add = bpy.ops.mesh
    add.primitive_plane_add(size=24)
    make_four_objects.finish("Floor", (0.6, 0.6, 0.6))
    for x, roughness in zip((-1.5, 0.0, 1.5), ROUGHNESSES, strict=True):
        add.primitive_uv_sphere_add(segments=128, ring_count=64, radius=0.6, location=(x, 0, 0.6))
        make_four_objects.finish("Sphere", (1, 1, 1), smooth=True)
        bpy.context.object.data.materials[0] = glossy("Phong", (0.9, 0.9, 0.9), roughness, (0.65, 0.25, 0.12))
    add.primitive_cube_add(size=1, location=(0, 1.6, 0.9), scale=(4.6, 0.1, 1.8))
    make_four_objects.finish("Mirror", (1, 1, 1))
    bpy.context.object.data.materials[0] = glossy("Mirror", (0.85, 0.85, 0.85), 0.0)
    scenes.add_luminaire(scene, ("SQUARE", 1.2, 1.2), (-1.0, -2.2, 3.6))
    scenes.add_camera(scene, (0.9, -6.6, 3.2), (0.0, 0.4, 0.55), 32)
    scene.view_settings.exposure = 0.0
    bpy.data.lights["Luminaire"].energy = 220.0
    settings = scene.penumbra
    settings.stop_rule, settings.light_samples, settings.pixel_samples = "FIXED", 16, 16
    settings.sampler, settings.sample_reuse = OWEN_SOBOL
    return scene


def furnace() -> list[Row]:
    """Light that a plane of Phong albedo 0.8 sends back under a square luminaire 16 times as wide as it is high, in
    units of the luminaire's radiance, by the engine and by a midpoint sum over the luminaire."""
    rows = []
    for roughness in FURNACE_ROUGHNESSES:
        scene = scenes.new_scene((4, 4))  # Blender's smallest
        bpy.ops.mesh.primitive_plane_add(size=0.1)
        bpy.context.object.data.materials.append(glossy("Phong", [FURNACE_ALBEDO] * 3, roughness))
        scenes.add_luminaire(scene, ("SQUARE", FURNACE_SIDE, FURNACE_SIDE), (0, 0, 1))
        scenes.add_camera(scene, (0, 0, 0.5), (0, 0, 0), 1)
        radiance = penumbra.export.luminaires.area_radiance(100.0, (1.0, 1.0, 1.0), FURNACE_SIDE**2)[0]
        for degrees in FURNACE_DEGREES:
            angle = np.radians(degrees)
            scene.camera.location = 0.5 * np.sin(angle), 0, 0.5 * np.cos(angle)
            scene.camera.rotation_euler = 0, angle, 0
            exported = ExportedScene(scene)
            exported.size = (1, 1)  # so that the one pixel's ray is the camera's axis
            picture = exported.render(stop_rule="FIXED", light_samples=FURNACE_POINTS, **OWEN_SOBOL.settings)
            exponent = penumbra.export.brdf.phong_exponent(roughness)
            rows.append({"roughness": roughness, "exponent": exponent, "degrees": degrees,
                         "reflected": float(picture.passes["Combined"][0, 0, 1]) / radiance,
                         "exact": furnace_sum(exponent, angle)})  # fmt: skip
    return rows


def furnace_sum(exponent: float, angle: float, side: int = 1024) -> float:
    """The modified Phong BRDF albedo (n + 2) / (2 pi) cos^n over the furnace's luminaire, seen at this angle."""
    place = (np.arange(side) + 0.5) / side * FURNACE_SIDE - FURNACE_SIDE / 2
    x, y = np.meshgrid(place, place)
    length = np.sqrt(x * x + y * y + 1)
    cosine = (np.cos(angle) - x * np.sin(angle)) / length  # to the mirror direction, which leans to -x
    lobe = np.where(cosine > 0, np.abs(cosine) ** exponent, 0)
    cosines = 1 / length**4
    return float(FURNACE_ALBEDO * (exponent + 2) / (2 * np.pi) * np.sum(lobe * cosines) * (FURNACE_SIDE / side) ** 2)


def lobes() -> list[Row]:
    """The highlight of a small luminaire on a glossy plane seen from above, Penumbra's and Cycles', each with its peak
    at 1. `degrees`: between the mirror direction and the luminaire."""
    rows = []
    for roughness in ROUGHNESSES:
        scene = scenes.new_scene((256, 1))
        bpy.ops.mesh.primitive_plane_add(size=40)
        bpy.context.object.data.materials.append(glossy("Glossy", (1, 1, 1), roughness))
        scenes.add_luminaire(scene, ("SQUARE", 0.05, 0.05), (0, 0, 4))
        scenes.add_camera(scene, (0, 0, 3), (0, 0, 0), 1)
        scene.camera.rotation_euler = (0, 0, 0)
        scene.camera.data.sensor_fit = "AUTO"
        scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 12.0
        scene.penumbra.stop_rule, scene.penumbra.light_samples = "FIXED", 64
        cycles = scene.cycles
        cycles.samples, cycles.max_bounces, cycles.use_denoising, cycles.use_adaptive_sampling = 256, 0, False, False
        cycles.blur_glossy = cycles.light_sampling_threshold = 0.0
        cycles.filter_width = 0.01
        for engine in ("PENUMBRA", "CYCLES"):
            scene.render.engine = engine
            if engine == "CYCLES":
                bpy.context.object.data.materials[0].node_tree.nodes["Lobe"].distribution = "GGX"
            row = render_in_blender(scene)[0, :, 1]
            degrees = np.degrees(np.arctan(((np.arange(256) + 0.5) / 256 - 0.5) * 12.0 / 4))
            rows += [{"roughness": roughness, "engine": engine, "degrees": float(d), "radiance": float(v / row.max())}
                     for d, v in zip(degrees, row, strict=True)]  # fmt: skip
    return rows
