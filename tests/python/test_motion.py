# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion blur against what a shutter sees: shares of time.

A plate's edge that crosses the picture at even speed is a box filter over its way: the alpha of a pixel is the share of
the shutter's time for which the plate covers its centre. With 1024 samples in one dimension of time, scrambled, that
share is right within a few of their spacing: 0.005 is allowed. The filter is a hundredth of a pixel wide.
"""

import numpy as np
import penumbra_native as pn
import pytest
from scenes import add, box, floor, light_above, look_down, parallelogram, render, rotation, sphere, translation

SAMPLES = {"stop_rule": "FIXED", "light_samples": 1, "pixel_samples": 1024, "filter_type": "BOX", "filter_width": 0.01}
WIDTH = 40
AT = (np.arange(WIDTH) + 0.5) / WIDTH * 4 - 2
"""x of the pixels' centres, as look_down() shows them."""


def empty():
    scene = pn.Scene()
    scene.set_background((0, 0, 0), transparent=True)
    return scene, scene.add_material("grey", (0.5, 0.5, 0.5))


def plate():
    """Covers x < 0."""
    return parallelogram([-50, -50, 0], [50, 0, 0], [0, 100, 0])


def alpha(scene, **settings):
    return render(scene, WIDTH, 1, **(SAMPLES | settings)).passes["Combined"][0, :, 3]


def covered(edge, shutter=None):
    """The share of the time for which x < edge(time); `shutter`: how far it is open at a time."""
    times = (np.arange(20000) + 0.5) / 20000
    weight = np.ones_like(times) if shutter is None else shutter(times)
    return np.array([(weight * (x < edge(times))).sum() / weight.sum() for x in AT])


@pytest.mark.parametrize("count", [1, 2], ids=["used once", "shared"])
def test_a_moving_edge_is_a_box_filter(count):
    scene, grey = empty()
    mesh = scene.add_mesh("plate", *plate())
    still = translation(-0.2, 0, 0)
    for i in range(count):
        way = [translation(x, 0, -0.1 * i) for x in (-1.2, 0.8)]
        scene.add_instance(f"plate {i}", mesh, still, [grey], motion=way)
    look_down(scene)
    np.testing.assert_allclose(alpha(scene), covered(lambda t: -1.2 + 2 * t), atol=0.005)


def test_several_steps_have_several_speeds():
    scene, grey = empty()
    places = [-1.5, -1.3, 0.5, 0.6]
    scene.add_instance("plate", scene.add_mesh("plate", *plate()), translation(0, 0, 0), [grey],
                       motion=[translation(x, 0, 0) for x in places])  # fmt: skip
    look_down(scene)
    expected = covered(lambda t: np.interp(t, np.linspace(0, 1, 4), places))
    np.testing.assert_allclose(alpha(scene), expected, atol=0.005)


def test_vertices_move():
    scene, grey = empty()
    positions, triangles = plate()
    way = [positions + [x, 0, 0] for x in (-1.0, 0.2, 0.9)]
    scene.add_instance("plate", scene.add_mesh("plate", positions, triangles, position_motion=way), np.eye(4), [grey])
    look_down(scene)
    expected = covered(lambda t: np.interp(t, [0, 0.5, 1], [-1.0, 0.2, 0.9]))
    np.testing.assert_allclose(alpha(scene), expected, atol=0.005)


def test_vertices_and_object_move_together():
    """Object and vertices move against each other: the edge stands still."""
    scene, grey = empty()
    positions, triangles = plate()
    mesh = scene.add_mesh("plate", positions, triangles, position_motion=[positions, positions + [1.5, 0, 0]])
    scene.add_instance("plate", mesh, translation(-0.75, 0, 0), [grey],
                       motion=[translation(0, 0, 0), translation(-1.5, 0, 0)])  # fmt: skip
    look_down(scene)
    np.testing.assert_array_equal(alpha(scene), AT < 0)


def test_the_camera_moves():
    scene, grey = empty()
    scene.add_instance("plate", scene.add_mesh("plate", *plate()), np.eye(4), [grey])
    window = (-2.0, 2.0, -2.0, 2.0)
    scene.set_camera("ORTHOGRAPHIC", translation(0, 0, 5), window, (0.1, 10),
                     motion=[translation(1.2, 0, 5), translation(-0.8, 0, 5)], window_motion=[window] * 2)  # fmt: skip
    np.testing.assert_allclose(alpha(scene), covered(lambda t: -1.2 + 2 * t), atol=0.005)


def test_the_window_moves():
    """A zoom: pixel centres at AT show x AT (1 + t)."""
    scene, grey = empty()
    scene.add_instance("plate", scene.add_mesh("plate", *plate()), translation(1, 0, 0), [grey])
    windows = [(-2.0 * s, 2.0 * s, -2.0, 2.0) for s in (1, 2)]
    scene.set_camera("ORTHOGRAPHIC", translation(0, 0, 5), windows[0], (0.1, 10),
                     motion=[translation(0, 0, 5)] * 2, window_motion=windows)  # fmt: skip
    np.testing.assert_allclose(alpha(scene), covered(lambda t: 1 / (1 + t)), atol=0.005)


def test_the_shutter_opens_slowly():
    scene, grey = empty()
    scene.add_instance("plate", scene.add_mesh("plate", *plate()), np.eye(4), [grey],
                       motion=[translation(-1.5, 0, 0), translation(1.5, 0, 0)])  # fmt: skip
    look_down(scene)
    pose, window = translation(0, 0, 50), (-2.0, 2.0, -2.0, 2.0)
    shares = (np.arange(64) + 0.5) / 64
    scene.set_camera("ORTHOGRAPHIC", pose, window, (0.1, 100), shutter=list(shares))
    np.testing.assert_allclose(alpha(scene), covered(lambda t: 3 * t - 1.5, lambda t: t), atol=0.008)


def test_turning_goes_round():
    """A spot 1.5 from the axis turns by 120 degrees between two times. It is on its circle at all times: what is seen
    lies within its own half width of it, whereas a straight way would go through a radius of 0.75."""
    scene, grey = empty()
    spot = scene.add_mesh("spot", *box([1.45, -0.05, 0], [1.55, 0.05, 0.1]))
    scene.add_instance("spot", spot, np.eye(4), [grey], motion=[rotation([0, 0, 1], a) for a in (-60, 60)])
    look_down(scene)
    seen = render(scene, 64, **(SAMPLES | {"pixel_samples": 256})).passes["Combined"][..., 3]
    x = (np.arange(64) + 0.5) / 64 * 4 - 2
    radius, angle = np.hypot(*np.meshgrid(x, x)), np.degrees(np.arctan2(*np.meshgrid(x, x)[::-1]))
    assert radius[seen > 0].min() > 1.44
    assert radius[seen > 0].max() < 1.57
    assert angle[seen > 0].min() < -58
    assert angle[seen > 0].max() > 58
    on_circle = seen[(np.abs(radius - 1.5) < 0.02) & (np.abs(angle) < 50)]
    # Each of its places is covered for 0.1 m of its way of 1.5 x 120 degrees.
    np.testing.assert_allclose(on_circle.mean(), 0.1 / (1.5 * np.radians(120)), rtol=0.1)


def test_shadows_move_with_the_object():
    """A plate between a small light and the floor crosses: the floor is lit for the share of time it is not hidden."""
    scene = pn.Scene()
    add(scene, "floor", floor())
    scene.add_point_light("bulb", translation(0, 0, 4), 0.0, (50, 50, 50))
    grey = scene.add_material("grey", (0.5, 0.5, 0.5))
    scene.add_instance("plate", scene.add_mesh("plate", *plate()), translation(0, 0, 3), [grey], rays=pn.SHADOW_RAY,
                       motion=[translation(x, 0, 3) for x in (-0.3, 0.2)])  # fmt: skip
    look_down(scene)
    shadowed = render(scene, WIDTH, 1, **SAMPLES).red[0]
    open_scene = pn.Scene()
    add(open_scene, "floor", floor())
    open_scene.add_point_light("bulb", translation(0, 0, 4), 0.0, (50, 50, 50))
    look_down(open_scene)
    share = shadowed / render(open_scene, WIDTH, 1, **SAMPLES).red[0]
    np.testing.assert_allclose(share, 1 - covered(lambda t: 4 * (-0.3 + 0.5 * t)), atol=0.005)


def moving_scene(moves=True):
    scene = pn.Scene()
    add(scene, "floor", floor(half=20))
    positions, triangles = sphere([0, 0, 0], 0.4, 16)
    ball = scene.add_mesh("ball", positions, triangles)
    grey = scene.add_material("grey", (0.5, 0.5, 0.5))
    way = [translation(-0.6, 0.2, 0.5), translation(0.6, 0, 0.7)] if moves else []
    scene.add_instance("ball", ball, translation(0, 0.1, 0.6), [grey], motion=way)
    scene.add_instance("other", ball, translation(0.9, -0.6, 0.4), [grey])
    scene.add_area_light("key", "RECTANGLE", light_above(z=4, x=1), (1, 1), (20, 20, 20))
    view = translation(0, -4.5, 2.5) @ rotation([1, 0, 0], 65)
    scene.set_camera("PERSPECTIVE", view, (-0.4, 0.4, -0.3, 0.3), (0.01, 100))
    return scene


@pytest.mark.parametrize("rule", ["FIXED", "BOUNDED"])
def test_same_picture_for_any_threads_and_borders(rule):
    settings = {"stop_rule": rule, "pixel_samples": 4, "light_samples": 4}
    whole = render(moving_scene(), 40, 30, threads=1, **settings)
    assert np.array_equal(whole.red, render(moving_scene(), 40, 30, threads=2, **settings).red)
    left = render(moving_scene(), 40, 30, region=(0, 0, 17, 30), **settings)
    right = render(moving_scene(), 40, 30, region=(17, 0, 23, 30), **settings)
    for name, values in whole.passes.items():
        assert np.array_equal(values, np.concatenate([left.passes[name], right.passes[name]], axis=1)), name


def test_one_ray_a_pixel_sees_the_centre_of_the_shutter():
    """Within the rounding of transforms halfway between two."""
    moving, still = (render(moving_scene(m), 40, 30, stop_rule="FIXED", pixel_samples=1) for m in (True, False))
    np.testing.assert_allclose(moving.red, still.red, atol=1e-3)


def test_bad_motion_is_refused():
    scene, grey = empty()
    positions, triangles = plate()
    with pytest.raises(ValueError, match="plate: motion must be told at 2 to 129 times"):
        scene.add_mesh("plate", positions, triangles, position_motion=[positions])
    with pytest.raises(ValueError, match="plate: the motion has another number of vertices"):
        scene.add_mesh("plate", positions, triangles, position_motion=[positions, positions[:-1]])
    with pytest.raises(ValueError, match="plate: a vertex of the motion is not finite"):
        scene.add_mesh("plate", positions, triangles, position_motion=[positions, positions * np.nan])
    mesh = scene.add_mesh("plate", positions, triangles)
    with pytest.raises(ValueError, match="plate: the transform is not finite at some time"):
        scene.add_instance("plate", mesh, np.eye(4), [grey], motion=[np.eye(4), translation(np.inf, 0, 0)])
    with pytest.raises(ValueError, match="camera: the shutter never opens"):
        scene.set_camera("PERSPECTIVE", np.eye(4), (-1, 1, -1, 1), (0.1, 10), shutter=[0.0, 0.0])
