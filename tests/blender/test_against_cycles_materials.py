# SPDX-License-Identifier: GPL-3.0-or-later
"""Shaders against Cycles: direct light of a floor and a sphere with a shader, in the same Blender.

Relative RMSE below 2.5 times Cycles' own noise at 256 samples (sqrt(2) times it is what equal pictures have, the rest
ours with 1024 points), and the means within 0.3 %; the Principled BSDF of Blender 4.0 and later within 3 %, since
what its layers reflect is taken from coarser tables.
"""

import bpy
import numpy as np
import pytest
from cycles_reference import (
    away_from_edges,
    colour,
    converge_cycles,
    object_index,
    relative_rmse,
    render_with_penumbra,
)
from helpers import add_plane, diffuse_material, render_pixels, use_cycles_as_reference
from material_scenes import GLOSSY, PRINCIPLED, Tree, show
from penumbra import compat, statistics

ORANGE = (0.8, 0.4, 0.1)
COAT, SHEEN = ("Coat Weight", "Sheen Weight") if compat.PRINCIPLED_HAS_LAYERS else ("Clearcoat", "Sheen")


def diffuse(t, **inputs):
    return t.add("ShaderNodeBsdfDiffuse", {"Color": ORANGE, **inputs}).outputs[0]


def glossy(t, roughness, distribution="GGX", **inputs):
    return t.add(GLOSSY, {"Color": ORANGE, "Roughness": roughness, **inputs}, distribution=distribution).outputs[0]


def principled(t, **inputs):
    return t.add(PRINCIPLED, {"Base Color": ORANGE} | {k.replace("_", " "): v for k, v in inputs.items()}).outputs[0]


def mix(t, factor, first, second):
    return t.add("ShaderNodeMixShader", {0: factor, 1: first, 2: second}).outputs[0]


def transparent(t, colour=(1, 1, 1)):
    return t.add("ShaderNodeBsdfTransparent", {"Color": colour}).outputs[0]


def bumps(t):
    return t.bump({"Height": t.noise("Fac", 4.0, Detail=0.0), "Distance": 0.3}).outputs[0]


def squares(t):
    return t.add("ShaderNodeTexChecker", {"Vector": t.coordinates("Generated"), "Scale": 6.0}).outputs["Fac"]


EXACT = {
    "diffuse": diffuse,
    "textured": lambda t: diffuse(t, Color=t.noise()),
    "rough diffuse": lambda t: diffuse(t, Roughness=0.7),
    "bumped diffuse": lambda t: diffuse(t, Normal=bumps(t)),
    "GGX 0.5": lambda t: glossy(t, 0.5),
    "GGX 0.25": lambda t: glossy(t, 0.25),
    "textured GGX": lambda t: glossy(t, t.noise("Fac"), Color=t.noise()),
    "bumped GGX": lambda t: glossy(t, 0.5, Normal=bumps(t)),
    "Beckmann": lambda t: glossy(t, 0.6, "BECKMANN"),
    "mix": lambda t: mix(t, 0.4, diffuse(t), glossy(t, 0.4)),
    "textured mix": lambda t: mix(t, squares(t), diffuse(t), glossy(t, 0.4)),
    "add": lambda t: t.add("ShaderNodeAddShader", {0: diffuse(t), 1: glossy(t, 0.4)}).outputs[0],
}
if compat.PRINCIPLED_HAS_LAYERS:  # before that it is another one, with a note
    EXACT["mixed multiple scattering"] = lambda t: mix(t, 0.5, diffuse(t), glossy(t, 0.5, "MULTI_GGX"))
PRINCIPLED_CASES = {
    "plain": principled,
    "metal": lambda t: principled(t, Metallic=1.0, Roughness=0.3),
    "half metal": lambda t: principled(t, Metallic=0.5, Roughness=0.7),
    "coated": lambda t: principled(t, **{COAT: 1.0, COAT.replace(" Weight", "") + " Roughness": 0.3}),
    "textured": lambda t: principled(t, Base_Color=t.noise(), Roughness=t.noise("Fac"), Metallic=squares(t)),
    "bumped": lambda t: principled(t, Normal=bumps(t)),
}

LAYERED = {
    "specular tint": lambda t: principled(t, Specular_Tint=(0.2, 0.9, 0.4)),
    "IOR 2": lambda t: principled(t, IOR=2.0, Roughness=0.3),
    "IOR level 1": lambda t: principled(t, **{"Specular IOR Level": 1.0}, Roughness=0.3),
    "IOR level 0": lambda t: principled(t, **{"Specular IOR Level": 0.0}),
    "rough": lambda t: principled(t, Roughness=1.0),
    "half coat": lambda t: principled(t, **{"Coat Weight": 0.5, "Coat Roughness": 0.2, "Coat IOR": 1.8}),
    "coat tint": lambda t: principled(t, **{"Coat Weight": 1.0, "Coat Roughness": 0.3, "Coat Tint": (0.9, 0.5, 0.3)}),
    "rough metal": lambda t: principled(t, Metallic=1.0, Roughness=0.8),
}
"""Measured in Blender 4.3: means of the whole within 0.3 %, of the sphere alone within 2 % and its blue within 4 %."""


def assert_matches(scene, tolerance_of_mean: float, times_noise: float = 2.5, notes=()) -> None:
    ours = render_with_penumbra(scene)
    assert statistics.last_render["warnings"] == list(notes)
    cycles, noise = converge_cycles(scene, samples=256)
    inside, expected = away_from_edges(cycles, margin=1), colour(cycles)
    difference = colour(ours) - expected
    assert inside.sum() > 800
    assert abs(difference[inside].mean()) < tolerance_of_mean * expected[inside].mean()
    if times_noise:
        limit = times_noise * relative_rmse(noise, expected, inside)
        assert relative_rmse(difference, expected, inside) < limit
    # Cycles draws whether a ray passes: 256 samples, twice, leave a standard error of 0.022 at most in a pixel.
    alpha = ours["Combined"][inside][:, 3] - cycles["Combined"][inside][:, 3]
    assert abs(alpha.mean()) < 1e-3 and abs(alpha).max() < 0.1


@pytest.mark.parametrize("name", EXACT)
def test_shader(scene, name):
    tree = Tree()
    show(scene, tree.finish(EXACT[name](tree)))
    assert_matches(scene, 3e-3)


def on_the_sphere(scene, shader_of, points: int) -> tuple[np.ndarray, np.ndarray]:
    """Mean r, g, b of a sphere with this shader, in both engines."""
    tree = Tree()
    _, sphere = show(scene, tree.finish(shader_of(tree)), diffuse_material("Grey"))
    ours = colour(render_with_penumbra(scene, points))
    cycles, _ = converge_cycles(scene, samples=512)
    where = away_from_edges(cycles, margin=1) & (object_index(cycles) == sphere.pass_index)
    assert where.sum() > 100
    return ours[where].mean(0), colour(cycles)[where].mean(0)


def test_a_sharp_lobe_over_a_rough_one_of_another_hue(scene):
    """The sharp one falls between the points of any coarse grid on the luminaire: r and g, which it alone has, were 37
    % too dark. Within 4 %: 4096 points meet its highlight some ten times a pixel, in some six pixels."""
    ours, cycles = on_the_sphere(
        scene,
        lambda t: mix(
            t, 0.5, glossy(t, 0.7, "BECKMANN", Color=(0, 0, 0.8)), glossy(t, 0.1, "BECKMANN", Color=(0.2, 0.2, 0.9))
        ),
        4096,
    )
    np.testing.assert_allclose(ours, cycles, rtol=0.04)


@pytest.mark.skipif(compat.PRINCIPLED_HAS_LAYERS, reason="Burley's clearcoat is gone since Blender 4.0")
def test_clearcoat_alone(scene, monkeypatch):
    """Cycles without multiple importance sampling is the oracle: with it, it draws directions by another distribution
    than it says, and highlights are up to twice as bright (seen: 1.96 times at roughness 0.2). Within 0.5 %."""

    def by_light_alone(scene, samples=64):
        use_cycles_as_reference(scene, samples)
        for light in bpy.data.lights:
            light.cycles.use_multiple_importance_sampling = False

    monkeypatch.setattr("cycles_reference.use_cycles_as_reference", by_light_alone)
    ours, cycles = on_the_sphere(
        scene,
        lambda t: principled(t, Base_Color=(0, 0, 0), Specular=0.0, Clearcoat=1.0, Clearcoat_Roughness=0.3),
        4096,
    )
    np.testing.assert_allclose(ours, cycles, rtol=5e-3)


@pytest.mark.parametrize("name", PRINCIPLED_CASES)
def test_principled(scene, name):
    tree = Tree()
    show(scene, tree.finish(PRINCIPLED_CASES[name](tree)))
    if compat.PRINCIPLED_HAS_LAYERS:
        assert_matches(scene, 3e-2, times_noise=0)
    else:
        assert_matches(scene, 3e-3)


def test_without_material(scene):
    """Up to Blender 4.5 80 % grey; since 5.0 the untouched Principled BSDF, the very picture of a new material."""
    tree = Tree()
    objects = show(scene, tree.finish(tree.add(PRINCIPLED).outputs[0]))
    touched = render_pixels(scene)
    for one in objects:
        one.data.materials.clear()
    objects[0].data.materials.append(None)
    ours = render_pixels(scene, lambertian=False)
    assert statistics.last_render["warnings"] == []
    assert np.array_equal(ours["Combined"], touched["Combined"]) == compat.DEFAULT_SURFACE_IS_PRINCIPLED
    use_cycles_as_reference(scene, 512)
    expected = colour(render_pixels(scene, "CYCLES", lambertian=False))
    difference = (colour(ours) - expected)[expected.min(-1) > 0]
    assert abs(difference.mean()) < (3e-2 if compat.DEFAULT_SURFACE_IS_PRINCIPLED else 3e-3) * expected.mean()


@pytest.mark.skipif(not compat.PRINCIPLED_HAS_LAYERS, reason="layers came with Blender 4.0")
@pytest.mark.parametrize("name", LAYERED)
def test_principled_layers(scene, name):
    tree = Tree()
    show(scene, tree.finish(LAYERED[name](tree)))
    assert_matches(scene, 1e-2, times_noise=0)


@pytest.mark.skipif(not compat.PRINCIPLED_HAS_LAYERS, reason="layers came with Blender 4.0")
@pytest.mark.parametrize(
    ("inputs", "named"),
    [
        ({"Metallic": 1.0, "Specular_Tint": (0.2, 0.9, 0.4)}, "Specular Tint of metals"),
        ({"Sheen_Weight": 1.0}, "Sheen Weight"),
        ({"Anisotropic": 0.5}, "Anisotropic"),
        ({"Transmission_Weight": 1.0}, "Transmission Weight"),
    ],
)
def test_what_the_principled_leaves_out_is_named(scene, inputs, named):
    tree = Tree()
    show(scene, tree.finish(principled(tree, **inputs)))
    render_with_penumbra(scene, 16)
    (note,) = statistics.last_render["warnings"]
    assert named in note and "'Principled BSDF'" in note and "'Material'" in note


@pytest.mark.skipif(compat.PRINCIPLED_HAS_LAYERS, reason="another sheen since Blender 4.0")
def test_sheen_and_tint(scene):
    tree = Tree()
    inputs = {
        "Specular Tint": 0.5,
        "Specular": 0.8,
        "Sheen Tint": 0.4,
        SHEEN: 1.0,
        COAT: 0.6,
        "Clearcoat Roughness": 0.3,
    }
    show(scene, tree.finish(principled(tree, **inputs)))
    assert_matches(scene, 3e-3)


TRANSPARENT = {
    "half": lambda t: mix(t, 0.5, diffuse(t), transparent(t)),
    "cut out": lambda t: mix(t, squares(t), diffuse(t), transparent(t)),
    "grey glass": lambda t: transparent(t, (0.5, 0.5, 0.5)),
    "Alpha": lambda t: principled(t, Alpha=0.4),
    "textured": lambda t: mix(t, t.noise("Fac"), diffuse(t), transparent(t)),
}


@pytest.mark.parametrize("film", [False, True])
@pytest.mark.parametrize("name", TRANSPARENT)
def test_transparency(scene, name, film):
    """Seen through, and in the shadows of a sphere and a square; alpha, too."""
    tree = Tree()
    material = tree.finish(TRANSPARENT[name](tree))
    show(scene, material, diffuse_material("Floor", (0.6, 0.6, 0.6)))
    add_plane(scene, "Square", size=0.8, location=(0.8, 0.2, 1.0)).data.materials.append(material)
    scene.render.film_transparent = film
    assert_matches(scene, 3e-3 if name != "Alpha" or not compat.PRINCIPLED_HAS_LAYERS else 3e-2)


def test_holdout_is_a_hole_in_the_film(scene):
    tree = Tree()
    material = tree.finish(mix(tree, 0.5, diffuse(tree), tree.add("ShaderNodeHoldout").outputs[0]))
    show(scene, material, diffuse_material("Floor", (0.6, 0.6, 0.6)))
    scene.render.film_transparent = True
    assert_matches(scene, 3e-3)


def test_emission_is_seen_through_a_mirror(scene):
    """Oracle: the emitting floor's value times the mirror's colour."""
    floor, mirror = Tree("Floor"), Tree("Mirror")
    shining = floor.finish(floor.add("ShaderNodeEmission", {"Color": ORANGE, "Strength": 2.0}).outputs[0])
    show(scene, mirror.finish(glossy(mirror, 0.0, Color=(0.5, 0.25, 1.0))), shining)
    picture = colour(render_with_penumbra(scene, 16))
    np.testing.assert_allclose(picture[2, 24], np.multiply(ORANGE, 2.0), rtol=1e-6)
    np.testing.assert_allclose(picture[17, 24], np.multiply(ORANGE, (1.0, 0.5, 2.0)), rtol=1e-6)


@pytest.mark.parametrize("pixel_samples", [1, pytest.param(16, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", ["textured", "half", "cut out"])
def test_bounded_keeps_its_promise(scene, name, pixel_samples):
    """Against 4096 points in each pixel, or 1024 rays; at most 1.5 % of so few pixels beyond the tolerance.
    Antialiased, half transparent shadows miss a little more (README, known limits): 2.5 %."""
    tree = Tree()
    build = {**TRANSPARENT, "textured": PRINCIPLED_CASES["textured"]}[name]
    show(scene, tree.finish(build(tree)))
    scene.penumbra.pixel_samples, scene.penumbra.error_tolerance = pixel_samples, 0.01
    bounded = colour(render_pixels(scene))
    scene.penumbra.stop_rule = "FIXED"
    scene.penumbra.light_samples, scene.penumbra.pixel_samples = (4096, 1) if pixel_samples == 1 else (16, 1024)
    reference = colour(render_pixels(scene))
    error = np.abs(bounded - reference).max(-1) / np.maximum(reference.max(-1), 1)
    assert (error > 0.01).mean() < (0.025 if name == "half" and pixel_samples > 1 else 0.015)


def test_slots_of_instances_that_share_a_mesh(scene):
    """Two objects with one mesh, whose slots are linked to the objects: one reads a UV map, the other does not."""
    textured, plain = Tree("Textured"), diffuse_material("Plain", ORANGE)
    floor, _ = show(scene, plain)
    floor.material_slots[0].link = "OBJECT"
    floor.material_slots[0].material = textured.emit(textured.coordinates("UV"))
    other = bpy.data.objects.new("Other", floor.data)
    scene.collection.objects.link(other)
    other.location = (0, 5, 0)
    picture = colour(render_with_penumbra(scene, 64))
    assert picture[2, 24].max() > 0 and picture[2, 24, 2] == 0  # u, v, 0
    cycles, _ = converge_cycles(scene, 16)
    np.testing.assert_allclose(picture[2, 24], colour(cycles)[2, 24], atol=1e-4)
