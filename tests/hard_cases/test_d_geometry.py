# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows 37 to 49 that are about geometry: broken, enormous or stacked; a clear error, or a note that counts and names.

Rows 36, 38, 40, 41: test_d_scenes.py; 45, 46: test_d_settings.py; more of 37: test_d_meshes.py; 48 and all that Blender
has a say in: tests/blender/test_hard_cases.py.
"""

import numpy as np
import penumbra_native as pn
import pytest
from methods import ANTIALIASED, BOUNDED, FIXED
from processes import run_code
from scenes import add, box, floor, light_above, lit_floor, look_down, render, scaling, translation

UPRIGHT = np.array([[0, 0, 1], [0.1, 0, 1], [0, 0.1, 1]])


def test_d37_triangles_without_area_are_counted_and_named():
    """Points, repeated indices, needles of no width; the note names the first mesh, the picture is as without them."""
    scene = lit_floor()
    add(scene, "Ärmel", (np.array([[0, 0, 1], [0, 0, 1], [1, 1, 1], [0.5, 0.5, 1]]),
                         np.array([[0, 0, 0], [0, 1, 2], [2, 2, 3], [0, 2, 3]], np.int32)))  # fmt: skip
    add(scene, "cuff", (UPRIGHT, np.array([[0, 0, 1], [0, 1, 2]], np.int32)))
    picture = render(scene, 8, **FIXED)
    assert picture.statistics["warnings"] == ["5 triangles without area were left out: 'Ärmel' and 1 more"]
    assert picture.statistics["triangles"] == 2 + 1
    assert all(np.isfinite(values).all() for values in picture.passes.values())


@pytest.mark.parametrize("shared", [False, True])
def test_d39_singular_instances_are_counted_and_named(shared):
    scene = lit_floor()
    plain = render(lit_floor(), 8, **FIXED).red
    mesh = add(scene, "ball", box([-0.1, -0.1, 0.9], [0.1, 0.1, 1.1]), scaling(0, 1, 1))
    grey = scene.add_material("grey", (0.5,) * 3)
    for matrix in (scaling(1, 0, 1), scaling(0, 0, 0)) if shared else ():
        scene.add_instance("ball", mesh, matrix, [grey])
    picture = render(scene, 8, **FIXED)
    np.testing.assert_allclose(picture.red, plain, rtol=1e-6)
    count = 3 if shared else 1
    text = f"{count} objects whose scale is zero in some direction were left out: 'ball'"
    assert picture.statistics["warnings"] == [text + (" and 2 more" if shared else "")]


@pytest.mark.parametrize("distance", [1e3, 1e5, 1e8, 1e12, 1e30])
def test_c34_a_stray_object_that_makes_the_scene_too_large_is_named(distance):
    """Up to 1e5 m the picture is as without it; what is beyond takes the others' shapes, and says so."""
    scene = lit_floor()
    add(scene, "ball", box([-0.3, -0.3, 0], [0.3, 0.3, 0.6]))
    plain = render(scene, 12, **FIXED).red
    scene = lit_floor()
    add(scene, "ball", box([-0.3, -0.3, 0], [0.3, 0.3, 0.6]))
    add(scene, "stray", box([-0.3, -0.3, 0], [0.3, 0.3, 0.6]), translation(0, distance, 0))
    picture = render(scene, 12, **FIXED)
    notes = picture.statistics["warnings"]
    if distance <= 1e5:
        assert notes == [] and (np.abs(picture.red - plain) > 0.02 * plain.max()).mean() < 0.02
    else:
        (note,) = notes
        assert note.startswith("'stray' reaches so far (") and note.endswith(" m are lost")


def test_d39_negative_determinant():
    """A mirrored box is lit like the plain one: both are symmetric."""

    def picture(matrix):
        scene = lit_floor()
        add(scene, "box", box([-0.3, -0.3, 0], [0.3, 0.3, 0.6]), matrix)
        return render(scene, 12, **BOUNDED)

    plain = picture(np.eye(4))
    for matrix in (scaling(-1, 1, 1), scaling(-1, -1, 1), scaling(1, -1, 1)):
        other = picture(matrix)
        assert np.abs(other.red - plain.red).max() < 0.008
        np.testing.assert_allclose(other.passes["Normal"], plain.passes["Normal"], atol=1e-6)


@pytest.mark.parametrize("rule", [BOUNDED, FIXED, ANTIALIASED])
def test_d42_camera_inside_or_on_a_face(rule):
    """Inside a closed box it sees the box, in the dark; exactly on the floor it sees the floor or past it."""
    scene = lit_floor()
    add(scene, "box", box([-3, -3, 3], [3, 3, 9]))
    scene.set_camera("PERSPECTIVE", translation(0, 0, 5), (-1, 1, -1, 1), (0.01, 100))
    inside = render(scene, 8, **rule)
    assert (inside.passes["Depth"] < 10).all() and (inside.red == 0).all()
    for start in (0.0, 1e-3):
        scene.set_camera("PERSPECTIVE", np.eye(4), (-1, 1, -1, 1), (start, 100))
        picture = render(scene, 8, **rule)
        assert all(np.isfinite(values).all() for values in picture.passes.values())


def test_d41_fields_of_view_near_0_and_180_degrees():
    for half in (1e-6, 1e7):
        scene = lit_floor()
        scene.set_camera("PERSPECTIVE", translation(0, 0, 1.9), (-half, half, -half, half), (0.1, 1000))
        picture = render(scene, 8, **BOUNDED)
        assert all(np.isfinite(values).all() for values in picture.passes.values())
        assert (picture.passes["Depth"] < 2).any() == (half < 1)


def test_d43_65536_materials():
    """One a triangle, the albedo told by the number: all are found again."""
    side = 256
    scene = pn.Scene()
    positions, triangles = floor(2, columns=side)
    numbers = [scene.add_material(f"m{i}", ((i + 0.5) / side**2,) * 3) for i in range(side * side)]
    slots = np.repeat(np.arange(side * side), 2).astype(np.int32)
    scene.add_instance("floor", scene.add_mesh("floor", positions, triangles, None, slots), np.eye(4), numbers)
    scene.add_area_light("key", "RECTANGLE", light_above(1e4), (1, 1), (1e9,) * 3)
    look_down(scene, 2)
    shares = render(scene, side, stop_rule="FIXED", light_samples=1).red
    np.testing.assert_allclose(
        shares / shares[-1, -1], (np.arange(side**2).reshape(side, side) + 0.5) / (side**2 - 0.5), rtol=1e-5
    )


def test_d43_more_than_2_to_the_24_triangles():
    """4097 instances of a mesh of 4096 triangles; the last one is seen."""
    scene = pn.Scene()
    mesh = add(scene, "tile", floor(1e-3, columns=45), translation(9, 9, 0))
    grey = scene.add_material("grey", (0.5,) * 3)
    for i in range(4200):
        scene.add_instance("tile", mesh, translation(-9 + 2.1e-3 * i, 5, 0), [grey])
    scene.add_instance("last", mesh, scaling(1e3, 1e3, 1), [grey])
    scene.add_area_light("key", "RECTANGLE", light_above(), (1, 1), (3, 3, 3))
    look_down(scene, 0.9)
    picture = render(scene, 8, **BOUNDED)
    assert picture.statistics["triangles"] == 4202 * 4050 > 2**24
    np.testing.assert_allclose(picture.red, render(lit_floor(half=0.9), 8, **BOUNDED).red, rtol=1e-5)


def test_d44_more_than_2_to_the_31_indices():
    """An array without strides that claims so many; reading it would take 8 GiB and more. In a process that has not got
    them: an error, as sizes are counted in 64 bits (in 32 a few bytes would do, and the copy would run beyond)."""
    process = run_code("""
        import resource
        import numpy as np
        import penumbra_native as pn
        from scenes import lit_floor, render
        resource.setrlimit(resource.RLIMIT_AS, (3 * 2**30, -1))
        for count in (2**31 // 3 + 1, 2**32 // 3 + 1, 2**32 + 1):
            for triangles in (np.zeros((1, 3), np.int32), np.zeros((1, 3), np.int64)):
                try:
                    pn.Scene().add_mesh("vast", np.zeros((1, 3)), np.broadcast_to(triangles, (count, 3)))
                except (MemoryError, ValueError) as error:
                    print(type(error).__name__, error)
        print(render(lit_floor(), 4).red.min() > 0)
    """)
    assert process.returncode == 0, process.stderr
    assert len(process.stdout.splitlines()) == 7 and process.stdout.endswith("True\n"), process.stdout


def test_d47_names_of_all_kinds():
    for name in ("", " ", "a\nb", "光", "%s %n {}", "x" * 100_000):
        with pytest.raises(ValueError, match="vertex 1 is not finite") as refusal:
            pn.Scene().add_mesh(name, np.array([[0, 0, 0], [0, 0, np.nan], [1, 0, 0.0]]), np.array([[0, 1, 2]]))
        assert str(refusal.value).startswith(name + ": ")


@pytest.mark.parametrize("vertices", ["shared", "own"])
def test_d49_200000_identical_triangles(vertices):
    """Without care 5.9 ms a ray; 64 x 64 pixels x 64 rays would take half an hour. Counted, named, and lit like one."""
    corner = np.array([[-4, -4, 0.5], [8, -4, 0.5], [-4, 8, 0.5]])
    triangles = np.tile(np.arange(3, dtype=np.int32), (200_000, 1))
    if vertices == "own":
        triangles += 3 * np.arange(200_000, dtype=np.int32)[:, None]
    pictures = []
    for shape in ((corner, triangles[:1]), (np.tile(corner, (200_000 if vertices == "own" else 1, 1)), triangles)):
        scene = pn.Scene()
        add(scene, "stack", shape)
        scene.add_area_light("key", "RECTANGLE", light_above(), (1, 1), (3, 3, 3))
        look_down(scene)
        pictures.append(render(scene, 64, stop_rule="FIXED"))
    assert (pictures[0].red == pictures[1].red).all() and pictures[1].red.max() > 0
    assert pictures[1].statistics["warnings"] == ["199999 triangles that are copies of others were left out: 'stack'"]


@pytest.mark.parametrize("rule", [BOUNDED, FIXED, ANTIALIASED])
def test_d39_nearly_singular_instances_of_a_shared_mesh(rule):
    """Embree inverts their matrices in single precision, and aborts the process at what comes out. Found by fuzzing."""
    flat = np.eye(4)
    flat[:3, :3] = [[1, 1, 2], [0.5, 0.5, 1], [0, 1e-9, 1e-9]]
    scene = lit_floor()
    mesh = add(scene, "box", box([-0.3, -0.3, 0], [0.3, 0.3, 0.6]))
    grey = scene.add_material("grey", (0.5,) * 3)
    tiny = [scaling(s, s, s) for s in (1e-13, 1e-14, 1e-16, 1e-20)]
    for matrix in (flat, flat.T.copy(), *tiny):
        matrix[:3, 3], matrix[3] = 0, [0, 0, 0, 1]
        scene.add_instance("crushed", mesh, matrix, [grey])
    for end in (scaling(1, 1, -1), scaling(0.5, -2, 1)):  # is flat in between
        scene.add_instance("mirrored", mesh, np.eye(4), [grey], motion=[np.eye(4), end])
    picture = render(scene, 8, **rule)
    assert all(np.isfinite(values).all() for values in picture.passes.values())
    text = "8 objects whose scale is zero in some direction were left out: 'crushed' and 7 more"
    assert picture.statistics["warnings"] == [text]


@pytest.mark.parametrize("rule", [BOUNDED, FIXED, ANTIALIASED])
@pytest.mark.parametrize("distance", [1e10, 1e18, 5e18, 1e30])
def test_d41_rays_longer_than_embree_takes(distance, rule):
    """A luminaire so far away that it shines straight down, half of it behind a ceiling, and a camera of a window as
    wide: directions beyond 1.8e18 abort the process unless they are shrunk. The shadow ends below the edge."""
    scene = lit_floor(size=(distance / 100,) * 2, light=translation(0, 0, distance), radiance=(3e4,) * 3)
    add(scene, "ceiling", (np.array([[0, -4, 0.5], [4, -4, 0.5], [4, 4, 0.5], [0, 4, 0.5]]),
                           np.array([[0, 1, 2], [0, 2, 3]], np.int32)))  # fmt: skip
    look_down(scene, 2, 0.4)
    picture = render(scene, 8, **rule)
    if distance < 1e30:  # beyond 1e19 the square of the distance is none that float32 holds
        assert (picture.red[:, :2] > 0).all() and (picture.red[:, 6:] == 0).all()
    scene.set_camera("PERSPECTIVE", translation(0, 0, 1), (-distance, distance, -1, 1), (1e-30, 1e30))
    assert all(np.isfinite(values).all() for values in render(scene, 8, **rule).passes.values())


@pytest.mark.parametrize("moves", [False, True])
@pytest.mark.parametrize("scale", [1e-20, 1e-36, 1e-42, 1e-50])
def test_d37_strands_too_small_for_single_precision(scale, moves):
    """Embree aborts the process at curves below 1e-36 of the scene's size. Found by fuzzing. As without them."""
    scene = lit_floor()
    keys = np.array([[0, 0, 1], [0, 0.1, 1], [0, 0.2, 1.1], [0, 0.3, 1]]) * scale
    motion = [keys, 0 * keys] if moves else []
    hair = scene.add_curves("hair", keys, np.full(4, 0.01 * scale), np.array([4], np.int32), "RIBBON", motion=motion)
    scene.add_instance("hair", hair, np.eye(4), [scene.add_material("grey", (0.5,) * 3)])
    picture = render(scene, 8, **FIXED)
    np.testing.assert_allclose(picture.red, render(lit_floor(), 8, **FIXED).red, rtol=1e-5)
