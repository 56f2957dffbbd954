# SPDX-License-Identifier: GPL-3.0-or-later
"""Acne and leaks: what single precision does to rays that start on a surface, at any size, place and tilt.

Acne oracle: a surface that nothing can shadow must be the same bit for bit with and without shadow rays, so that
one falsely hidden point of a pixel's 64 shows. Leak oracle: a point whose whole luminaire is covered must be
exactly black. These tests guard native/visibility/geometry.cpp's kRelativeRounding = 2^-21. Measured over 2^-26 ...
2^-17: at 2^-24 rays lose 1e-4 ... 1e-3 of the light on every kind of floor, at 2^-23 1e-5 where large triangles
meet small ones, from 2^-22 on nothing; contact gaps of 1e-6 of the scene's width leak from 2^-20 on, of 3e-6 from
2^-19 on, of 1e-5 from 2^-17 on.
"""

import numpy as np
import oracles
import penumbra_native as pn
import pytest
from scenes import add, apply, box, floor, look_down, parallelogram, render, rotation, scaling, sphere, translation

FIXED = {"stop_rule": "FIXED", "light_samples": 64}


def mixed_floor():
    """Two large triangles beside 19600 small ones."""
    a = parallelogram([-1, -1, 0], [1, 0, 0], [0, 2, 0])
    b = parallelogram([0, -1, 0], [1, 0, 0], [0, 2, 0], 70, 140)
    return np.concatenate([a[0], b[0]]), np.concatenate([a[1], b[1] + len(a[0])])


def fan(count=400):
    """Needles that meet in the middle, 130 times as long as wide at their ends."""
    a = 2 * np.pi * np.arange(count) / count
    positions = np.concatenate([[[0, 0, 0]], np.stack([2 * np.cos(a), 2 * np.sin(a), 0 * a], axis=1)])
    return positions, np.array([(0, 1 + i, 1 + (i + 1) % count) for i in range(count)], np.int32)


FLOORS = {"2 triangles": floor(1.0), "20k triangles": floor(1.0, columns=100), "mixed": mixed_floor(), "fan": fan()}
LIGHTS = {  # over a floor of half width 1: transform, size
    "above": (translation(0, 0, 1), 0.5),
    "close": (translation(0, 0, 0.25), 0.2),
    "low": (translation(1.5, 0, 0.05) @ rotation([0, 1, 0], 85), 0.08),  # 2 to 4 degrees over the far side
}


def placed(random, scale, offset):
    """A random tilt, a size and a place; `offset` in metres."""
    tilt = rotation(random.normal(size=3), random.uniform(0, 180))
    direction = random.normal(size=3)
    return translation(*(offset * direction / np.linalg.norm(direction))) @ tilt @ scaling(scale, scale, scale)


def camera_above(scene, matrix, half, distance=5.0):
    """Orthographic, in the units of a matrix that scales evenly."""
    size = np.linalg.norm(matrix[:3, 0])
    rigid = matrix @ translation(0, 0, distance)
    rigid[:3, :3] /= size
    scene.set_camera("ORTHOGRAPHIC", rigid, np.array([-half, half, -half, half]) * size, (0, 2 * distance * size))


def tilted(pieces, matrix, light, cast_shadow, half=0.98, baked=False, copies=(), distance=5.0):
    """Meshes of one material at matrix x piece, a luminaire, and a camera above. Baked: the matrix goes into the
    vertices, in float64. Copies: further instances of each mesh, by matrices that come before the piece's own."""
    scene = pn.Scene()
    grey = scene.add_material("grey", (0.5,) * 3)
    for i, (shape, piece) in enumerate(pieces):
        world = matrix @ piece
        vertices = apply(world, shape[0]) if baked else shape[0]
        mesh = scene.add_mesh(f"piece {i}", vertices, shape[1])
        scene.add_instance(f"piece {i}", mesh, np.eye(4) if baked else world, [grey])
        for copy in copies:
            scene.add_instance(f"copy {i}", mesh, matrix @ copy @ piece, [grey])
    where, size = light
    scene.add_area_light("key", "RECTANGLE", matrix @ where, (size, size), (1, 1, 1), cast_shadow)
    camera_above(scene, matrix, half, distance)
    return scene


def hidden_share(*arguments, width=24, **options):
    """Share of the light that shadow rays take away, where there is any; 0 only if all pixels are equal bit for
    bit."""
    with_rays, without = (render(tilted(*arguments[:3], cast, **options), width, **FIXED) for cast in (True, False))
    assert (without.red > 0).mean() > 0.5
    assert with_rays.statistics["shadow_rays"] > 0
    return 1 - with_rays.red.sum() / without.red.sum() if (with_rays.red != without.red).any() else 0.0


@pytest.mark.parametrize(
    "scale, offset", [(1e-6, 0), (1e-6, 1e-3), (1e-3, 10), (1, 0), (1, 1e3), (1, 1e6), (1, 1e7), (1e4, 1e7)]
)
@pytest.mark.parametrize("name", ["2 triangles", "20k triangles"])
def test_c31_floors_of_any_size_anywhere_have_no_acne(name, scale, offset):
    """Eight tilts by two luminaires; positions in float64 in the vertices and in the instance's matrix, in turn."""
    random = np.random.default_rng(1)
    for trial in range(8):
        matrix = placed(random, scale, offset)
        for light in ("above", "low"):
            assert hidden_share([(FLOORS[name], np.eye(4))], matrix, LIGHTS[light], baked=trial % 2 == 0) == 0, (
                trial,
                light,
            )


@pytest.mark.parametrize("light", LIGHTS)
@pytest.mark.parametrize("name", FLOORS)
def test_floors_of_all_kinds_have_no_acne(name, light):
    """16 tilts each; half of them with a second instance below, so that the mesh is shared."""
    random = np.random.default_rng(2)
    for trial in range(16):
        copies = [translation(0, 0, -0.7)] if trial % 2 else []
        share = hidden_share([(FLOORS[name], np.eye(4))], placed(random, 1, 0), LIGHTS[light], copies=copies)
        assert share == 0, trial


def test_shared_floors_in_the_scenes_centre_have_no_acne():
    """Large triangles, tilted in their own space too, seen close to the origin of render space, where coordinates say
    nothing of the triangles' size."""
    random = np.random.default_rng(11)
    copies, light = [translation(0, 0, -0.7), translation(0, 0, 0.7)], (translation(0, 0, 0.5), 0.3)
    for _ in range(16):
        turn = rotation(random.normal(size=3), random.uniform(0, 180))
        piece = ((apply(turn, FLOORS["2 triangles"][0]), FLOORS["2 triangles"][1]), turn.T)
        assert hidden_share([piece], placed(random, 1, 0), light, copies=copies, half=0.02, distance=0.3) == 0


def test_uneven_instances_have_no_acne():
    """A floor modelled 30 times too short and 100 times too thick, stretched by its instances."""
    random = np.random.default_rng(3)
    stretch = scaling(1, 30, 0.01)
    squeezed = (FLOORS["20k triangles"][0] * [1, 1 / 30, 100], FLOORS["20k triangles"][1])
    for _ in range(12):
        assert (
            hidden_share([(squeezed, stretch)], placed(random, 1, 0), LIGHTS["above"], copies=[translation(0, 0, -0.7)])
            == 0
        )


@pytest.mark.parametrize("where", [0.0, 0.9])
@pytest.mark.parametrize("size", [1e-2, 1e-4, 1e-6])
def test_c34_small_objects_in_large_scenes_have_no_acne(size, where):
    """A plate in the middle of a scene up to a million times as wide, and near its side."""
    random = np.random.default_rng(4)
    for _ in range(12):
        matrix = placed(random, 1, 0) @ translation(where, 0, 0) @ scaling(size, size, size)
        ground = parallelogram(np.array([-1 - where, -1, -1]) / size, [2 / size, 0, 0], [0, 2 / size, 0])
        assert hidden_share([(FLOORS["2 triangles"], np.eye(4)), (ground, np.eye(4))], matrix, LIGHTS["above"]) == 0


@pytest.mark.parametrize("segments", [16, 64, 256])
def test_convex_bodies_do_not_shadow_their_lit_side(segments):
    """Flat facets: a point of the luminaire above a facet's plane is above all others seen from it."""
    random = np.random.default_rng(5)
    for radius in (0.25, 0.01):
        for _ in range(4):
            ground = parallelogram([-1, -1, -1], [2, 0, 0], [0, 2, 0])
            pieces = [(sphere([0, 0, 0], radius, segments), np.eye(4)), (ground, np.eye(4))]
            assert hidden_share(pieces, placed(random, 1, 0), (translation(0, 0, 0.95), 0.3), half=0.7 * radius) == 0


def test_b26_coincident_faces_have_no_acne():
    """The same floor twice, in either winding and split otherwise: which one is hit first must not matter."""
    random = np.random.default_rng(6)
    one, two = FLOORS["2 triangles"], FLOORS["2 triangles"]
    for twin in (two, (two[0], two[1][:, ::-1].copy()), (two[0], np.array([[0, 1, 3], [0, 3, 2]], np.int32))):
        for _ in range(8):
            assert hidden_share([(one, np.eye(4)), (twin, np.eye(4))], placed(random, 1, 0), LIGHTS["above"]) == 0


@pytest.mark.parametrize("scale, offset", [(1e-6, 1e-3), (1, 1e7), (1e4, 0)])
def test_c31_tilted_floors_against_the_closed_form(scale, offset):
    """256 Owen-Sobol' points, luminaire at twice its size: relative error below 1e-3 everywhere (1e-4 standard
    error). Points of the tilted floor by hand, since float32 cannot say a Position at 1e7 m."""
    random = np.random.default_rng(7)
    where, size = LIGHTS["above"]
    centres = (np.arange(16) + 0.5) / 8 - 1
    x, y = np.meshgrid(0.98 * centres, 0.98 * centres)
    exact = 0.5 * oracles.parallel_rectangle(x, y, size / 2, 1.0)
    for name in ("2 triangles", "20k triangles"):
        for _ in range(6):
            matrix = placed(random, scale, offset)
            scene = tilted([(FLOORS[name], np.eye(4))], matrix, (where, size), True, baked=True)
            picture = render(scene, 16, stop_rule="FIXED", light_samples=256)
            # At 1e7 m the vertices themselves are rounded to 2e-9 m: nothing here.
            assert np.abs(picture.red / exact - 1).max() < 1e-3


@pytest.mark.parametrize("gap", [1e-2, 1e-3, 1e-4, 1e-5, 1e-6])
@pytest.mark.parametrize("name", ["2 triangles", "20k triangles", "mixed"])
def test_b25_contact_shadows_do_not_leak(name, gap):
    """A plate floating over a floor of the same shape at a distance of `gap` times the floor's width, seen from
    between: black, 8 tilts x 576 points x 64 rays."""
    random = np.random.default_rng(8)
    for _ in range(8):
        matrix = placed(random, 1, 0)
        scene = pn.Scene()
        for i, z in enumerate((0, 2 * gap)):
            add(scene, f"plate {i}", FLOORS[name], matrix @ translation(0, 0, z))
        scene.add_area_light("key", "RECTANGLE", matrix @ translation(0, 0, 1), (0.5, 0.5), (1, 1, 1))
        camera_above(scene, matrix, 0.5, gap)
        picture = render(scene, 24, **FIXED)
        assert picture.statistics["shadow_rays"] > 0
        assert (picture.red == 0).all()


@pytest.mark.parametrize("gap", [1e-2, 1e-3, 1e-4, 1e-5])
def test_plates_just_below_the_luminaire_hide_it(gap):
    """Twice the luminaire's size, `gap` times its distance below it: black everywhere. Rays end 2^-18 = 4e-6 short."""
    random = np.random.default_rng(12)
    for _ in range(4):
        matrix = placed(random, 1, 0)
        scene = pn.Scene()
        add(scene, "floor", FLOORS["20k triangles"], matrix)
        add(scene, "plate", parallelogram([-0.1, -0.1, 1 - gap], [0.2, 0, 0], [0, 0.2, 0]), matrix)
        scene.add_area_light("key", "RECTANGLE", matrix @ translation(0, 0, 1), (0.1, 0.1), (1, 1, 1))
        camera_above(scene, matrix, 0.98, 0.5)
        # At 0.98 x sqrt(2) to the side a plate at a gap of 1e-2 is still seen before the whole luminaire.
        picture = render(scene, 24, **FIXED)
        assert picture.statistics["shadow_rays"] > 0
        assert (picture.red == 0).all()


def test_b24_nothing_gets_out_of_a_closed_box():
    """The luminaire in a box that stands on the floor, 8 tilts x 2304 points x 640 rays: more than 1e7, none through
    an edge (Embree's own bar is one in 50,000)."""
    random, rays = np.random.default_rng(9), 0
    for _ in range(8):
        matrix = placed(random, 1, 0)
        scene = pn.Scene()
        add(scene, "floor", FLOORS["20k triangles"], matrix)
        add(scene, "box", box([-0.2, -0.2, 0], [0.2, 0.2, 0.4]), matrix)
        scene.add_area_light("key", "RECTANGLE", matrix @ translation(0, 0, 0.3), (0.2, 0.2), (1, 1, 1))
        camera_above(scene, matrix, 0.98)
        picture = render(scene, 48, stop_rule="FIXED", light_samples=640)
        rays += picture.statistics["shadow_rays"]
        assert (picture.red == 0).all()
    assert rays > 1e7


@pytest.mark.parametrize("overlap", [0.0, 1e-6])
def test_b23_nothing_gets_under_a_wall(overlap):
    """A wall on the floor, edge to plane or reaching 1e-6 through it; floor points from 1e-6 to 1e-4 behind its
    foot."""
    random = np.random.default_rng(10)
    for _ in range(12):
        matrix = placed(random, 1, 0)
        scene = pn.Scene()
        add(scene, "floor", FLOORS["2 triangles"], matrix)
        add(scene, "wall", parallelogram([0, -1, -overlap], [0, 2, 0], [0, 0, 1]), matrix)
        light = matrix @ translation(0.5, 0, 0.5) @ rotation([0, 1, 0], 45)
        scene.add_area_light("key", "RECTANGLE", light, (0.2, 0.2), (1, 1, 1))
        camera_above(scene, matrix @ translation(-5.05e-5, 0, 0), 4.95e-5)
        picture = render(scene, 24, **FIXED)
        assert picture.statistics["shadow_rays"] > 0
        assert (picture.red == 0).all()


def test_c34_a_small_object_in_a_huge_scene_keeps_its_shadow():
    """A plate 0.05 mm above a receiver of 1 mm, alone and in the middle of a scene 10 km wide: rays start off a
    surface in proportion to its own triangles, so both give the same picture. One point of 64 may fall otherwise: 2
    % of the pixels."""

    def picture(surroundings):
        scene = pn.Scene()
        add(scene, "receiver", floor(5e-4))
        add(scene, "plate", parallelogram([-5e-5, -5e-5, 5e-5], [1e-4, 0, 0], [0, 1e-4, 0]))
        for side in (-surroundings, surroundings):
            add(scene, "far", box([side - 1, side - 1, -1], [side + 1, side + 1, 1]))
        scene.add_area_light("key", "RECTANGLE", translation(0, 0, 2e-4), (1e-4, 1e-4), (1, 1, 1))
        look_down(scene, 2e-4, 4e-5)
        return render(scene, 16, **FIXED).red

    near, far = picture(10), picture(5e3)
    assert (near == 0).any() and (near > 0).any()
    assert (np.abs(near - far) > 1e-3 * near.max()).mean() < 0.02
