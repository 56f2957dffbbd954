# SPDX-License-Identifier: GPL-3.0-or-later
"""What a scene refuses, always with the object's name in the message; and array layouts that must work."""

import numpy as np
import penumbra_native as pn
import pytest
from scenes import floor, light_above, look_down, render, sphere

NAME = "Würfel 'ß'\n√2"
POSITIONS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
TRIANGLES = np.array([[0, 1, 2]], np.int32)


def with_value(array, value, index=(1, 2)):
    changed = np.array(array, float)
    changed[index] = value
    return changed


@pytest.mark.parametrize("positions, triangles, words", [
    (with_value(POSITIONS, np.nan), TRIANGLES, "vertex 1 is not finite"),
    (with_value(POSITIONS, np.inf), TRIANGLES, "vertex 1 is not finite"),
    (with_value(POSITIONS, -np.inf).astype(np.float32), TRIANGLES, "vertex 1 is not finite"),
    (POSITIONS[:, :2], TRIANGLES, "positions has shape"),
    (POSITIONS.ravel(), TRIANGLES, "positions has shape"),
    (POSITIONS.astype(np.int32), TRIANGLES, "positions has type int32"),
    (POSITIONS.astype(complex), TRIANGLES, "positions has type complex"),
    (POSITIONS, TRIANGLES.ravel(), "triangles has shape"),
    (POSITIONS, np.array([[0, 1, 2, 2]]), "triangles has shape"),
    (POSITIONS, TRIANGLES.astype(float), "triangles has type float64"),
    (POSITIONS, TRIANGLES.astype(bool), "triangles has type bool"),
    (POSITIONS, np.array([[0, 1, 3]], np.int32), "triangle 0 names vertex 3"),
    (POSITIONS, np.array([[0, 1, 2], [0, -1, 2]], np.int32), "triangle 1 names vertex"),
    (POSITIONS, np.array([[0, 1, -1]], np.int64), "triangle 0 names vertex -1"),
    (POSITIONS, np.array([[0, 1, 2**32]], np.int64), "triangle 0 names vertex 4294967296"),
    (POSITIONS, np.array([[0, 1, 2**31]], np.uint32), "triangle 0 names vertex 2147483648"),
    (POSITIONS[:0], TRIANGLES, "triangle 0 names vertex 0"),
])
def test_meshes(positions, triangles, words):
    with pytest.raises(ValueError, match=words) as refusal:
        pn.Scene().add_mesh(NAME, positions, triangles)
    assert str(refusal.value).startswith(NAME + ": ")


@pytest.mark.parametrize("arguments, words", [
    ({"corner_normals": np.zeros((1, 3), np.float32)}, "corner_normals has shape"),
    ({"corner_normals": np.zeros((2, 3, 3), np.float32)}, "corner_normals has shape"),
    ({"corner_normals": np.zeros((1, 3, 3), np.int32)}, "corner_normals has type"),
    ({"material_slots": np.zeros(2, np.int32)}, "material_slots has shape"),
    ({"material_slots": np.zeros(1)}, "material_slots has type"),
])
def test_mesh_attributes(arguments, words):
    with pytest.raises(ValueError, match=words) as refusal:
        pn.Scene().add_mesh(NAME, POSITIONS, TRIANGLES, **arguments)
    assert NAME in str(refusal.value)


@pytest.mark.parametrize("material", [
    {"diffuse": (1.1, 0, 0)}, {"diffuse": (-0.1, 0, 0)}, {"diffuse": (np.nan, 0, 0)}, {"diffuse": (0.5,) * 3, "phong": (0.6, 0, 0)},
    {"diffuse": (0.4,) * 3, "phong": (0.4,) * 3, "mirror": (0, 0, 0.3)}, {"diffuse": (0,) * 3, "phong_exponent": -1.0},
    {"diffuse": (0,) * 3, "phong_exponent": np.nan}, {"diffuse": (0,) * 3, "phong_exponent": np.inf},
    {"diffuse": (0,) * 3, "mirror": (np.inf, 0, 0)}, {"diffuse": (0,) * 3, "phong": (0, np.nan, 0)},
])
def test_materials(material):
    with pytest.raises(ValueError) as refusal:
        pn.Scene().add_material(NAME, **material)
    assert NAME in str(refusal.value)


def test_colours_that_add_up_to_one_in_float32_are_fine():
    third = float(np.float32(1 / 3))
    assert pn.Scene().add_material("white", (third,) * 3, (third,) * 3, 10.0, (1 - 2 * third + 5e-7,) * 3) == 0


def bad_matrices():
    yield "not finite", with_value(np.eye(4), np.nan)
    yield "not finite", with_value(np.eye(4), np.inf, (0, 3))
    yield "last row", with_value(np.eye(4), 0.1, (3, 0))
    yield "last row", with_value(np.eye(4), np.nan, (3, 3))
    yield "has shape", np.eye(3)
    yield "has type", np.eye(4, dtype=int)


@pytest.mark.parametrize("words, matrix", bad_matrices())
def test_transforms(words, matrix):
    scene = pn.Scene()
    mesh, grey = scene.add_mesh("m", POSITIONS, TRIANGLES), scene.add_material("grey", (0.5,) * 3)
    for call in (lambda: scene.add_instance(NAME, mesh, matrix, [grey]),
                 lambda: scene.add_area_light(NAME, "RECTANGLE", matrix, (1, 1), (1, 1, 1))):
        with pytest.raises(ValueError, match=words) as refusal:
            call()
        assert NAME in str(refusal.value)
    with pytest.raises(ValueError, match="camera"):
        scene.set_camera("PERSPECTIVE", matrix, (-1, 1, -1, 1), (0.1, 10))


def test_instances():
    scene = pn.Scene()
    mesh, grey = scene.add_mesh("m", POSITIONS, TRIANGLES), scene.add_material("grey", (0.5,) * 3)
    for arguments, words in (((7, np.eye(4), [grey]), "no mesh"), ((mesh, np.eye(4), []), "no material"),
                             ((mesh, np.eye(4), [grey, 9]), "no material with number 9")):
        with pytest.raises(ValueError, match=words) as refusal:
            scene.add_instance(NAME, *arguments)
        assert NAME in str(refusal.value)


@pytest.mark.parametrize("arguments", [
    ("CIRCLE", (1, 1), (1, 1, 1)), ("RECTANGLE", (-1, 1), (1, 1, 1)), ("RECTANGLE", (np.nan, 1), (1, 1, 1)),
    ("ELLIPSE", (1, np.inf), (1, 1, 1)), ("RECTANGLE", (1, 1), (np.nan, 0, 0)), ("RECTANGLE", (1, 1), (0, np.inf, 0)),
])
def test_lights(arguments):
    shape, size, radiance = arguments
    with pytest.raises(ValueError) as refusal:
        pn.Scene().add_area_light(NAME, shape, np.eye(4), size, radiance)
    assert NAME in str(refusal.value)


@pytest.mark.parametrize("kind, window, clip", [
    ("FISHEYE", (-1, 1, -1, 1), (0.1, 10)), ("PERSPECTIVE", (1, 1, -1, 1), (0.1, 10)), ("PERSPECTIVE", (-1, 1, 2, 2), (0.1, 10)),
    ("PERSPECTIVE", (-np.inf, 1, -1, 1), (0.1, 10)), ("PERSPECTIVE", (-1, np.nan, -1, 1), (0.1, 10)),
    ("ORTHOGRAPHIC", (-1, 1, -1, 1), (10, 0.1)), ("ORTHOGRAPHIC", (-1, 1, -1, 1), (np.nan, 1)),
    ("ORTHOGRAPHIC", (-1, 1, -1, 1), (0, np.nan)), ("ORTHOGRAPHIC", (-1, 1, -1, 1), (1, 1)),
])
def test_cameras(kind, window, clip):
    with pytest.raises(ValueError, match="camera"):
        pn.Scene().set_camera(kind, np.eye(4), window, clip)


def test_background_and_missing_camera():
    scene = pn.Scene()
    with pytest.raises(ValueError, match="background"):
        scene.set_background((np.nan, 0, 0))
    with pytest.raises(ValueError, match="no camera"):
        pn.Render(scene, {"width": 4, "height": 4})


def test_meshes_are_fixed_once_rendered_and_the_rest_is_not():
    scene = pn.Scene()
    grey = scene.add_material("grey", (0.5,) * 3)
    mesh = scene.add_mesh("floor", *floor())
    scene.add_instance("floor", mesh, np.eye(4), [grey])
    look_down(scene)
    assert (render(scene, 4).red == 0).all()
    for call in (lambda: scene.add_mesh(NAME, POSITIONS, TRIANGLES), lambda: scene.add_instance(NAME, mesh, np.eye(4), [grey])):
        with pytest.raises(ValueError, match="rendered already") as refusal:
            call()
        assert NAME in str(refusal.value)
    scene.add_area_light("key", "RECTANGLE", light_above(), (1, 1), (1, 1, 1))
    assert (render(scene, 4).red > 0).all()


def layouts():
    positions, triangles = sphere([0, 0, 0.7], 0.5, 10)
    positions = positions.astype(np.float32)
    normals = np.array(positions - [0, 0, 0.7], np.float32)[triangles]
    slots = (np.arange(len(triangles)) % 2).astype(np.int32)
    padded = np.full((len(positions), 5), np.nan, np.float32)
    padded[:, 1:4] = positions
    yield "plain", positions, triangles, normals, slots
    yield "float64", positions.astype(float), triangles.astype(np.int64), normals.astype(float), slots.astype(np.int64)
    yield "columns first", np.asfortranarray(positions), np.asfortranarray(triangles), np.asfortranarray(normals), slots
    yield "strided", padded[:, 1:4], np.repeat(triangles, 2, axis=0)[::2], np.repeat(normals, 2, axis=2)[:, :, ::2], np.repeat(slots, 3)[::3]
    yield "backwards", positions[::-1][::-1], triangles[::-1][::-1], normals[:, ::-1][:, ::-1], slots[::-1][::-1]
    yield "other integers", positions, triangles.astype(np.uint32), normals, slots.astype(np.int16)
    yield "short indices", positions, triangles.astype(np.uint16), normals, slots.astype(np.uint8)
    yield "big endian", positions.astype(">f4"), triangles.astype(">i4"), normals.astype(">f4"), slots.astype(">i4")
    frozen = positions.copy()
    frozen.flags.writeable = False
    yield "read only", frozen, triangles, normals, slots


@pytest.mark.parametrize("layout", layouts(), ids=lambda layout: layout[0])
def test_every_layout_gives_the_same_picture(layout):
    """Strides, byte orders and types are read by value: bit for bit the same, and copied, not kept."""
    def picture(arrays):
        scene = pn.Scene()
        paints = [scene.add_material("a", (0.5,) * 3), scene.add_material("b", (0.2,) * 3)]
        given = [np.array(a, copy=True) if a.flags.owndata and a.flags.writeable else a for a in arrays]
        scene.add_instance("ball", scene.add_mesh("ball", *given), np.eye(4), paints)
        for a in given:
            if a.flags.writeable and a.flags.owndata:
                a[...] = 0
        scene.add_area_light("key", "RECTANGLE", light_above(), (1, 1), (3, 3, 3))
        look_down(scene, 0.6)
        return render(scene, 12, stop_rule="FIXED", light_samples=16).passes

    plain, other = picture(next(layouts())[1:]), picture(layout[1:])
    assert all((plain[name] == other[name]).all() for name in plain)
    assert plain["Combined"].max() > 0


def test_degenerate_triangles_are_harmless():
    """Points, slivers and repeated indices are never hit; the floor below is lit as if they were not there."""
    positions = np.array([[0, 0, 1], [0, 0, 1], [1, 1, 1], [0.5, 0.5, 1], [-1, -1, 1]], float)
    triangles = np.array([[0, 0, 0], [0, 1, 2], [2, 2, 4], [2, 3, 4]], np.int32)
    pictures = []
    for extra in (False, True):
        scene = pn.Scene()
        grey = scene.add_material("grey", (0.5,) * 3)
        scene.add_instance("floor", scene.add_mesh("floor", *floor()), np.eye(4), [grey])
        if extra:
            scene.add_instance("broken", scene.add_mesh("broken", positions, triangles), np.eye(4), [grey])
        scene.add_area_light("key", "RECTANGLE", light_above(), (1, 1), (3, 3, 3))
        look_down(scene)
        pictures.append(render(scene, 16, stop_rule="FIXED"))
    np.testing.assert_allclose(pictures[1].red, pictures[0].red, rtol=1e-6)
    assert pictures[1].statistics["non_finite_pixels"] == 0


def test_broken_corner_normals_fall_back_to_the_facet():
    """Zero, NaN or infinite normals: flat shading there, no NaN in any pass."""
    flat = None
    for value in (None, 0.0, np.nan, np.inf):
        scene = pn.Scene()
        positions, triangles = floor()
        normals = None if value is None else np.full((2, 3, 3), value, np.float32)
        scene.add_instance("floor", scene.add_mesh("floor", positions, triangles, normals), np.eye(4), [scene.add_material("g", (0.5,) * 3)])
        scene.add_area_light("key", "RECTANGLE", light_above(), (1, 1), (3, 3, 3))
        look_down(scene)
        picture = render(scene, 8, stop_rule="FIXED")
        flat = picture if flat is None else flat
        assert all((picture.passes[name] == flat.passes[name]).all() for name in flat.passes)
