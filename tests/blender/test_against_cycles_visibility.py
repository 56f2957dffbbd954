# SPDX-License-Identifier: GPL-3.0-or-later
"""Luminaires that are seen themselves, ray visibility and linking, against Cycles in the same Blender.

What is seen has no noise: pixels are equal to 1e-4, but for those on an outline, where the two engines' single
precision may fall to either side. What is lit is compared as in the other tests: means within 0.3 %, relative RMSE
below 2.5 times Cycles' own noise (sqrt(2) times it is what equal pictures have, the rest is ours).
"""

import math

import bpy
import numpy as np
import pytest
from cycles_reference import away_from_edges, colour, converge_cycles, relative_rmse, render_with_penumbra
from helpers import (
    add_area_light,
    add_camera,
    add_light,
    add_plane,
    diffuse_material,
    emissive_material,
    render_pixels,
    use_cycles_as_reference,
)
from material_scenes import GLOSSY, Tree
from penumbra import compat, statistics

SEEN = {
    "square": ("AREA", {"size": 1.0}),
    "narrow ellipse": ("AREA", {"size": 2.0, "size_y": 1.4, "shape": "ELLIPSE", "spread": 1.5}),
    "ball": ("POINT", {"shadow_soft_size": 0.5}),
    "spot": ("SPOT", {"shadow_soft_size": 0.5, "spot_size": 2.0, "spot_blend": 0.15}),
    "narrow spot": ("SPOT", {"shadow_soft_size": 1.5, "spot_size": 0.6, "spot_blend": 0.5}),
    "sun": ("SUN", {"angle": 0.3}),
    "sharp point": ("POINT", {"shadow_soft_size": 0.0}),
}
OUTLINE = 0.06
"""Most pixels that may lie on the outline of what is seen: of a disk of 250 pixels some 50 do, a few of them differ."""


def mirror(colour_of_it=(1.0, 0.5, 0.2)):
    tree = Tree("Mirror")
    return tree.finish(tree.add(GLOSSY, {"Color": colour_of_it, "Roughness": 0.0}).outputs[0])


def assert_seen_alike(scene, name, mirrors=False) -> np.ndarray:
    """Both engines' pictures agree, alpha too; returns ours."""
    scene.penumbra.pixel_samples = 1
    ours = render_with_penumbra(scene, 64)["Combined"].astype(float)
    assert statistics.last_render["warnings"] == []
    use_cycles_as_reference(scene, 4)
    if mirrors:
        scene.cycles.max_bounces = scene.cycles.glossy_bounces = scene.penumbra.mirror_depth
        scene.cycles.diffuse_bounces = 0
    cycles = render_pixels(scene, "CYCLES")["Combined"].astype(float)
    # Blender 3's sun grows towards its rim, as 1 / cos^3 at half an angle of 0.15: 3.4 % in all. Cycles' rays are
    # 0.01 pixels wide, and a narrow spot changes by up to its whole value from pixel to pixel where it begins.
    tolerance = 0.035 if name == "sun" and compat.SUN_IS_FLAT else 0.01 if name == "narrow spot" else 1e-4
    differ = (abs(ours - cycles) > tolerance * np.maximum(cycles, 1e-2)).any(-1)
    assert differ.mean() < OUTLINE * (cycles[..., 0] > 1e-3).mean() + 1e-9
    return ours


@pytest.mark.parametrize("film", [False, True])
@pytest.mark.parametrize("name", SEEN)
def test_seen_by_the_camera(scene, name, film):
    """Before a coloured world, which shows through; the film's alpha does not know of it."""
    kind, data = SEEN[name]
    scene.render.film_transparent = film
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.2, 0.3, 0.4, 1)
    add_camera(scene, location=(0.1, 0.2, 5))
    light = add_light(scene, kind, data=data, power=3.0 if kind == "SUN" else 100.0, rotation=(math.pi + 0.2, 0.1, 0))
    light.visible_camera = True
    picture = assert_seen_alike(scene, name)
    assert (picture[..., 2].max() > 0.5) == (name != "sharp point")
    light.visible_camera = False
    hidden = render_pixels(scene)["Combined"]
    assert hidden[..., 0].max() == (0.0 if film else np.float32(0.2))


@pytest.mark.parametrize("name", SEEN)
def test_seen_in_a_mirror(scene, name):
    kind, data = SEEN[name]
    add_camera(scene, location=(0.3, 0.1, 5))
    add_plane(scene, size=3).data.materials.append(mirror())
    light = add_light(scene, kind, data=data, power=3.0 if kind == "SUN" else 100.0, location=(0, 0, 7))
    assert not light.visible_camera
    seen = assert_seen_alike(scene, name, mirrors=True)
    assert (seen[..., 2].max() > 0) == (name != "sharp point")
    light.visible_glossy = False
    assert assert_seen_alike(scene, name, mirrors=True).max(0).max(0)[:3].max() == 0


def test_a_luminaire_without_multiple_importance_sampling_is_not_seen(scene):
    add_camera(scene, location=(0.3, 0.1, 5))
    add_plane(scene, size=3).data.materials.append(mirror())
    light = add_area_light(scene, location=(0, 0, 7))
    light.data.cycles.use_multiple_importance_sampling = False
    assert assert_seen_alike(scene, "", mirrors=True)[..., :3].max() == 0


def test_hidden_by_surfaces_seen_from_behind_and_through_each_other(scene):
    """Three squares of light: one half behind a plane, one behind the other, one turned away."""
    add_camera(scene, location=(0, 0, 6))
    add_plane(scene, size=1.5, location=(0.8, 0, 1.0)).data.materials.append(diffuse_material("Black", (0, 0, 0)))
    for z, turn in ((0.0, math.pi), (-1.0, math.pi), (2.0, 0.0)):
        add_area_light(scene, rotation=(turn, 0, 0), location=(0, 0, z), size=1.0).visible_camera = True
    picture = assert_seen_alike(scene, "")
    values = np.unique(np.round(picture[..., 0], 3))
    assert len(values) >= 3 and values[0] == 0


def floor_and_blocker(scene):
    """A floor below a lamp, with a square in between."""
    add_camera(scene, location=(0, -4, 3), rotation=(0.93, 0, 0))
    floor = add_plane(scene, "Floor", size=5)
    floor.data.materials.append(diffuse_material("Grey", (0.6, 0.6, 0.6)))
    blocker = add_plane(scene, "Blocker", size=1.0, location=(-0.5, 0, 0.8))
    blocker.data.materials.append(diffuse_material("Red", (0.7, 0.2, 0.1)))
    return floor, blocker, add_area_light(scene, location=(0.3, 0.2, 2.5), size=0.8)


def assert_lit_alike(scene, margin=1) -> np.ndarray:
    ours = render_with_penumbra(scene)
    assert statistics.last_render["warnings"] == []
    cycles, noise = converge_cycles(scene, samples=128)
    inside, expected = away_from_edges(cycles, margin=margin), colour(cycles)
    difference = colour(ours) - expected
    assert abs(difference[inside].mean()) < 3e-3 * expected[inside].mean()
    assert relative_rmse(difference, expected, inside) < 2.5 * relative_rmse(noise, expected, inside)
    return colour(ours)


@pytest.mark.parametrize("flag", ["visible_camera", "visible_shadow"])
def test_an_object_that_some_rays_do_not_meet(scene, flag):
    _, blocker, _ = floor_and_blocker(scene)
    whole = render_with_penumbra(scene, 16)["Combined"]
    setattr(blocker, flag, False)
    assert abs(assert_lit_alike(scene) - whole[..., :3]).max() > 0.1


def test_an_object_that_mirrors_do_not_show(scene):
    """A wall behind the camera, seen in a mirror on the floor, and not."""
    add_camera(scene, location=(0, 0, 5))
    add_plane(scene, size=4).data.materials.append(mirror())
    wall = add_plane(scene, "Wall", size=2, location=(0, 0, 8))
    wall.data.materials.append(emissive_material("Glow", strength=0.5))
    assert assert_seen_alike(scene, "", mirrors=True).max(0).max(0)[0] == pytest.approx(0.5)
    wall.visible_glossy = False
    assert assert_seen_alike(scene, "", mirrors=True)[..., :3].max() == 0


def test_visibility_of_instances(scene):
    """What hides an instancer hides its instances."""
    _, blocker, _ = floor_and_blocker(scene)
    library = bpy.data.collections.new("Library")
    library.objects.link(blocker)
    instancer = bpy.data.objects.new("Instancer", None)
    instancer.instance_type, instancer.instance_collection = "COLLECTION", library
    instancer.location = (0.6, 0.4, 0.3)
    scene.collection.objects.link(instancer)
    instancer.visible_shadow = False
    assert_lit_alike(scene)


@pytest.mark.parametrize("flag", ["visible_diffuse", "visible_glossy"])
@pytest.mark.parametrize("kind", ["lamp", "mesh"])
def test_luminaires_that_light_some_lobes_alone(scene, kind, flag):
    floor, _, lamp = floor_and_blocker(scene)
    tree = Tree("Plastic")
    matt = tree.add("ShaderNodeBsdfDiffuse", {"Color": (0.5, 0.5, 0.5)}).outputs[0]
    sheen = tree.add(GLOSSY, {"Color": (0.9, 0.6, 0.3), "Roughness": 0.5}).outputs[0]
    floor.data.materials[0] = tree.finish(tree.add("ShaderNodeMixShader", {0: 0.5, 1: matt, 2: sheen}).outputs[0])
    if kind == "mesh":
        bpy.data.objects.remove(lamp)
        lamp = add_plane(scene, "Lamp", size=0.8, location=(0.3, 0.2, 2.5), rotation=(math.pi, 0, 0))
        lamp.data.materials.append(emissive_material("Glow", strength=30.0))
        lamp.visible_camera = False
    setattr(lamp, flag, False)
    assert_lit_alike(scene)


def linked(name: str, *objects, state="INCLUDE"):
    """A collection for light or shadow linking."""
    collection = bpy.data.collections.new(name)
    for member in objects:
        collection.objects.link(member)
        collection.collection_objects[-1].light_linking.link_state = state
    return collection


needs_linking = pytest.mark.skipif(bpy.app.version < (4, 0, 0), reason="linking came with Blender 4.0")


@needs_linking
@pytest.mark.parametrize("state", ["INCLUDE", "EXCLUDE"])
@pytest.mark.parametrize("what", ["receiver_collection", "blocker_collection"])
def test_linking(scene, what, state):
    floor, blocker, lamp = floor_and_blocker(scene)
    add_area_light(scene, "Other", location=(-1.5, 0.2, 2.5), size=0.8, power=40.0)
    whole = render_with_penumbra(scene, 16)["Combined"]
    member = floor if what == "receiver_collection" and state == "INCLUDE" else blocker
    setattr(lamp.light_linking, what, linked("Links", member, state=state))
    difference = abs(assert_lit_alike(scene) - whole[..., :3])
    # The blocker alone casts the shadow there is; what differs then is the noise of 16 points.
    assert (difference.mean() > 0.02) == ((what, state) != ("blocker_collection", "INCLUDE"))


@needs_linking
def test_linking_by_nested_collections_and_of_a_mesh(scene):
    """A glowing mesh that lights the floor alone, through a child collection, and is hidden by nothing."""
    floor, blocker, lamp = floor_and_blocker(scene)
    mesh = add_plane(scene, "Lamp", size=0.8, location=(-1.0, 0.2, 2.0), rotation=(math.pi, 0, 0))
    mesh.data.materials.append(emissive_material("Glow", strength=10.0))
    outer = bpy.data.collections.new("Outer")
    outer.children.link(linked("Inner", floor))
    outer.collection_children[0].light_linking.link_state = "INCLUDE"
    mesh.light_linking.receiver_collection = outer
    mesh.light_linking.blocker_collection = linked("Blockers", blocker, state="EXCLUDE")
    lamp.light_linking.blocker_collection = linked("Only the lamp", mesh)
    assert_lit_alike(scene)
