# SPDX-License-Identifier: GPL-3.0-or-later
"""Passes of the core: the parts of the light add up to Combined, which does not change for being taken apart.

Blender's manual: Combined = sum over diffuse and glossy of (direct + indirect) x colour, + emission + environment. So
with every rule, with one ray and antialiased, with mirrors, transparency, dim luminaires that get no rays, and groups.
"""

import numpy as np
import penumbra_native as pn
import pytest
from scenes import ALL_PASSES, add, box, floor, light_above, look_down, render, rotation, sphere, translation

LIGHT_PASSES = ["Diffuse Direct", "Diffuse Color", "Glossy Direct", "Glossy Indirect", "Glossy Color", "Emission",
                "Environment", "Shadow", "Mist"]  # fmt: skip
GROUPS = ["Combined_key", "Combined_rest", "Combined_none"]
MATTES = ["CryptoObject00", "CryptoMaterial00", "CryptoAsset00"]
EXTRA = [*LIGHT_PASSES, *GROUPS, *MATTES, "Object Index", "Material Index", "UV"]
WIDTH, HEIGHT = 61, 43
RULES = {
    "bounded": {"stop_rule": "BOUNDED", "pixel_samples": 1},
    "bounded, antialiased": {"stop_rule": "BOUNDED", "pixel_samples": 2},
    "fixed": {"stop_rule": "FIXED", "pixel_samples": 3, "light_samples": 16},
    "paper": {"stop_rule": "PAPER", "pixel_samples": 1},
    "variance": {"stop_rule": "VARIANCE", "pixel_samples": 2},
}


def coloured_glass(scene, transparency, colour):
    """A flat surface that lets some light through and reflects some, as a program."""
    registers = np.array([(0, 0, 0), transparency, colour], np.float32)
    closures = [("transparent", 1, 0, 0, 0), ("diffuse", 2, 0, 0, 0)]
    return scene.add_program("glass", registers, [], np.zeros(0, np.float32), closures, 0)


def build():
    """Luminaires of three groups and of none, one of them dim; a shiny ball, a mirror, glass, a glowing box."""
    scene = pn.Scene()
    groups = {name: scene.add_light_group(name.removeprefix("Combined_")) for name in GROUPS}
    number = 0

    def next_object(light_group=None):
        nonlocal number
        number += 1
        scene.set_traits(pass_index=number, object_matte=1.5 * number, asset_matte=2.5, light_group=light_group)

    next_object()
    add(scene, "floor", floor(columns=3))
    next_object()
    add(scene, "shiny", sphere([-0.9, 0.2, 0.4], 0.4, 16), albedo=0.2, phong=(0.3, 0.4, 0.5), phong_exponent=30)
    next_object()
    add(scene, "mirror", box([0.3, 0.6, 0], [1.4, 0.7, 1.2]), albedo=0.1, mirror=(0.8, 0.7, 0.6))
    next_object()
    pane = scene.add_mesh("pane", *box([-0.2, -0.9, 0.05], [0.5, -0.85, 0.8]))
    scene.add_instance("pane", pane, np.eye(4), [coloured_glass(scene, (0.6, 0.5, 0.4), (0.1, 0.2, 0.3))])
    next_object(groups["Combined_rest"])
    glowing = scene.add_program("glowing", np.array([(0, 0, 0), (0.4, 0.2, 0.1)], np.float32), [],
                                np.zeros(0, np.float32), [("emission", 1, 0, 0, 0)], 0)  # fmt: skip
    cube = scene.add_mesh("cube", *box([-0.1, -0.2, 0], [0.1, 0, 0.2]))
    scene.add_instance("cube", cube, np.eye(4), [glowing])
    next_object(groups["Combined_key"])
    scene.add_area_light("key", "RECTANGLE", light_above(), (1, 1), (3, 3, 3))
    next_object(groups["Combined_rest"])
    scene.add_area_light("rim", "ELLIPSE", translation(-2, 0, 1) @ rotation([0, 1, 0], -70), (0.5, 1), (2, 1, 0.5))
    scene.add_point_light("dim", translation(1, 0, 2), 0.1, (1e-4, 2e-4, 1e-4))
    scene.set_camera(
        "PERSPECTIVE", translation(0, -4, 2) @ rotation([1, 0, 0], 65), (-0.45, 0.45, -0.3, 0.35), (0.1, 30)
    )
    scene.set_background((0.1, 0.2, 0.3), light_group=groups["Combined_rest"])
    return scene


def all_passes(settings):
    return render(build(), WIDTH, HEIGHT, passes=ALL_PASSES + EXTRA, **settings).passes


@pytest.fixture(scope="module", params=RULES)
def rule(request):
    return RULES[request.param]


@pytest.fixture(scope="module")
def picture(rule):
    return all_passes(rule)


def test_the_parts_add_up_to_combined(picture):
    p = picture
    total = (
        p["Diffuse Direct"] * p["Diffuse Color"]
        + (p["Glossy Direct"] + p["Glossy Indirect"]) * p["Glossy Color"]
        + p["Emission"]
        + p["Environment"]
    )
    np.testing.assert_allclose(total, p["Combined"][..., :3], rtol=2e-6, atol=1e-6)
    for name in LIGHT_PASSES:
        assert p[name].std() > 1e-3, name  # each has something to tell in this scene


def test_the_light_groups_add_up_to_combined(picture):
    total = sum(picture[name] for name in GROUPS)
    np.testing.assert_allclose(total, picture["Combined"][..., :3], rtol=2e-6, atol=1e-6)
    assert not picture["Combined_none"].any()


def test_combined_is_the_same_bit_for_bit_without_passes(picture, rule):
    alone = render(build(), WIDTH, HEIGHT, **rule).passes
    for name in ALL_PASSES:
        assert np.array_equal(alone[name], picture[name]), name


def test_passes_do_not_depend_on_threads_and_borders(picture, rule):
    part = render(build(), WIDTH, HEIGHT, passes=EXTRA, region=(9, 5, 30, 22), threads=1, **rule).passes
    for name in EXTRA:
        assert np.array_equal(part[name], picture[name][5:27, 9:39]), name


def test_mattes_are_coverage(picture):
    """Each pixel's ids are those of objects in the scene; what they cover adds up to what is not background."""
    ids, coverage = picture["CryptoObject00"][..., 0::2], picture["CryptoObject00"][..., 1::2]
    assert set(np.unique(ids)) <= {0, 1.5, 3.0, 4.5, 6.0, 7.5}
    assert (coverage[..., 0] >= coverage[..., 1]).all() and (coverage >= 0).all()
    asset = picture["CryptoAsset00"]
    assert set(np.unique(asset[..., 0])) == {0, 2.5} and not asset[..., 2:].any()
    assert (coverage.sum(-1) <= asset[..., 1] + 1e-6).all()
    sky = picture["Depth"][..., 0] > 1e9
    np.testing.assert_allclose(asset[~sky & (coverage[..., 1] == 0), 1], coverage[~sky & (coverage[..., 1] == 0), 0])
    index = picture["Object Index"][..., 0]
    whole = coverage[..., 0] == 1
    assert whole.mean() > 0.5
    assert np.array_equal(ids[whole][:, 0], np.float32(1.5) * index[whole])


@pytest.mark.parametrize("settings", RULES.values(), ids=list(RULES))
def test_shadow_is_the_visible_share_of_a_half_hidden_luminaire(settings):
    """A plate that hides the half-space x > 0 of a small luminaire, seen from far below: there the share is 1/2 by
    symmetry, beside it 1 and 0. Penumbra on the floor: from x = -h to h, where the plate is half way up."""
    scene = pn.Scene()
    add(scene, "floor", floor())
    add(scene, "plate", floor(half=1.0), translation(1, 0, 1))
    scene.add_area_light("key", "RECTANGLE", light_above(), (0.2, 0.2), (30, 30, 30))
    look_down(scene, half=0.15, z=0.9)
    fine = settings | {"error_tolerance": 1e-5 if settings["stop_rule"] == "PAPER" else 1e-3, "light_samples": 4096}
    passes = render(scene, 48, 8, passes=["Shadow", "Combined"], **fine).passes
    x = (np.arange(48) + 0.5) / 48 * 0.3 - 0.15
    # What of the luminaire's x in -0.1 ... 0.1 is seen past the plate's edge from x on the floor: x' < -x.
    expected = np.clip((0.1 - x) / 0.2, 0, 1)
    shadow = passes["Shadow"].mean(axis=(0, 2))
    np.testing.assert_allclose(shadow, expected, atol=0.03)
    assert abs((shadow - expected).mean()) < 2e-3


@pytest.mark.parametrize("pixel_samples", [1, 2], ids=["centre", "antialiased"])
def test_many_luminaires_that_count_as_one_stay_in_their_light_groups(pixel_samples):
    """60 luminaires of two groups in turns, so that neighbours are of different ones: each group's pass against a
    scene with its luminaires alone, within twice the tolerance (both keep it), and both together are Combined."""
    groups = ["Combined_even", "Combined_odd"]
    settings = {"stop_rule": "BOUNDED", "pixel_samples": pixel_samples, "error_tolerance": 0.01}

    def scene_of(kept):
        scene = pn.Scene()
        numbers = [scene.add_light_group(name.removeprefix("Combined_")) for name in groups]
        add(scene, "floor", floor())
        add(scene, "crate", box([-0.4, -0.4, 0], [0.4, 0.4, 0.5]))
        for i in range(60):
            if i % 2 not in kept:
                continue
            scene.set_traits(light_group=numbers[i % 2])
            place = translation(0.4 * (i % 10) - 1.8, 0.5 * (i // 10) - 1.2, 1.5)
            colour = ((0.6, 0.1, 0.1), (0.1, 0.1, 0.8))[i % 2]
            scene.add_area_light(f"light {i}", "RECTANGLE", place, (0.1, 0.1), np.multiply(60, colour))
        look_down(scene, half=1.5)
        return scene

    def passes_of(*kept):
        return render(scene_of(kept), 32, passes=["Combined", *groups], **settings).passes

    together = passes_of(0, 1)
    np.testing.assert_allclose(sum(together[name] for name in groups), together["Combined"][..., :3], rtol=2e-6)
    for number, name in enumerate(groups):
        alone = passes_of(number)["Combined"][..., :3]
        error = np.abs(together[name] - alone).max(-1)
        assert alone.max() > 0.1 and (error > 0.02).mean() < 0.01
