# SPDX-License-Identifier: GPL-3.0-or-later
"""What a scene refuses, always with the object's name in the message."""

import numpy as np
import penumbra_native as pn
import pytest
from scenes import floor, light_above, look_down, render

NAME = "Würfel 'ß'\n√2"
POSITIONS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
TRIANGLES = np.array([[0, 1, 2]], np.int32)


def with_value(array, value, index=(1, 2)):
    changed = np.array(array, float)
    changed[index] = value
    return changed


@pytest.mark.parametrize(
    "positions, triangles, words",
    [
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
    ],
)
def test_d36_d38_meshes(positions, triangles, words):
    with pytest.raises(ValueError, match=words) as refusal:
        pn.Scene().add_mesh(NAME, positions, triangles)
    assert str(refusal.value).startswith(NAME + ": ")


@pytest.mark.parametrize(
    "arguments, words",
    [
        ({"corner_normals": np.zeros((1, 3), np.float32)}, "corner_normals has shape"),
        ({"corner_normals": np.zeros((2, 3, 3), np.float32)}, "corner_normals has shape"),
        ({"corner_normals": np.zeros((1, 3, 3), np.int32)}, "corner_normals has type"),
        ({"material_slots": np.zeros(2, np.int32)}, "material_slots has shape"),
        ({"material_slots": np.zeros(1)}, "material_slots has type"),
    ],
)
def test_mesh_attributes(arguments, words):
    with pytest.raises(ValueError, match=words) as refusal:
        pn.Scene().add_mesh(NAME, POSITIONS, TRIANGLES, **arguments)
    assert NAME in str(refusal.value)


@pytest.mark.parametrize(
    "material",
    [
        {"diffuse": (1.1, 0, 0)},
        {"diffuse": (-0.1, 0, 0)},
        {"diffuse": (np.nan, 0, 0)},
        {"diffuse": (0.5,) * 3, "phong": (0.6, 0, 0)},
        {"diffuse": (0.4,) * 3, "phong": (0.4,) * 3, "mirror": (0, 0, 0.3)},
        {"diffuse": (0,) * 3, "phong_exponent": -1.0},
        {"diffuse": (0,) * 3, "phong_exponent": np.nan},
        {"diffuse": (0,) * 3, "phong_exponent": np.inf},
        {"diffuse": (0,) * 3, "mirror": (np.inf, 0, 0)},
        {"diffuse": (0,) * 3, "phong": (0, np.nan, 0)},
    ],
)
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
def test_d39_d41_transforms(words, matrix):
    scene = pn.Scene()
    mesh, grey = scene.add_mesh("m", POSITIONS, TRIANGLES), scene.add_material("grey", (0.5,) * 3)
    for call in (
        lambda: scene.add_instance(NAME, mesh, matrix, [grey]),
        lambda: scene.add_area_light(NAME, "RECTANGLE", matrix, (1, 1), (1, 1, 1)),
    ):
        with pytest.raises(ValueError, match=words) as refusal:
            call()
        assert NAME in str(refusal.value)
    with pytest.raises(ValueError, match="camera"):
        scene.set_camera("PERSPECTIVE", matrix, (-1, 1, -1, 1), (0.1, 10))


def test_instances():
    scene = pn.Scene()
    mesh, grey = scene.add_mesh("m", POSITIONS, TRIANGLES), scene.add_material("grey", (0.5,) * 3)
    for arguments, words in (
        ((7, np.eye(4), [grey]), "no mesh"),
        ((mesh, np.eye(4), []), "no material"),
        ((mesh, np.eye(4), [grey, 9]), "no material with number 9"),
    ):
        with pytest.raises(ValueError, match=words) as refusal:
            scene.add_instance(NAME, *arguments)
        assert NAME in str(refusal.value)


@pytest.mark.parametrize(
    "arguments",
    [
        ("CIRCLE", (1, 1), (1, 1, 1)),
        ("RECTANGLE", (-1, 1), (1, 1, 1)),
        ("RECTANGLE", (np.nan, 1), (1, 1, 1)),
        ("ELLIPSE", (1, np.inf), (1, 1, 1)),
        ("RECTANGLE", (1, 1), (np.nan, 0, 0)),
        ("RECTANGLE", (1, 1), (0, np.inf, 0)),
    ],
)
def test_a17_lights(arguments):
    shape, size, radiance = arguments
    with pytest.raises(ValueError) as refusal:
        pn.Scene().add_area_light(NAME, shape, np.eye(4), size, radiance)
    assert NAME in str(refusal.value)


@pytest.mark.parametrize(
    "kind, window, clip",
    [
        ("FISHEYE", (-1, 1, -1, 1), (0.1, 10)),
        ("PERSPECTIVE", (1, 1, -1, 1), (0.1, 10)),
        ("PERSPECTIVE", (-1, 1, 2, 2), (0.1, 10)),
        ("PERSPECTIVE", (-np.inf, 1, -1, 1), (0.1, 10)),
        ("PERSPECTIVE", (-1, np.nan, -1, 1), (0.1, 10)),
        ("ORTHOGRAPHIC", (-1, 1, -1, 1), (10, 0.1)),
        ("ORTHOGRAPHIC", (-1, 1, -1, 1), (np.nan, 1)),
        ("ORTHOGRAPHIC", (-1, 1, -1, 1), (0, np.nan)),
        ("ORTHOGRAPHIC", (-1, 1, -1, 1), (1, 1)),
    ],
)
def test_d41_cameras(kind, window, clip):
    with pytest.raises(ValueError, match="camera"):
        pn.Scene().set_camera(kind, np.eye(4), window, clip)


def test_d40_missing_camera_and_background():
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
    for call in (
        lambda: scene.add_mesh(NAME, POSITIONS, TRIANGLES),
        lambda: scene.add_instance(NAME, mesh, np.eye(4), [grey]),
    ):
        with pytest.raises(ValueError, match="rendered already") as refusal:
            call()
        assert NAME in str(refusal.value)
    scene.add_area_light("key", "RECTANGLE", light_above(), (1, 1), (1, 1, 1))
    assert (render(scene, 4).red > 0).all()
