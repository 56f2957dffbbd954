# SPDX-License-Identifier: GPL-3.0-or-later
"""The Principled BSDF as closures: as Cycles built it before Blender 4.0, and as layers since."""

from ... import compat
from .compiler import Compiler, Place

WHITE = (1.0, 1.0, 1.0)
BLACK = (0.0, 0.0, 0.0)
OLD_CLEARCOAT_F0, OLD_CLEARCOAT_IOR, OLD_CLEARCOAT_SHARE = 0.04, 1.5, 0.25
"""Constants of Burley's clearcoat."""


def principled(compiler: Compiler, place: Place, weight: int) -> None:
    program = compiler.program
    alpha = program.clamped(compiler.value(place, "Alpha"))
    if program.known(alpha) != WHITE:
        program.add_closure("transparent", program.multiply(weight, program.one_minus(alpha)))
        weight = program.multiply(weight, alpha)
    (layers if compat.PRINCIPLED_HAS_LAYERS else burley)(compiler, place, weight)


def emission(compiler: Compiler, place: Place, weight: int, name: str) -> None:
    colour = compiler.program.multiply(weight, compiler.value(place, name))
    strength = compiler.value(place, "Emission Strength")
    compiler.program.add_closure("emission", compiler.program.multiply(colour, strength))


def note_ignored(compiler: Compiler, place: Place, *names: str) -> None:
    """Inputs that ask for more than is rendered."""
    asked = [name for name in names if compiler.program.known(compiler.value(place, name)) != BLACK]
    if asked:
        compiler.note(place, f"{', '.join(asked)} not supported yet and ignored")


def add_diffuse(program, weight: int, colour: int, roughness: int) -> None:
    """Lambert's law, or Oren and Nayar's where it is rough."""
    keeps_energy = compat.ROUGH_DIFFUSE_KEEPS_ENERGY and program.known(roughness) != BLACK
    albedo = program.add("saturate", colour) if keeps_energy else 0
    program.add_closure("diffuse", program.multiply(weight, colour), roughness, edge=albedo)


def burley(compiler: Compiler, place: Place, weight: int) -> None:
    """Before Blender 4.0: diffuse with retro-reflection, sheen, one specular lobe from dielectric to metal, clearcoat.

    Subsurface scattering is rendered as diffuse of its colour, transmission left out.
    """
    program = compiler.program
    value = {name: compiler.value(place, name) for name in (
        "Base Color", "Subsurface", "Subsurface Color", "Metallic", "Specular", "Specular Tint", "Roughness", "Sheen",
        "Sheen Tint", "Clearcoat", "Clearcoat Roughness", "Transmission")}  # fmt: skip
    note_ignored(compiler, place, "Anisotropic", "Clearcoat Normal")
    if program.known(value["Transmission"]) != BLACK:
        compiler.note(place, "Transmission is not supported yet; its share of the surface is black")
    if program.known(value["Subsurface"]) != BLACK:
        compiler.note(place, "Subsurface is not supported yet; rendered as diffuse")
    base, metallic = value["Base Color"], program.clamped(value["Metallic"])
    transmission = program.clamped(value["Transmission"])
    dielectric = program.one_minus(metallic)
    diffuse_weight = program.multiply(weight, program.multiply(dielectric, program.one_minus(transmission)))

    diffuse = base
    if program.known(value["Subsurface"]) != BLACK:
        diffuse = program.mix(value["Subsurface"], base, value["Subsurface Color"])
    program.add_closure("disney", program.multiply(diffuse_weight, diffuse), value["Roughness"])
    if program.known(value["Sheen"]) != BLACK:
        tint = program.mix(
            value["Sheen Tint"], program.constant(WHITE), hue_of(compiler, base, (0.2126, 0.7152, 0.0722))
        )
        program.add_closure("sheen", program.multiply(program.multiply(diffuse_weight, value["Sheen"]), tint))

    specular_weight = program.multiply(weight, program.one_minus(program.multiply(transmission, dielectric)))
    specular = program.multiply(program.constant(0.08), value["Specular"])
    tint = program.mix(value["Specular Tint"], program.constant(WHITE), hue_of(compiler, base, (0.3, 0.6, 0.1)))
    f0 = program.add("saturate", program.mix(metallic, program.multiply(specular, tint), base))
    if program.known(value["Specular"]) != BLACK or program.known(value["Metallic"]) != BLACK:
        program.add_closure("glossy", program.multiply(specular_weight, f0), value["Roughness"],
                            edge=specular_weight, ior=ior_of_reflectance(compiler, specular))  # fmt: skip
    if program.known(value["Clearcoat"]) != BLACK:
        coat = program.multiply(weight, program.multiply(value["Clearcoat"], program.constant(OLD_CLEARCOAT_SHARE)))
        program.add_closure("clearcoat", program.multiply(coat, program.constant(OLD_CLEARCOAT_F0)),
                            value["Clearcoat Roughness"], edge=coat,
                            ior=program.constant(OLD_CLEARCOAT_IOR))  # fmt: skip
    emission(compiler, place, weight, "Emission")


def hue_of(compiler: Compiler, colour: int, weights) -> int:
    """A colour by its luminance of these weights; white if that is 0."""
    program = compiler.program
    luminance = program.add("vector.DOT_PRODUCT", colour, program.constant(weights))
    is_dark = program.math("COMPARE", luminance, 0.0, 0.0)
    return program.mix(is_dark, program.add("vector.DIVIDE", colour, luminance), program.constant(WHITE))


def ior_of_reflectance(compiler: Compiler, reflectance: int) -> int:
    """The index of refraction that reflects this share at normal incidence: 2 / (1 - sqrt(r)) - 1."""
    program = compiler.program
    return program.math(
        "SUBTRACT", program.math("DIVIDE", 2.0, program.one_minus(program.math("SQRT", reflectance))), 1.0
    )


def layers(compiler: Compiler, place: Place, weight: int) -> None:
    """Since Blender 4.0: coat over metal and dielectric; each layer dims what is below by what it reflects.

    Sheen, transmission and thin films are left out, subsurface scattering is rendered as diffuse.
    """
    program = compiler.program
    value = {name: compiler.value(place, name) for name in (
        "Base Color", "Metallic", "Roughness", "IOR", "Specular IOR Level", "Specular Tint", "Coat Weight",
        "Coat Roughness", "Coat IOR", "Coat Tint", "Diffuse Roughness")}  # fmt: skip
    note_ignored(compiler, place, "Anisotropic", "Transmission Weight", "Sheen Weight", "Subsurface Weight",
                 "Thin Film Thickness", "Coat Normal")  # fmt: skip
    one = program.constant(1.0)
    if program.known(value["Coat Weight"]) != BLACK:
        coat = program.multiply(weight, value["Coat Weight"])
        weight = dielectric(compiler, coat, value["Coat IOR"], one, value["Coat Roughness"], under=weight)
        if program.known(value["Coat Tint"]) != WHITE:
            tint = absorbed(compiler, value["Coat Tint"], value["Coat IOR"])
            weight = program.multiply(weight, program.mix(value["Coat Weight"], one, tint))
    emission(compiler, place, weight, "Emission Color")
    metallic = program.clamped(value["Metallic"])
    base = program.add("saturate", value["Base Color"])
    if program.known(metallic) != BLACK:
        metal = program.multiply(weight, metallic)
        if program.known(value["Specular Tint"]) != WHITE:
            compiler.note(place, "Specular Tint of metals is not supported yet and ignored")
        if place.node.distribution == "MULTI_GGX":
            base = program.add("multiple_scattering", base, value["Roughness"], program.add("normal"))
        program.add_closure("correlated glossy", program.multiply(metal, base), value["Roughness"],
                            edge=metal, ior=program.constant(SCHLICK))  # fmt: skip
        weight = program.multiply(weight, program.one_minus(metallic))
    # The level scales the reflectance at normal incidence that the index of refraction gives.
    root = program.math("DIVIDE", program.math("SUBTRACT", value["IOR"], 1.0), program.math("ADD", value["IOR"], 1.0))
    f0 = program.multiply(
        program.multiply(root, root), program.multiply(program.constant(2.0), value["Specular IOR Level"])
    )
    ior = ior_of_reflectance(compiler, f0)
    weight = dielectric(compiler, weight, ior, value["Specular Tint"], value["Roughness"], under=weight)
    add_diffuse(program, weight, value["Base Color"], value["Diffuse Roughness"])


def absorbed(compiler: Compiler, tint: int, ior: int) -> int:
    """What a coat leaves of light: `tint` straight down, by Beer's law along the viewer's way refracted into it."""
    program = compiler.program
    cosine = program.add("vector.DOT_PRODUCT", program.add("incoming"), program.add("normal"))
    outside = program.math("SUBTRACT", 1.0, program.math("MULTIPLY", cosine, cosine))
    inside = program.math("DIVIDE", outside, program.math("MULTIPLY", ior, ior))
    return program.add("gamma", tint, program.math("POWER", program.math("SUBTRACT", 1.0, inside), -0.5))


SCHLICK = -1.0
"""In place of an index of refraction: Schlick's approximation for metals."""


def dielectric(compiler: Compiler, weight: int, ior: int, tint: int, roughness: int, under: int) -> int:
    """Adds a dielectric's lobe; returns the weight of what is under it."""
    program = compiler.program
    root = program.math("DIVIDE", program.math("SUBTRACT", ior, 1.0), program.math("ADD", ior, 1.0))
    f0 = program.multiply(program.multiply(root, root), tint)
    program.add_closure("correlated glossy", program.multiply(weight, f0), roughness, edge=weight, ior=ior)
    reflected = program.multiply(weight, program.add("dielectric_albedo", roughness, ior, program.add("normal")))
    return program.add("vector.MAXIMUM", program.add("vector.SUBTRACT", under, reflected), 0)
