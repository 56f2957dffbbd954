# SPDX-License-Identifier: GPL-3.0-or-later
"""Light with shadows: symmetry, Lambert's formula on clipped luminaires, and brute force over all triangles."""

import numpy as np
import oracles
import penumbra_native as pn
import pytest
from scenes import add, apply, box, floor, light_above, lit_floor, look_down, parallelogram, render, rotation, sphere

UP = np.array([0.0, 0.0, 1.0])
HEIGHT, SIZE, RADIANCE, RHO = 2.0, (1.0, 1.0), 3.0, 0.5


def blocked_floor(*blockers, half=2.0, light=None, cast_shadow=True):
    scene = pn.Scene()
    add(scene, "floor", floor(), albedo=RHO)
    for index, (shape, matrix) in enumerate(blockers):
        add(scene, f"blocker {index}", shape, matrix)
    scene.add_area_light(
        "key", "RECTANGLE", light_above(HEIGHT) if light is None else light, SIZE, (RADIANCE,) * 3, cast_shadow
    )
    # From below the blockers, which start at height 0.5 here: the camera's plane is at 0.4.
    look_down(scene, half, 0.4)
    return scene


def test_b21_half_covered_light_gives_half():
    """A half plane whose edge lies exactly over x = 0, under the middle of the luminaire: points of the floor at x
    = 0 see the half with x < 0. Pixels whose centre is at x = 0 need an odd width. An edge along the luminaire's
    axis is one Owen-Sobol' points resolve to 1/N of the points: 1e-3 with 4096."""
    scene = blocked_floor((parallelogram([0, -4, 1], [4, 0, 0], [0, 8, 0]), None))
    picture = render(scene, 9, 9, stop_rule="FIXED", light_samples=4096)
    middle = picture.red[:, 4]
    assert np.abs(picture.position[:, 4, 0]).max() < 1e-6
    y = picture.position[:, 4, 1]
    np.testing.assert_allclose(middle, RHO * RADIANCE * oracles.parallel_rectangle(0.0, y, 0.5, HEIGHT) / 2, rtol=1e-3)


def visible_through(point, edges, height, light):
    """The part of a luminaire that a point sees past vertical planes through horizontal edges, each (point on the
    edge, horizontal normal towards the open side): clipped by planes through the shading point and the edge."""
    planes = []
    for on_edge, open_side in edges:
        along = np.cross(UP, open_side)
        normal = np.cross(along, np.asarray(on_edge, float) - point)
        planes.append((point, normal if normal @ np.asarray(open_side) > 0 else -normal))
    return oracles.cut_by_shadow(light, planes)


@pytest.mark.parametrize("turn", [0, 30])
def test_b22_slit(turn):
    """A slit 0.25 wide, turned, in a plate half way up: Lambert's formula on what is left of the luminaire. Two
    edges cut the points: a standard error of 0.35 N^-0.75, 7e-4 of the unshadowed value with 4096 points; seven of
    them."""
    matrix = rotation(UP, turn)
    left = parallelogram([-8, -8, 1], [7.875, 0, 0], [0, 16, 0])
    right = parallelogram([0.125, -8, 1], [7.875, 0, 0], [0, 16, 0])
    picture = render(blocked_floor((left, matrix), (right, matrix)), 10, stop_rule="FIXED", light_samples=4096)
    light = oracles.rectangle_corners(light_above(HEIGHT), SIZE)
    edges = [(apply(matrix, [[x, 0, 1]])[0], matrix[:3, :3] @ [s, 0, 0]) for x, s in ((-0.125, 1), (0.125, -1))]
    exact = np.zeros(picture.red.shape)
    for index in np.ndindex(exact.shape):
        point = picture.position[index]
        exact[index] = oracles.lambert(visible_through(point, edges, 1, light), point, UP)
    unshadowed = oracles.parallel_rectangle(picture.position[..., 0], picture.position[..., 1], 0.5, HEIGHT)
    assert np.abs(picture.red / (RHO * RADIANCE) - exact).max() < 5e-3 * unshadowed.max()
    assert (exact == 0).any() and (exact > 0.4 * unshadowed).any()


BLOCKERS = {
    "sphere": (sphere([0, 0, 1], 0.4, 10), None),
    "boxes": (box([-0.4, -0.2, 0.6], [0.1, 0.3, 1.2]), rotation([1, 1, 0], 10)),
    "needles": (parallelogram([-1, -0.05, 1.1], [2, 0, 0], [0, 0.1, 0.2], 30, 1), rotation(UP, 25)),
}


@pytest.mark.parametrize("name", BLOCKERS)
def test_b27_brute_force_with_the_same_points(name):
    """The pixel's own light points through sample_points, every triangle in float64. A ray within float rounding of
    an edge may go either way: one of 64 points in at most 1 % of the pixels; all others to float rounding of the
    summands."""
    shape, matrix = BLOCKERS[name]
    n, width = 64, 12
    picture = render(
        blocked_floor((shape, matrix)),
        width,
        stop_rule="PAPER",
        check_interval=n,
        error_tolerance=1e-12,
        max_light_samples=2 * n,
    )
    triangles = oracles.triangles_of(shape[0] if matrix is None else apply(matrix, shape[0]), shape[1])
    wrong, shadowed = 0, 0
    for index in np.ndindex(picture.red.shape):
        pixel = index[0] * width + index[1]
        points = pn.sample_points("OWEN_SOBOL", 2 * n, "SCRAMBLED", 0, pixel)
        f, places = oracles.summands(picture.position[index], UP, light_above(HEIGHT), SIZE, points)
        start = np.broadcast_to(picture.position[index], places.shape)
        hidden = oracles.occluded(start, places, triangles)
        exact = RHO * RADIANCE * (f * ~hidden).mean()
        wrong += abs(picture.red[index] - exact) > 3e-6 * RHO * RADIANCE * f.mean()
        shadowed += hidden.any() and not hidden.all()
    assert (picture.light_samples == 2 * n).all()
    assert wrong <= 0.01 * picture.red.size
    assert shadowed > 20


@pytest.mark.parametrize("name", BLOCKERS)
def test_b27_brute_force_with_dense_points(name):
    """Its own 96 x 96 grid of points on the luminaire instead: what the picture should converge to. Standard error
    of 1024 Owen-Sobol' points with an edge: 0.5 x 1024^-0.75 = 3e-3 of the unshadowed value; the worst of 36
    pixels: 1e-2; the mean over the picture a tenth of that."""
    shape, matrix = BLOCKERS[name]
    picture = render(blocked_floor((shape, matrix), half=1.0), 6, stop_rule="FIXED", light_samples=1024)
    triangles = oracles.triangles_of(shape[0] if matrix is None else apply(matrix, shape[0]), shape[1])
    g = (np.arange(96) + 0.5) / 96
    points = np.stack(np.meshgrid(g, g), axis=-1).reshape(-1, 2)
    error = np.zeros(picture.red.shape)
    for index in np.ndindex(error.shape):
        f, places = oracles.summands(picture.position[index], UP, light_above(HEIGHT), SIZE, points)
        hidden = oracles.occluded(np.broadcast_to(picture.position[index], places.shape), places, triangles)
        error[index] = (picture.red[index] / (RHO * RADIANCE) - (f * ~hidden).mean()) / f.mean()
    assert np.abs(error).max() < 1e-2
    assert abs(error.mean()) < 1e-3


def test_closed_box_keeps_everything_inside():
    """The luminaire in a closed box: not a trace outside, over 64 x 64 x 256 rays; the same without shadows is
    bright."""
    shell = (box([-0.8, -0.8, 1.5], [0.8, 0.8, 2.5]), rotation([1, 2, 3], 0))
    assert (render(blocked_floor(shell), 64, stop_rule="FIXED", light_samples=256).red == 0).all()
    assert (render(blocked_floor(shell, cast_shadow=False), 16).red > 0).all()


def test_light_without_shadow_ignores_blockers():
    plate = (parallelogram([-4, -4, 1], [8, 0, 0], [0, 8, 0]), None)
    seen = render(blocked_floor(plate, cast_shadow=False), 8, stop_rule="FIXED", light_samples=64)
    assert (seen.red == render(blocked_floor(cast_shadow=False), 8, stop_rule="FIXED", light_samples=64).red).all()
    assert seen.statistics["shadow_rays"] == 0 and (seen.light_samples == 64).all()


def test_a_face_behind_the_light_or_in_its_plane_does_not_shadow():
    """A lamp's back plate above the luminaire, and a ceiling it is let into, exactly in its plane: full light."""
    for z in (HEIGHT + 1e-3, HEIGHT):
        plate = (parallelogram([-4, -4, z], [8, 0, 0], [0, 8, 0]), None)
        picture = render(blocked_floor(plate), 8, stop_rule="FIXED", light_samples=1024)
        exact = oracles.parallel_rectangle(picture.position[..., 0], picture.position[..., 1], 0.5, HEIGHT)
        np.testing.assert_allclose(picture.red, RHO * RADIANCE * exact, rtol=3e-4)


def test_both_sides_of_a_blocker_shadow():
    """Faces count from either side: the plate's winding does not matter."""
    plate = parallelogram([-0.3, -0.3, 1], [0.6, 0, 0], [0, 0.6, 0])
    turned = (plate[0], plate[1][:, ::-1].copy())
    pictures = [render(blocked_floor((p, None)), 12, stop_rule="FIXED", light_samples=64).red for p in (plate, turned)]
    assert (pictures[0] == pictures[1]).all()
    open_floor = render(lit_floor((RADIANCE,) * 3), 12, stop_rule="FIXED", light_samples=64).red
    assert pictures[0].sum() < 0.9 * open_floor.sum()
