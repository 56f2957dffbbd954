# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays and numbers that do not fit: refused with the argument's name, what is expected and what was given.

Layouts that do fit, of any strides and types: test_d_meshes.py. Any arrays at all: tests/fuzz.
"""

import numpy as np
import penumbra_native as pn
import pytest
from scenes import floor, lit_floor

P, T = np.zeros((3, 3), np.float32), np.array([[0, 1, 2]], np.int32)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((P.T[:2].T, T), "positions has shape (3, 2), expected (any, 3)"),
        ((P[None], T), "positions has shape (1, 3, 3), expected (any, 3)"),
        ((np.array(1.0), T), "positions has shape (), expected (any, 3)"),
        ((P.astype(int), T), "positions has type int64, expected a floating point type"),
        ((P.astype(object), T), "positions has type object, expected a floating point type"),
        ((P.astype("S4"), T), "positions has type |S4, expected a floating point type"),
        ((P, T.astype(np.float32)), "triangles has type float32, expected an integer type"),
        ((P, T[:, :2]), "triangles has shape (1, 2), expected (any, 3)"),
        ((P, T + 1), "triangle 0 names vertex 3, but there are 3"),
        ((P, T, np.zeros((1, 3), np.float32)), "corner_normals has shape (1, 3), expected (1, 3, 3)"),
        ((P, T, np.zeros((1, 3, 3), int)), "corner_normals has type int64, expected a floating point type"),
        ((P, T, None, np.zeros(2, int)), "material_slots has shape (2,), expected (1,)"),
        ((P, T, None, np.zeros(1)), "material_slots has type float64, expected an integer type"),
    ],
)
def test_mesh_arrays(arguments, message):
    with pytest.raises(ValueError) as refusal:
        pn.Scene().add_mesh("Stuhl", *arguments)
    assert str(refusal.value) == "Stuhl: " + message


@pytest.mark.parametrize(
    ("method", "arguments"),
    [("add_mesh", (P, T)), ("add_points", (P, np.ones(3, np.float32))), ("add_material", ((0.5,) * 3,))],
)
@pytest.mark.parametrize("name", ["\0", "Stuhl\0", b"\0"])
def test_names_with_a_zero_character(method, arguments, name):
    """A message that begins with such a name would end there, empty."""
    with pytest.raises(ValueError, match="name: a zero character"):
        getattr(pn.Scene(), method)(name, *arguments)


def program(operations, tables=(), closures=(("diffuse", 2, 0, 0, 0),), registers=4):
    """A program that varies: its first operation reads the position."""
    scene = pn.Scene()
    zeros, numbers = np.zeros((registers, 3), np.float32), np.array(tables, np.float32)
    return scene.add_program("Lack", zeros, [("position", 1, [], 0, 0), *operations], numbers, closures)


RAMP, CURVES = [2, 0, *range(8)], [2, 0, 1, 0, *range(6)]


@pytest.mark.parametrize(
    ("operation", "tables", "data"),
    [
        ("image", [], 0),
        ("image", [], -1),
        ("ramp", RAMP[:-1], 0),
        ("ramp", RAMP, 1),
        ("ramp", RAMP, 2**31 - 1),
        ("ramp", [np.nan, *RAMP[1:]], 0),
        ("ramp", [1e9, *RAMP[1:]], 0),
        ("ramp", [0, *RAMP[1:]], 0),
        ("curves", CURVES[:-1], 0),
        ("curves", [1, *CURVES[1:]], 0),
        ("curves", CURVES, -(2**31)),
        ("transform.point", range(11), 0),
        ("transform.direction", range(12), 1),
    ],
)
def test_programs_read_no_further_than_their_tables_and_images(operation, tables, data):
    """Each crashed the process before; whole tables are taken."""
    with pytest.raises(ValueError, match=f"^Lack: operation '{operation}' reads beyond the tables or images: {data}$"):
        program([(operation, 2, [1, 1], 0, data)], tables)
    assert program([("ramp", 2, [1], 0, 0)], RAMP) == 0
    assert program([("curves", 2, [1, 1], 0, 0)], CURVES) == 0
    assert program([("transform.point", 2, [1], 0, 0)], range(12)) == 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([("no such", 2, [1], 0, 0)],), "there is no operation 'no such'"),
        (([("gamma", 3, [1], 0, 0)],), "there is no register 4"),
        (([("gamma", -1, [1], 0, 0)],), "there is no register -1"),
        (([("gamma", 2, [1, 4], 0, 0)],), "there is no register 4"),
        (([("gamma", 2, [1], 3, 0)],), "operation 'gamma' has impossible inputs"),
        (([("gamma", 2, [1] * 9, 0, 0)],), "operation 'gamma' has impossible inputs"),
        (([], [], [("diffuse", 4, 0, 0, 0)]), "there is no register 4"),
        (([], [], [("velvet", 1, 0, 0, 0)]), "there is no closure 'velvet'"),
        (([], [], [], 65537), "too many nodes for one material"),
    ],
)
def test_programs(arguments, message):
    with pytest.raises(ValueError) as refusal:
        program(*arguments)
    assert str(refusal.value) == "Lack: " + message


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"error_tolerance": -1.0}, "error_tolerance must be positive and finite, not -1"),
        ({"filter_width": 11}, "filter_width must lie in 0 ... 10 pixels, not 11"),
        ({"mirror_depth": 2000}, "mirror_depth must be at most 1024, not 2000"),
        ({"check_interval": 0}, "check_interval must lie in 1 ... 16777216, not 0"),
        ({"light_samples": 0}, "light_samples must lie in 1 ... 16777216, not 0"),
        ({"sampler": "FAURE"}, "sampler is 'FAURE', expected one of PRS, SPRS, SOBOL, HALTON, OWEN_SOBOL"),
        ({"seed": "x"}, "seed is 'x', which is out of range or of the wrong type"),
        ({"memory_limit": -1}, "memory_limit is -1, which is out of range or of the wrong type"),
        ({"stop_rule": b"\x80"}, r"stop_rule is b'\x80', which is out of range or of the wrong type"),
        ({"passes": [b"\x80"]}, r"passes is [b'\x80'], which is out of range or of the wrong type"),
        ({"checkpoint": 7}, "checkpoint is 7, which is out of range or of the wrong type"),
    ],
)
def test_settings(settings, message):
    with pytest.raises(ValueError) as refusal:
        pn.Render(lit_floor(), {"width": 4, "height": 4, "stop_rule": "FIXED", **settings})
    assert str(refusal.value) == message


@pytest.mark.parametrize(
    ("method", "arguments", "word"),
    [
        ("add_mesh", ("m", *floor(), None, None, 7), "material_slots"),
        ("add_mesh", (3, *floor()), "name: str"),
        ("add_area_light", ("l", "RECTANGLE", np.eye(4), (1,), (1, 1, 1)), "size"),
        ("add_instance", ("i", -1, np.eye(4), [0]), "mesh: (int|typing.SupportsInt)"),  # pybind11 2 and 3
        ("set_background", ((1, 2),), "color"),
    ],
)
def test_python_types(method, arguments, word):
    """pybind11's own refusals tell every argument's name and type, and what was given."""
    with pytest.raises(TypeError, match="(?s)" + word + ".*Invoked with"):
        getattr(pn.Scene(), method)(*arguments)
