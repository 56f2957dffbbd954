# SPDX-License-Identifier: GPL-3.0-or-later
"""Instances: uneven, mirrored and shared placements give what their triangles in world space give, and mirrors
reflect."""

import numpy as np
import oracles
import penumbra_native as pn
import pytest
from scenes import (
    add,
    apply,
    box,
    floor,
    light_above,
    look_down,
    parallelogram,
    render,
    rotation,
    scaling,
    sphere,
    translation,
)

MATRICES = {
    "uneven": translation(0.2, 0.1, 0.7) @ rotation([1, 2, 0], 35) @ scaling(1.5, 0.3, 0.8),
    "mirrored": translation(-0.2, 0.1, 0.7) @ rotation([0, 1, 1], 25) @ scaling(-1, 0.6, 1),
    "turned inside out": translation(0, 0, 0.7) @ scaling(-0.8, -0.9, -0.7),
    "sheared": translation(0, 0, 0.7) @ np.array([[0.8, 0.4, 0, 0], [0, 0.7, 0.2, 0], [0, 0, 0.9, 0], [0, 0, 0, 1.0]]),
    "flat": translation(0, 0, 0.7) @ scaling(1, 1, 1e-5),
}
FIXED = {"stop_rule": "FIXED", "light_samples": 64}


def empty_floor():
    scene = pn.Scene()
    add(scene, "floor", floor())
    scene.add_area_light("key", "RECTANGLE", light_above(2.5) @ rotation([1, 0, 0], 20), (1, 1), (3, 3, 3))
    look_down(scene, 1.5)
    return scene


def smooth_ball():
    positions, triangles = sphere([0.05, 0, 0], 0.4, 12)
    return positions, triangles, ((positions - [0.05, 0, 0]) / 0.4)[triangles].astype(np.float32)


def moved(positions, triangles, normals=None, *, matrix):
    """The same triangles with the matrix applied to them: normals by the inverse transpose, in float64."""
    if np.linalg.det(matrix[:3, :3]) < 0:  # so that the winding still says which side is outside
        triangles = triangles[:, ::-1].copy()
        normals = None if normals is None else normals[:, ::-1]
    if normals is None:
        return apply(matrix, positions), triangles
    turned = normals.astype(float) @ np.linalg.inv(matrix[:3, :3])
    turned /= np.linalg.norm(turned, axis=-1, keepdims=True)
    return apply(matrix, positions), triangles, turned.astype(np.float32)


def differing(a, b, tolerance=1e-5):
    """Share of the pixels that differ by more than rounding: of silhouettes and of rays that graze an edge."""
    white = np.abs(b.passes["Combined"]).max()
    far = (np.abs(a.passes["Combined"] - b.passes["Combined"]) > tolerance * white).any(axis=-1)
    far |= (np.abs(a.passes["Normal"] - b.passes["Normal"]) > 1e-3).any(axis=-1)
    return far.mean()


@pytest.mark.parametrize("shared", [False, True], ids=["single", "shared"])
@pytest.mark.parametrize("name", MATRICES)
def test_instance_equals_its_triangles_in_world_space(name, shared):
    """Instance transforms against positions and normals transformed here (shared meshes flat: their normals are
    interpolated in object space, as in Cycles, which the core's own tests look at). One shadow ray of 64 falling
    otherwise would show: allowed in 1 % of the pixels, where a silhouette or a shadow's edge is met within
    rounding."""
    matrix = MATRICES[name]
    other = translation(-0.9, -0.8, 0.5) @ scaling(0.5, 0.5, 0.5)
    by_instance, by_triangles = empty_floor(), empty_floor()
    grey = by_instance.add_material("grey", (0.4,) * 3)
    ball = smooth_ball()[: 2 if shared else 3]
    mesh = by_instance.add_mesh("ball", *ball)
    by_instance.add_instance("ball", mesh, matrix, [grey])
    add(by_triangles, "ball", moved(*ball, matrix=matrix), albedo=0.4)
    if shared:
        by_instance.add_instance("other", mesh, other, [grey])
        add(by_triangles, "other", moved(*ball, matrix=other), albedo=0.4)
    a, b = render(by_instance, 48, **FIXED), render(by_triangles, 48, **FIXED)
    assert (a.red != render(empty_floor(), 48, **FIXED).red).mean() > 0.05
    assert differing(a, b) < 0.01


def test_shared_meshes_far_from_their_own_origin():
    """A mesh modelled 1e6 m from its origin and brought back by its instances: single precision has steps of 6 cm
    there, so meshes must be recentred before they are rounded."""
    away = np.array([1e6, -2e6, 5e5])
    positions, triangles = box([-0.3, -0.3, -0.3], [0.3, 0.3, 0.3])
    a, b = empty_floor(), empty_floor()
    for scene, shift in ((a, away), (b, 0 * away)):
        grey = scene.add_material("grey", (0.5,) * 3)
        mesh = scene.add_mesh("crate", positions + shift, triangles)
        for x in (-0.7, 0.7):
            scene.add_instance("crate", mesh, translation(x, 0, 0.6) @ translation(*-shift), [grey])
    assert differing(render(a, 48, **FIXED), render(b, 48, **FIXED), 1e-4) < 0.01


def test_an_instance_of_scale_zero_is_not_there():
    scene = empty_floor()
    add(scene, "nothing", box([-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]), translation(0, 0, 1) @ scaling(0, 0, 0))
    mesh = scene.add_mesh("empty", np.zeros((0, 3)), np.zeros((0, 3), np.int32))
    scene.add_instance("empty", mesh, np.eye(4), [scene.add_material("grey", (0.5,) * 3)])
    assert (render(scene, 16, **FIXED).red == render(empty_floor(), 16, **FIXED).red).all()


def test_material_slots_and_instances_with_other_materials():
    scene = pn.Scene()
    half = parallelogram([-1, -1, 0], [2, 0, 0], [0, 2, 0], 2, 1)
    numbers = [scene.add_material(f"m{i}", (a,) * 3) for i, a in enumerate((0.1, 0.2, 0.4, 0.8))]
    mesh = scene.add_mesh("plate", *half, None, np.array([0, 0, 5, 5], np.int32))
    scene.add_instance("left", mesh, translation(-1, 0, 0), numbers[:2])
    scene.add_instance("right", mesh, translation(1, 0, 0), numbers[2:])
    scene.add_area_light("key", "RECTANGLE", light_above(3), (1, 1), (1, 1, 1))
    look_down(scene, 2.0)
    picture = render(scene, 4, **FIXED)
    white = pn.Scene()
    add(white, "floor", floor(2.0), albedo=1.0)
    white.add_area_light("key", "RECTANGLE", light_above(3), (1, 1), (1, 1, 1))
    look_down(white, 2.0)
    albedo = picture.red[1:3] / render(white, 4, **FIXED).red[1:3]
    np.testing.assert_allclose(albedo, np.broadcast_to([0.1, 0.2, 0.4, 0.8], (2, 4)), rtol=1e-5)


def test_a_mirror_shows_what_is_in_it():
    """A mirror at 45 degrees over the floor, looked at from the side: the floor's radiance by Lambert's formula,
    times the mirror's albedo. 4096 points: 1e-4."""
    scene = pn.Scene()
    add(scene, "floor", floor())
    silver = scene.add_material("silver", (0, 0, 0), mirror=(0.9, 0.9, 0.9))
    plate = scene.add_mesh("mirror", *parallelogram([-0.3, 0.3, 0.4], [0.6, 0, 0], [0, -0.6, 0.6]))
    scene.add_instance("mirror", plate, np.eye(4), [silver])
    light = translation(0, -2.0, 2.0) @ rotation([1, 0, 0], 10)
    scene.add_area_light("key", "RECTANGLE", light, (1, 1), (3, 3, 3))
    # Looks along +y from y = -3 at the mirror; at height z the ray meets it at y = 0.7 - z and goes straight down.
    scene.set_camera(
        "ORTHOGRAPHIC", translation(0, -3, 0.7) @ rotation([1, 0, 0], 90), (-0.2, 0.2, -0.2, 0.2), (0.01, 20)
    )
    picture = render(scene, 6, stop_rule="FIXED", light_samples=4096)
    place = -0.2 + (np.arange(6) + 0.5) * 0.4 / 6
    x, y = np.meshgrid(place, place)
    points = np.stack([x, -y, 0 * x], axis=-1)
    exact = (
        0.9 * 0.5 * 3 * oracles.lambert_on(oracles.rectangle_corners(light, (1, 1)), points, (0, 0, 1), -light[:3, 2])
    )
    mirror = oracles.triangles_of(*parallelogram([-0.3, 0.3, 0.4], [0.6, 0, 0], [0, -0.6, 0.6]))
    corners = oracles.rectangle_corners(light, (1.02, 1.02))
    assert not any(oracles.occluded(np.repeat(p[None], 4, 0), corners, mirror).any() for p in points.reshape(-1, 3))
    np.testing.assert_allclose(picture.red, exact, rtol=1e-4)
    np.testing.assert_allclose(picture.position, np.stack([x, -y, 0.7 + y], axis=-1), atol=1e-5)  # on the mirror itself
    assert picture.statistics["mirror_rays"] == 36
    assert (render(scene, 6, stop_rule="FIXED", mirror_depth=0).red == 0).all()


def test_mirror_depth():
    """Two parallel mirrors of albedo 0.5: each bounce halves what the background sends; bounces beyond the limit
    are black."""
    scene = pn.Scene()
    for x, s in ((-0.5, 1), (0.5, -1)):
        add(
            scene,
            f"mirror {x}",
            parallelogram([x, -s, -5], [0, 2 * s, 0], [0, 0, 10]),
            albedo=0.0,
            mirror=(0.5, 0.5, 0.5),
        )
    scene.set_background((1, 1, 1))
    # From the middle at 45 degrees: meets mirrors at heights 0.5, 1.5, 2.5, 3.5, 4.5 and leaves.
    scene.set_camera("PERSPECTIVE", rotation([0, 1, 0], 135), (-1e-3, 1e-3, -1e-3, 1e-3), (0.01, 100))
    for depth, expected in ((4, 0), (5, 0.5**5), (9, 0.5**5)):
        assert render(scene, 1, mirror_depth=depth).red == pytest.approx(expected, abs=1e-7)


@pytest.mark.parametrize("copies", [1, 2])
@pytest.mark.parametrize("moves", [False, True])
def test_normals_of_vertices_are_those_of_their_corners(copies, moves):
    """Oracle: the same normals at each corner; a triangle without area among them, and a mesh of its own or shared."""
    positions, triangles, corners = smooth_ball()
    normals = np.zeros((len(positions), 3), np.float32)
    normals[triangles] = corners
    triangles = np.concatenate([[[0, 0, 1]], triangles]).astype(np.int32)
    pictures = []
    for given in (normals, normals[triangles], None):
        scene = pn.Scene()
        shapes = [positions, positions + [0.1, 0, 0]]
        motion = {"position_motion": shapes} if moves else {}
        if moves and given is not None:
            motion["normal_motion"] = [given, given]
        mesh = scene.add_mesh("ball", positions, triangles, given, **motion)
        grey = scene.add_material("grey", (0.5,) * 3)
        for i in range(copies):
            scene.add_instance(f"ball {i}", mesh, translation(0.9 * i - 0.4, 0, 0.5), [grey])
        scene.add_area_light("key", "RECTANGLE", light_above(), (1, 1), (3, 3, 3))
        look_down(scene)
        pictures.append(render(scene, 24, stop_rule="FIXED", pixel_samples=4))
    for name, values in pictures[0].passes.items():
        assert np.array_equal(values, pictures[1].passes[name]), name
    assert not np.array_equal(pictures[0].passes["Normal"], pictures[2].passes["Normal"])  # which is flat


def test_normals_of_vertices_must_be_as_many():
    positions, triangles, _ = smooth_ball()
    with pytest.raises(ValueError, match="corner_normals has shape"):
        pn.Scene().add_mesh("ball", positions, triangles, np.zeros((len(positions) - 1, 3), np.float32))
