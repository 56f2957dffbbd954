# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces against Cycles: colours, both sides of a face, smooth and split normals, mirrored and stretched objects.

Objects stand alone, without a floor to take their shadow: what remains is their shading and their shadow on themselves.
"""

import math

import bpy
import numpy as np
import pytest
from cycles_reference import (
    NORMAL_TOLERANCE,
    away_from_edges,
    colour,
    converge_cycles,
    relative_rmse,
    render_with_penumbra,
)
from helpers import add_area_light, add_camera, add_plane, diffuse_material, link

COLOURS = [(0.8, 0.8, 0.8), (1.0, 1.0, 1.0), (0.9, 0.05, 0.02), (0.1, 0.7, 0.3), (0.01, 0.02, 0.5), (0.0, 0.0, 0.0)]


def assert_pictures_equal(scene, samples: int, tolerance: float, **edges) -> tuple[dict, dict]:
    """Relative RMSE below `tolerance` away from edges, Cycles' noise below half of that; both engines' passes."""
    ours = render_with_penumbra(scene)
    cycles, noise = converge_cycles(scene, samples)
    inside, expected = away_from_edges(cycles, **edges), colour(cycles)
    assert inside.sum() > 200
    assert relative_rmse(noise, expected, inside) < tolerance / 2
    assert relative_rmse(colour(ours) - expected, expected, inside) < tolerance
    return ours, cycles


def test_colours_of_diffuse_bsdfs(scene):
    """A row of squares under a light, each of another colour. Tolerance 0.1 %, in each colour's own square too."""
    materials = [diffuse_material(f"Colour {number}", rgb) for number, rgb in enumerate(COLOURS)] + [None]
    for number, material in enumerate(materials):
        square = add_plane(scene, f"Square {number}", size=1.0, location=(number - 3.0, 0, 0))
        if material:
            square.data.materials.append(material)
    add_area_light(scene, location=(0.5, 0.5, 3.0), rotation=(0.1, 0.2, 0.0), color=(1.0, 0.9, 0.8))
    add_camera(scene, location=(0, 0, 2), type="ORTHO", ortho_scale=7.0)
    scene.render.resolution_x, scene.render.resolution_y = 84, 12
    ours, cycles = assert_pictures_equal(scene, samples=512, tolerance=1e-3)
    for number in range(len(materials)):
        square = np.s_[2:10, 12 * number + 2 : 12 * number + 10]
        np.testing.assert_allclose(colour(ours)[square].mean((0, 1)), colour(cycles)[square].mean((0, 1)), rtol=1e-3)


@pytest.mark.parametrize("smooth", [False, True], ids=["flat", "smooth"])
@pytest.mark.parametrize("upside_down", [False, True])
@pytest.mark.parametrize("from_above", [False, True])
def test_both_sides_of_a_face_are_lit(scene, from_above, upside_down, smooth):
    """The side towards the light shines, wherever the face's normal points; the other one is black. Tolerance 0.1 %."""
    floor = add_plane(scene, size=6.0, rotation=(math.pi * upside_down, 0, 0))
    floor.data.polygons[0].use_smooth = smooth
    add_area_light(scene, location=(-1, 0.5, 3))
    add_camera(scene, location=(0, 0, 5 if from_above else -5), rotation=(0 if from_above else math.pi, 0, 0))
    if from_above:
        ours, cycles = assert_pictures_equal(scene, samples=256, tolerance=1e-3)
    else:
        ours, (cycles, _) = render_with_penumbra(scene), converge_cycles(scene, samples=4)
        assert not colour(ours).any() and not colour(cycles).any()
    np.testing.assert_allclose(ours["Normal"], cycles["Normal"], atol=NORMAL_TOLERANCE)


def add_shape(scene, shape: str, smooth: bool, **transform):
    """A coarse sphere or a cylinder with rounded side and sharp rims; everything else is the caller's."""
    if shape == "SPHERE":
        bpy.ops.mesh.primitive_uv_sphere_add(segments=16, ring_count=8, radius=1.0)
    else:
        bpy.ops.mesh.primitive_cylinder_add(vertices=12, radius=0.9, depth=1.6)
    added = bpy.context.object
    added.data.polygons.foreach_set("use_smooth", [smooth] * len(added.data.polygons))
    for name, value in transform.items():
        setattr(added, name, value)
    return added


def light_and_look(scene) -> None:
    add_area_light(scene, size=1.5, power=300.0, location=(-2, -2, 5), rotation=(0.4, -0.35, 0))
    add_camera(scene, location=(0, -4.5, 2.2), rotation=(1.12, 0, 0))


TRANSFORMS = {
    "plain": {},
    "mirrored": {"scale": (-1, 1, 1)},
    "mirrored thrice": {"scale": (-1, -1, -1)},
    "stretched": {"scale": (1.4, 0.7, 0.9), "rotation_euler": (0.3, 0.2, 0.9)},
    "stretched and mirrored": {"scale": (-1.4, 0.7, 0.9), "rotation_euler": (0.3, 0.2, 0.9)},
}


@pytest.mark.parametrize("transform", TRANSFORMS.values(), ids=TRANSFORMS)
@pytest.mark.parametrize("smooth", [False, True], ids=["flat", "smooth"])
@pytest.mark.parametrize("users", [1, 2], ids=["own mesh", "shared mesh"])
def test_sphere(scene, users, smooth, transform):
    """Tolerance 0.2 % for colours (seen: 0.05 %), 1e-3 for normals.

    Cycles' normals are a mean over its rays, which jitter by 0.005 pixels.
    A mesh used once is interpolated where it is placed, a shared one (its second user is out of sight) in its own
    space, in both renderers; on a stretched coarse mesh the two differ by up to 0.08.
    """
    sphere = add_shape(scene, "SPHERE", smooth, **transform)
    if users == 2:
        link(scene, "Second user", sphere.data, location=(0, 0, -50))
    light_and_look(scene)
    creases = {"crease_cosine": -1.0 if smooth else 0.999}
    ours, cycles = assert_pictures_equal(scene, samples=256, tolerance=2e-3, **creases)
    inside = away_from_edges(cycles, margin=1, **creases)
    np.testing.assert_allclose(ours["Normal"][inside], cycles["Normal"][inside], atol=1e-3)


def sharpen(mesh, angle: float) -> None:
    """Edges sharper than `angle` (radians) split the normals: auto smooth up to Blender 4.0, sharp edges since."""
    if hasattr(mesh, "use_auto_smooth"):
        mesh.use_auto_smooth, mesh.auto_smooth_angle = True, angle
    else:
        mesh.set_sharp_from_angle(angle=angle)


@pytest.mark.parametrize("scale", [(1, 1, 1), (1, -1, 1)], ids=str)
def test_cylinder_with_sharp_rims(scene, scale):
    """Tolerances as for the sphere; the rim is left out, the joints of the rounded side are not."""
    cylinder = add_shape(scene, "CYLINDER", True, rotation_euler=(0.5, 0.3, 0), scale=scale)
    sharpen(cylinder.data, math.radians(40))
    light_and_look(scene)
    ours, cycles = assert_pictures_equal(scene, samples=256, tolerance=2e-3, margin=1, crease_cosine=0.8)
    inside = away_from_edges(cycles, margin=1, crease_cosine=0.8)
    np.testing.assert_allclose(ours["Normal"][inside], cycles["Normal"][inside], atol=1e-3)


@pytest.mark.parametrize("tilt", [0.3, -0.2])
def test_custom_normals(scene, tilt):
    """A plane whose corner normals lean by `tilt` radians. Tolerance 0.1 % for colours, 1e-5 for normals.

    The lean is small: Cycles 3.4 bends a normal that would reflect the view below the surface, newer ones and Penumbra
    do not, for a diffuse surface.
    """
    plane = add_plane(scene, size=3.0)
    plane.data.polygons[0].use_smooth = True
    if hasattr(plane.data, "use_auto_smooth"):
        plane.data.use_auto_smooth = True
    plane.data.normals_split_custom_set([(math.sin(tilt), 0.0, math.cos(tilt))] * 4)
    light_and_look(scene)
    ours, cycles = assert_pictures_equal(scene, samples=256, tolerance=1e-3)
    inside = away_from_edges(cycles)
    np.testing.assert_allclose(ours["Normal"][inside], cycles["Normal"][inside], atol=NORMAL_TOLERANCE)
    np.testing.assert_allclose(ours["Normal"][inside][:, 0], math.sin(tilt), atol=1e-4)
