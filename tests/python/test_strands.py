# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair and point clouds against formulas and against meshes of tubes and spheres."""

import numpy as np
import penumbra_native as pn
import pytest
from scenes import add, floor, light_above, look_down, render, rotation, scaling, translation

SHAPES = ["RIBBON", "TUBE"]
STRAIGHT = np.array([[-1.5, 0, 0], [-0.5, 0, 0], [0.5, 0, 0], [1.5, 0, 0]], dtype=np.float32)


def strands(scene, keys, radii, counts, shape="RIBBON", matrix=None, albedo=0.5):
    """One object of strands."""
    material = scene.add_material("hair", (albedo,) * 3)
    number = scene.add_curves("hair", np.asarray(keys, np.float32), np.asarray(radii, np.float32),
                              np.asarray(counts, np.int32), shape)  # fmt: skip
    scene.add_instance("hair", number, np.eye(4) if matrix is None else matrix, [material])
    return number


def alone(keys, radii, counts, shape, matrix=None):
    scene = pn.Scene()
    scene.set_background((0, 0, 0), transparent=True)
    strands(scene, keys, radii, counts, shape, matrix)
    look_down(scene)
    return scene


def alpha(scene, width=64, height=None):
    settings = {"stop_rule": "FIXED", "light_samples": 1, "pixel_samples": 64, "filter_type": "BOX", "filter_width": 1}
    return render(scene, width, height, **settings).passes["Combined"][..., 3]


@pytest.mark.parametrize("placed", [None, translation(0.1, 0.2, 0.3) @ scaling(1.2, 1.2, 1.2)], ids=["id", "scaled"])
@pytest.mark.parametrize("shape", SHAPES)
def test_silhouette_of_a_cone(shape, placed):
    """Straight, with a radius that falls from 0.3 to 0.1: its area is length x mean diameter, 3 x 0.4. A tube's round
    ends add less than half a disk each. 64 samples a pixel: 0.2 % of the picture's 16."""
    area = alpha(alone(STRAIGHT, [0.3, 0.3 - 0.2 / 3, 0.1 + 0.2 / 3, 0.1], [4], shape, placed)).mean() * 16
    scale = 1 if placed is None else 1.2**2
    ends = np.pi * (0.3**2 + 0.1**2) / 2 if shape == "TUBE" else 0.0
    assert 1.2 * scale - 0.03 < area < (1.2 + ends) * scale + 0.03


@pytest.mark.parametrize("shape", SHAPES)
def test_silhouette_follows_the_curve(shape):
    """A wavy Catmull-Rom curve through its keys, against the distance from 2000 points of it: pixels further from it
    than the radius are empty, nearer ones full."""
    x = np.linspace(-1.6, 1.6, 9)
    keys = np.stack([x, 0.6 * np.sin(3 * x), np.zeros(9)], axis=1)
    seen = render(alone(keys, np.full(9, 0.1), [9], shape), 80, stop_rule="FIXED", light_samples=1, pixel_samples=1)
    p = np.concatenate([keys[:1], keys, keys[-1:]])
    u = np.linspace(0, 1, 250)[:, None]
    curve = np.concatenate([
        0.5 * (2 * b + (c - a) * u + (2 * a - 5 * b + 4 * c - d) * u**2 + (3 * b - a - 3 * c + d) * u**3)
        for a, b, c, d in zip(p, p[1:], p[2:], p[3:], strict=False)
    ])  # fmt: skip
    centres = (np.arange(80) + 0.5) / 80 * 4 - 2
    at = np.stack(np.meshgrid(centres, centres), axis=-1)
    distance = np.min(np.linalg.norm(at[:, :, None] - curve[:, :2], axis=-1), axis=-1)
    between = np.abs(at[..., 0]) < 1.55
    full = seen.passes["Combined"][..., 3] > 0.5
    assert full[(distance < 0.09) & between].all()
    assert not full[(distance > 0.11) & between].any()


def tube(segments=256, radius=0.3):
    """A mesh of a straight tube along x, smooth."""
    angle = 2 * np.pi * np.arange(segments) / segments
    ring = np.stack([np.zeros(segments), np.cos(angle), np.sin(angle)], axis=1)
    positions = np.concatenate([radius * ring + [x, 0, 0] for x in (-1.5, 1.5)])
    i = np.arange(segments)
    j = (i + 1) % segments
    triangles = np.concatenate([np.stack([i, j, j + segments], 1), np.stack([i, j + segments, i + segments], 1)])
    normals = np.concatenate([ring, ring])[triangles].astype(np.float32)
    return positions, triangles.astype(np.int32), normals


@pytest.mark.parametrize("rule", ["FIXED", "BOUNDED"])
@pytest.mark.parametrize("shape", SHAPES)
def test_shading_and_shadow_of_a_straight_strand(shape, rule):
    """Against a mesh of a tube, on a floor under an area light: a ribbon is lit as that. Away from the silhouettes and
    the ends; the mesh's facets make 1 - cos(pi / 256) = 1e-4 of difference, light points 0.002. A ribbon's shadow is
    that of a flat strip: its edges are elsewhere by less than the radius squared over the distance."""

    def picture(add_strand):
        scene = pn.Scene()
        add(scene, "floor", floor(z=-0.8))
        add_strand(scene)
        scene.add_area_light("key", "RECTANGLE", light_above(z=3, y=0.8), (0.5, 0.5), (400, 400, 400))
        look_down(scene)
        return render(scene, 48, stop_rule=rule, light_samples=1024, error_tolerance=0.002).red

    def mesh(scene):
        grey = scene.add_material("grey", (0.5, 0.5, 0.5))
        scene.add_instance("tube", scene.add_mesh("tube", *tube()), np.eye(4), [grey])

    ours, theirs = picture(lambda scene: strands(scene, STRAIGHT, np.full(4, 0.3), [4], shape)), picture(mesh)
    at = (np.arange(48) + 0.5) / 48 * 4 - 2
    y, x = np.meshgrid(at, at, indexing="ij")
    on = (np.abs(y) < 0.27) & (np.abs(x) < 1.3)
    off = (np.abs(y) > 0.35) & (np.abs(x) < 0.8)
    np.testing.assert_allclose(ours[on], theirs[on], atol=0.01)
    assert np.abs(ours[off] - theirs[off]).mean() < 0.004
    assert theirs[off].std() > 0.05  # there is a shadow


def test_no_strand_shadows_itself():
    """Under a sky that shines from everywhere a convex strand gets the light of all that it faces."""
    for shape in SHAPES:
        scene = pn.Scene()
        strands(scene, STRAIGHT, np.full(4, 0.02), [4], shape, rotation([0, 0, 1], 20))
        scene.set_background((1, 1, 1), lights=True)
        look_down(scene, half=0.5)
        red = render(scene, 64, stop_rule="FIXED", light_samples=64).red
        hit = render(scene, 64, stop_rule="FIXED", light_samples=1).passes["Depth"][..., 0] < 1e9
        np.testing.assert_allclose(red[hit], 0.5, atol=0.02)


def test_points_are_spheres():
    """Against the exact hits of rays with spheres: position and normal, to single precision of a scene of 4 m."""
    rng = np.random.default_rng(5)
    places, radii = rng.uniform(-1.5, 1.5, (20, 3)), rng.uniform(0.1, 0.4, 20)
    scene = pn.Scene()
    grey = scene.add_material("grey", (0.5, 0.5, 0.5))
    points = scene.add_points("cloud", places, radii.astype(np.float32))
    scene.add_instance("cloud", points, np.eye(4), [grey])
    look_down(scene)
    seen = render(scene, 64, stop_rule="FIXED", light_samples=1)
    at = (np.arange(64) + 0.5) / 64 * 4 - 2
    x, y = np.meshgrid(at, at)
    squared = radii**2 - (x[..., None] - places[:, 0]) ** 2 - (y[..., None] - places[:, 1]) ** 2
    top = np.where(squared > 0, places[:, 2] + np.sqrt(np.maximum(squared, 0)), -np.inf)
    first = top.argmax(-1)
    hit = squared.max(-1) > 0
    clear = hit & (np.take_along_axis(squared, first[..., None], -1)[..., 0] > 0.01)
    expected = np.stack([x, y, top.max(-1)], axis=-1)
    np.testing.assert_allclose(seen.position[clear], expected[clear], atol=1e-5)
    normal = (expected - places[first]) / radii[first][..., None]
    np.testing.assert_allclose(seen.passes["Normal"][clear], normal[clear], atol=1e-4)
    np.testing.assert_array_equal(seen.passes["Combined"][..., 3][clear], 1)


def test_strands_move():
    scene = pn.Scene()
    scene.set_background((0, 0, 0), transparent=True)
    grey = scene.add_material("grey", (0.5, 0.5, 0.5))
    way = [STRAIGHT + np.float32([0, y, 0]) for y in (-1, 1)]
    number = scene.add_curves("hair", STRAIGHT, np.full(4, 0.2, np.float32), np.array([4]), "RIBBON", motion=way)
    scene.add_instance("hair", number, np.eye(4), [grey])
    look_down(scene)
    settings = {"stop_rule": "FIXED", "light_samples": 1, "pixel_samples": 1024, "filter_width": 0.01}
    column = render(scene, 1, 40, filter_type="BOX", **settings).passes["Combined"][:, 0, 3]
    y = (np.arange(40) + 0.5) / 40 * 4 - 2
    low, high = np.clip((y - 0.2 + 1) / 2, 0, 1), np.clip((y + 0.2 + 1) / 2, 0, 1)
    np.testing.assert_allclose(column, high - low, atol=0.006)


BAD = {
    "not finite": (
        lambda k, r: k.__setitem__((1, 0), np.nan),
        "hair: the position or radius of strand 0 is not finite",
    ),
    "radius": (lambda k, r: r.__setitem__(2, np.inf), "hair: the position or radius of strand 0 is not finite"),
    "negative": (lambda k, r: r.__setitem__(2, -1), "hair: the radius of strand 0 is negative"),
}


@pytest.mark.parametrize(("spoil", "message"), BAD.values(), ids=BAD)
def test_bad_strands_are_refused(spoil, message):
    keys, radii = STRAIGHT.copy(), np.full(4, 0.1, np.float32)
    spoil(keys, radii)
    with pytest.raises(ValueError, match=message):
        strands(pn.Scene(), keys, radii, [4])


def test_counts_must_fit():
    with pytest.raises(ValueError, match="hair: its strands have 5 keys, but there are 4"):
        strands(pn.Scene(), STRAIGHT, np.full(4, 0.1), [5])
    with pytest.raises(ValueError, match="hair: shape is 'ROPE', expected RIBBON or TUBE"):
        strands(pn.Scene(), STRAIGHT, np.full(4, 0.1), [4], "ROPE")


@pytest.mark.parametrize("shape", SHAPES)
def test_strands_without_extent_are_left_out_with_a_note(shape):
    """One key, no radius, no length; the last one is there."""
    keys = np.concatenate([STRAIGHT[:1], STRAIGHT, np.repeat(STRAIGHT[:1], 3, axis=0), STRAIGHT])
    radii = np.concatenate([[0.3], np.zeros(4), np.full(3, 0.1), np.full(4, 0.3)])
    seen = render(alone(keys, radii, [1, 4, 3, 4], shape), 16, stop_rule="FIXED", light_samples=1)
    assert seen.statistics["warnings"] == ["3 strands or points without extent were left out: 'hair'"]
    assert 0 < seen.passes["Combined"][..., 3].mean() < 0.4
