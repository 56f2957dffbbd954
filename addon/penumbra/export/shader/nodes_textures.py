# SPDX-License-Identifier: GPL-3.0-or-later
"""Texture nodes: Image, Checker, Noise, Gradient."""

from .compiler import Compiler, Place, UnsupportedNode, node
from .nodes_surface import default_uv, generated

MISSING = (1.0, 0.0, 1.0)
"""Magenta, as in Cycles."""


def note_mapping(compiler: Compiler, place: Place) -> None:
    """The mapping that texture nodes had inside before there was a node for it."""
    mapping = place.node.texture_mapping
    if any(mapping.translation) or any(mapping.rotation) or any(s != 1 for s in mapping.scale):
        compiler.note(place, "its own texture mapping is not supported yet and ignored")


@node("ShaderNodeTexImage")
def image(compiler: Compiler, place: Place, socket) -> int:
    source = place.node
    note_mapping(compiler, place)
    if source.projection != "FLAT":
        compiler.note(place, f"projection {source.projection!r} is not supported yet; rendered as flat")
    number = None
    if source.image is None:
        compiler.note(place, "has no image; rendered in magenta")
    else:
        number = compiler.images.number(source, compiler.material_name, compiler.issues)
    if number is None:
        return compiler.program.constant(1.0 if socket.name == "Alpha" else MISSING)
    register = compiler.program.add("image", compiler.coordinates(place, lambda: default_uv(compiler)), data=number)
    return register + (socket.name == "Alpha")


@node("ShaderNodeTexChecker")
def checker(compiler: Compiler, place: Place, socket) -> int:
    note_mapping(compiler, place)
    vector = compiler.coordinates(place, lambda: generated(compiler))
    inputs = [compiler.value(place, name) for name in ("Color1", "Color2", "Scale")]
    return compiler.program.add("checker", vector, *inputs) + (socket.identifier == "Fac")  # Blender 5 names it Factor


@node("ShaderNodeTexNoise")
def noise(compiler: Compiler, place: Place, socket) -> int:
    """Fractal Brownian motion; other types, which Blender has since 4.1, are not supported."""
    note_mapping(compiler, place)
    source, program = place.node, compiler.program
    if getattr(source, "noise_type", "FBM") != "FBM":
        raise UnsupportedNode(f"node {source.name!r}: {source.noise_type!r} is not supported yet")
    vector = compiler.coordinates(place, lambda: generated(compiler))
    inputs = [compiler.value(place, name) for name in ("W", "Scale", "Detail", "Roughness", "Distortion")]
    lacunarity = compiler.value(place, "Lacunarity") if place.input("Lacunarity") else program.constant(2.0)
    if not place.input("Lacunarity"):  # before Blender 4.0 the roughness ends at 1
        inputs[3] = program.clamped(inputs[3])
    normalised = getattr(source, "normalize", True)
    name = f"noise.{source.noise_dimensions}"
    return compiler.operation(place, name, vector, *inputs, lacunarity, data=int(normalised)) + (socket.name == "Color")


@node("ShaderNodeTexGradient")
def gradient(compiler: Compiler, place: Place, socket) -> int:
    note_mapping(compiler, place)
    vector = compiler.coordinates(place, lambda: generated(compiler))
    return compiler.operation(place, f"gradient.{place.node.gradient_type}", vector)
