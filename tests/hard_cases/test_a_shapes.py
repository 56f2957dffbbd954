# SPDX-License-Identifier: GPL-3.0-or-later
"""Light without shadows against closed forms: Lambert's polygon and the disk's form factor.

Owen-Sobol' points converge as N^-1.5 on a smooth integrand: a relative standard error of 2e-6 at 4096 points and 64
times that at 256, for luminaires at a distance of about twice their size. Tolerances are five or more standard
errors.
"""

import numpy as np
import oracles
import penumbra_native as pn
import pytest
from scenes import add, floor, light_above, lit_floor, look_down, render, rotation, scaling, translation

UP = (0.0, 0.0, 1.0)
RHO, RADIANCE = 0.5, np.array([3.0, 2.0, 0.5])


def expect(picture, form_factor, tolerance):
    """Combined = albedo x radiance x form factor in every channel; relative."""
    for channel in range(3):
        value = picture.passes["Combined"][..., channel]
        exact = np.broadcast_to(RHO * RADIANCE[channel] * form_factor, value.shape)
        np.testing.assert_allclose(value, exact, rtol=tolerance, atol=1e-14)
    assert (picture.passes["Combined"][..., 3] == 1).all()


@pytest.mark.parametrize("seed", [0, 1])
def test_a01_hundred_floor_points_under_a_square(seed):
    """Relative error below 1e-5 at 100 points with 4096 Owen-Sobol' points each: five standard errors."""
    picture = render(lit_floor(RADIANCE), 10, stop_rule="FIXED", light_samples=4096, seed=seed)
    x, y = picture.position[..., 0], picture.position[..., 1]
    assert picture.position.shape == (10, 10, 3) and np.ptp(x) == pytest.approx(3.6)
    expect(picture, oracles.parallel_rectangle(x, y, 0.5, 2.0), 1e-5)


LIGHTS = {
    "wide": (light_above(), (2.5, 0.2)),
    "turned": (light_above() @ rotation([0, 0, 1], 33), (1.0, 0.5)),
    "tilted": (light_above(2.5) @ rotation([1, 0.5, 0], 50), (1.0, 1.0)),
    "scaled": (light_above() @ scaling(0.5, 2.0, 3.0), (1.0, 1.0)),
    "mirrored": (light_above() @ rotation([0, 1, 0], 20) @ scaling(-1, 1, 1), (1.0, 0.7)),
    "sheared": (light_above() @ np.array([[1, 0.6, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]]), (1.0, 1.0)),
    "tiny": (light_above(), (1e-4, 1e-4)),
    "slim": (light_above(), (1e-4, 1.0)),
}


@pytest.mark.parametrize("name", LIGHTS)
def test_a18_rectangles_under_any_transform(name):
    """1024 points, luminaires up to 1.3 of their distance long: 3e-4."""
    matrix, size = LIGHTS[name]
    picture = render(lit_floor(RADIANCE, size, matrix), 8, stop_rule="FIXED", light_samples=1024)
    corners = oracles.rectangle_corners(matrix, size)
    expect(picture, oracles.lambert_on(corners, picture.position, UP, -matrix[:3, 2]), 3e-4)


@pytest.mark.parametrize(
    "size, matrix", [((1, 1), light_above()), ((1.5, 0.5), LIGHTS["tilted"][0]), ((1, 1), LIGHTS["sheared"][0])]
)
def test_a18_ellipses_under_any_transform(size, matrix):
    """The square is folded onto the disk, which leaves kinks: N^-1.25 or so. 4096 points: 3e-4."""
    picture = render(lit_floor(RADIANCE, size, matrix, "ELLIPSE"), 8, stop_rule="FIXED", light_samples=4096)
    corners = oracles.ellipse_corners(matrix, size, 2048)
    expect(picture, oracles.lambert_on(corners, picture.position, UP, -matrix[:3, 2]), 3e-4)


def test_a18_disk():
    picture = render(lit_floor(RADIANCE, shape="ELLIPSE"), 8, stop_rule="FIXED", light_samples=4096)
    expect(picture, oracles.disk(0.5, 2.0, np.hypot(picture.position[..., 0], picture.position[..., 1])), 3e-4)


def test_a05_a_light_that_straddles_the_horizon():
    """A luminaire standing half below the floor's level; its lower half must count nothing. The horizon cuts the
    integrand with a kink, and points stand as near as its own size: 4096 points, 2e-3."""
    matrix = translation(1.5, 0, 0) @ rotation([0, 1, 0], 90)  # emits towards -x
    scene = lit_floor(RADIANCE, (1, 1), matrix, half=0.5)
    picture = render(scene, 8, stop_rule="FIXED", light_samples=4096)
    expect(
        picture, oracles.lambert_on(oracles.rectangle_corners(matrix, (1, 1)), picture.position, UP, (-1, 0, 0)), 2e-3
    )
    wrong_side = lit_floor(RADIANCE, (1, 1), matrix @ rotation([0, 1, 0], 180), half=0.5)
    assert (render(wrong_side, 8).red == 0).all()


def test_lights_add():
    """Two luminaires are the sum of each alone, per pixel and within both errors; two coincident ones are twice
    one."""
    other = translation(-1, 0.5, 1.5) @ rotation([0, 1, 0], 30)
    scene = lit_floor(RADIANCE)
    scene.add_area_light("fill", "RECTANGLE", other, (0.5, 0.8), tuple(RADIANCE))
    picture = render(scene, 8, stop_rule="FIXED", light_samples=1024)
    first = oracles.parallel_rectangle(picture.position[..., 0], picture.position[..., 1], 0.5, 2.0)
    second = oracles.lambert_on(oracles.rectangle_corners(other, (0.5, 0.8)), picture.position, UP, -other[:3, 2])
    expect(picture, first + second, 3e-4)
    both_face = (first > 0) & (second > 0)
    assert (picture.light_samples[both_face] == 2048).all() and both_face.sum() > 40


def test_c35_extreme_radiance():
    """Powers of two: the same bits, only the exponent moves. Radiance 1e-30 and 1e30 as well (to rounding)."""
    base = render(lit_floor((1, 1, 1)), 8, stop_rule="FIXED", light_samples=64).red
    assert (render(lit_floor((4, 4, 4), albedo=0.25), 8, stop_rule="FIXED", light_samples=64).red == 2 * base).all()
    for radiance in (1e-30, 1e30):
        red = render(lit_floor((radiance,) * 3), 8, stop_rule="FIXED", light_samples=64).red
        np.testing.assert_allclose(red, radiance * base, rtol=1e-6)


@pytest.mark.parametrize("scale", [1e-6, 1e4])
def test_c32_c33_size_of_the_world(scale):
    """Everything scaled alike: the same picture to float rounding of the vertices, 1e-5."""

    def build(s):
        scene = pn.Scene()
        add(scene, "floor", floor(4 * s))
        scene.add_area_light("key", "RECTANGLE", light_above(2 * s), (s, s), (1, 1, 1))
        look_down(scene, 2 * s, 50 * s)
        return render(scene, 8, stop_rule="FIXED", light_samples=64).red

    np.testing.assert_allclose(build(scale), build(1.0), rtol=1e-5)


@pytest.mark.parametrize("exponent", [0.0, 5.0, 60.0])
def test_phong_floor(exponent):
    """Diffuse and Phong lobes together, seen from above: eq. (4) by the midpoint rule, 128 x 128, with the BRDF
    albedo / pi + albedo (n + 2) / (2 pi) cos^n. 4096 points: 1e-3 (the lobe of
    exponent 60 is narrower than the luminaire)."""
    scene, matrix = pn.Scene(), light_above()
    diffuse, phong = np.array([0.5, 0.2, 0.0]), np.array([0.1, 0.4, 1.0])
    paint = scene.add_material("paint", tuple(diffuse), tuple(phong), exponent)
    scene.add_instance("floor", scene.add_mesh("floor", *floor()), np.eye(4), [paint])
    scene.add_area_light("key", "RECTANGLE", matrix, (1, 1), tuple(RADIANCE))
    look_down(scene, 1.0)
    picture = render(scene, 8, stop_rule="FIXED", light_samples=4096)
    g = (np.arange(128) + 0.5) / 128
    points = np.stack(np.meshgrid(g, g), axis=-1).reshape(-1, 2)
    for index in np.ndindex(8, 8):
        f, places = oracles.summands(picture.position[index], np.array(UP), matrix, (1, 1), points)
        to_light = places - picture.position[index]
        cosine = to_light[:, 2] / np.linalg.norm(to_light, axis=1)  # the mirror direction is straight up
        exact = RADIANCE * (diffuse * f.mean() + phong * (f * (exponent + 2) / 2 * cosine**exponent).mean())
        np.testing.assert_allclose(picture.passes["Combined"][index][:3], exact, rtol=1e-3)


def test_a14_no_light_no_ray():
    """No luminaire, one without power, one without area, one behind the floor: black, and not one ray."""
    for light in ({"radiance": (0, 0, 0)}, {"size": (0, 1)}, {"light": translation(0, 0, -1)}):
        picture = render(lit_floor(**light), 8)
        assert (picture.passes["Combined"][..., :3] == 0).all()
        assert picture.statistics["shadow_rays"] == 0
        assert (picture.light_samples == 0).all()
