# SPDX-License-Identifier: GPL-3.0-or-later
"""Kept meshes: found again by their content, freed with their last user, built once, and the same picture."""

import time

import numpy as np
import penumbra_native as pn
import pytest
from scenes import box, floor, light_above, look_down, parallelogram, render, rotation, scaling, sphere, translation

FIXED = {"stop_rule": "FIXED", "light_samples": 64}
PLACES = [translation(-0.5, 0, 0.6) @ rotation([1, 2, 0], 35), translation(0.5, 0.1, 0.5) @ scaling(0.7, 0.7, -0.4)]


def shapes():
    """name -> arguments of add_mesh after the name, of meshes of all kinds: flat, smooth, with slots and attributes."""
    positions, triangles = sphere([0.05, 0, 0], 0.3, 12)
    normals = ((positions - [0.05, 0, 0]) / 0.3)[triangles].astype(np.float32)
    slots = np.arange(len(triangles), dtype=np.int32) % 2
    attribute = np.ones((len(triangles), 3, 4), np.float32)
    ball = positions, triangles, normals, slots, {3: attribute}
    return {"floor": floor(), "ball": ball, "box": box([-0.3] * 3, [0.3] * 3)}


def light(scene):
    scene.add_area_light("key", "RECTANGLE", light_above(2.5) @ rotation([1, 0, 0], 20), (1, 1), (3, 3, 3))
    look_down(scene, 1.5)


def make(store=None, places=PLACES):
    """A floor, a ball and a box; kept in a store if there is one."""
    scene = pn.Scene()
    materials = [scene.add_material("grey", (0.8, 0.8, 0.8)), scene.add_material("red", (0.8, 0.1, 0.1))]
    for (name, arrays), place in zip(shapes().items(), [np.eye(4), *places], strict=True):
        number = scene.add_kept_mesh(name, store.keep(name, *arrays)) if store else scene.add_mesh(name, *arrays)
        scene.add_instance(name, number, place, materials)
    light(scene)
    return scene


def test_a_mesh_is_found_again_by_its_content():
    store = pn.MeshStore()
    arrays = shapes()["ball"]
    kept = store.keep("ball", *arrays)
    assert store.keep("another name", *[np.copy(a) if isinstance(a, np.ndarray) else a for a in arrays]) is kept
    for which in range(4):
        changed = list(arrays)
        changed[which] = np.copy(changed[which])
        changed[which].ravel()[-1] += 1 if which != 1 else -1
        assert store.keep("changed", *changed) is not kept
    assert store.keep("attribute", *arrays[:4], {3: arrays[4][3] * 2}) is not kept
    assert store.keep("attribute's name", *arrays[:4], {4: arrays[4][3]}) is not kept


def test_a_mesh_goes_with_its_last_user():
    """A kept mesh has the name that it was first kept under; a new name is a new mesh."""
    store = pn.MeshStore()
    kept = store.keep("first", *floor())
    assert store.keep("second", *floor()).name == "first"
    scene = pn.Scene()
    scene.add_kept_mesh("floor", kept)
    del kept
    assert store.keep("third", *floor()).name == "first"
    del scene
    assert store.keep("fourth", *floor()).name == "fourth"


def test_the_picture_is_that_of_the_same_triangles():
    """Within rounding but at silhouettes: kept meshes are traced in a space of their own."""
    plain, kept = render(make(), 48, **FIXED), render(make(pn.MeshStore()), 48, **FIXED)
    off = abs(plain.passes["Combined"] - kept.passes["Combined"]).max(axis=-1)
    assert plain.red.max() > 0.1
    assert np.mean(off > 1e-5 * plain.red.max()) < 0.01
    assert plain.statistics["triangles"] == kept.statistics["triangles"]


def test_a_picture_does_not_depend_on_what_was_kept_before():
    """Moved, back, and from a new store: bit for bit."""
    store = pn.MeshStore()
    first = render(make(store), 32, **FIXED)
    moved = render(make(store, PLACES[::-1]), 32, **FIXED)
    again, fresh = render(make(store), 32, **FIXED), render(make(pn.MeshStore()), 32, **FIXED)
    assert abs(first.red - moved.red).max() > 0.1
    for picture in (again, fresh):
        for name, values in first.passes.items():
            np.testing.assert_array_equal(values, picture.passes[name])
        assert picture.statistics["scene_hash"] == first.statistics["scene_hash"]


def test_a_kept_mesh_is_built_once():
    """180,000 triangles; CPU time. Moving it builds a structure of two instances, which is next to nothing."""
    store, builds = pn.MeshStore(), []
    grid = parallelogram([-1, -1, 0], [2, 0, 0], [0, 2, 0], 300, 300)
    kept = store.keep("grid", *grid)
    for height in (0.0, 0.5):
        scene = pn.Scene()
        grey = scene.add_material("grey", (0.8, 0.8, 0.8))
        number = scene.add_kept_mesh("grid", kept)
        scene.add_instance("grid", number, translation(0, 0, height), [grey])
        scene.add_instance("other", number, translation(0, 0, height + 2), [grey])
        light(scene)
        start = time.process_time()
        pn.Render(scene, {"width": 8, "height": 8})
        builds.append(time.process_time() - start)
    assert builds[1] < builds[0] / 5


def test_transparency_is_built_in_where_it_is_needed():
    """The same kept mesh, opaque in one scene and half transparent in the next, over a floor below it: an opaque sheet
    hides all of the light, the other half of it; and the first scene still renders as before."""
    store = pn.MeshStore()
    sheet = store.keep("sheet", *parallelogram([-3, -3, 0], [6, 0, 0], [0, 6, 0]))
    ground = store.keep("ground", *floor())

    def scene_with(transparency):
        scene = pn.Scene()
        grey = scene.add_material("grey", (0.8, 0.8, 0.8))
        above = grey if transparency is None else transparency(scene)
        scene.add_instance("ground", scene.add_kept_mesh("ground", ground), np.eye(4), [grey])
        if above is not None:
            scene.add_instance("sheet", scene.add_kept_mesh("sheet", sheet), translation(0, 0, 1.8), [above])
        light(scene)
        look_down(scene, 1.5, z=1.0)  # from below the sheet
        return scene

    def half_transparent(scene):
        return scene.add_program(
            "half",
            registers=np.array([[0, 0, 0], [0.5, 0.5, 0.5]], np.float32),
            tables=np.zeros(0, np.float32),
            operations=[],
            closures=[("transparent", 1, 0, 0, 0)],
        )

    pictures = [render(scene_with(kind), 16, **FIXED).red for kind in (lambda s: None, None, half_transparent, None)]
    open_floor, opaque, half, opaque_again = pictures
    assert opaque.max() == 0 and open_floor.max() > 0.1
    np.testing.assert_allclose(half, open_floor / 2, rtol=0.02)
    np.testing.assert_array_equal(opaque, opaque_again)


def test_errors_name_the_mesh():
    store = pn.MeshStore()
    with pytest.raises(ValueError, match="broken: vertex 0 is not finite"):
        store.keep("broken", np.full((3, 3), np.nan), np.array([[0, 1, 2]]))
    with pytest.raises(ValueError, match=r"broken: triangle 0 names vertex 7"):
        store.keep("broken", np.zeros((3, 3)), np.array([[0, 1, 7]]))
    with pytest.raises(TypeError):
        pn.Scene().add_kept_mesh("none", None)


def test_the_memory_limit_is_told_and_a_higher_one_helps():
    store = pn.MeshStore()
    kept = store.keep("grid", *parallelogram([-1, -1, 0], [2, 0, 0], [0, 2, 0], 300, 300))

    def scene():
        result = pn.Scene()
        grey = result.add_material("grey", (0.8, 0.8, 0.8))
        result.add_instance("grid", result.add_kept_mesh("grid", kept), np.eye(4), [grey])
        light(result)
        return result

    with pytest.raises(MemoryError, match="memory_limit of 2 MiB reached"):
        pn.Render(scene(), {"width": 8, "height": 8, "memory_limit": 2})
    assert render(scene(), 8, **FIXED).red.max() > 0.1
