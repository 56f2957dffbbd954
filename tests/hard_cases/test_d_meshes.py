# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes as they come: any array layout gives the same picture, and broken triangles or normals do no harm."""

import numpy as np
import penumbra_native as pn
import pytest
from scenes import floor, light_above, look_down, render, sphere


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
    yield (
        "strided",
        padded[:, 1:4],
        np.repeat(triangles, 2, axis=0)[::2],
        np.repeat(normals, 2, axis=2)[:, :, ::2],
        np.repeat(slots, 3)[::3],
    )
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


def test_d37_degenerate_triangles_are_harmless():
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
        scene.add_instance(
            "floor",
            scene.add_mesh("floor", positions, triangles, normals),
            np.eye(4),
            [scene.add_material("g", (0.5,) * 3)],
        )
        scene.add_area_light("key", "RECTANGLE", light_above(), (1, 1), (3, 3, 3))
        look_down(scene)
        picture = render(scene, 8, stop_rule="FIXED")
        flat = picture if flat is None else flat
        assert all((picture.passes[name] == flat.passes[name]).all() for name in flat.passes)
