# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that change colours: Mix, Hue/Saturation, Gamma, Invert, Bright/Contrast, ramps, curves, Separate, Combine."""

from ...compat import RAMP_TABLE_SIZE
from .blackbody import blackbody
from .compiler import Compiler, Place, UnsupportedNode, node


@node("ShaderNodeMixRGB")
def mix_rgb(compiler: Compiler, place: Place, socket) -> int:
    factor, first, second = (compiler.socket(s, place.groups) for s in place.node.inputs)
    return blend(compiler, place, factor, first, second, place.node.use_clamp, True)


@node("ShaderNodeMix")
def mix(compiler: Compiler, place: Place, socket) -> int:
    kind = {"FLOAT": "Float", "VECTOR": "Vector", "RGBA": "Color"}.get(place.node.data_type)
    if kind is None:
        raise UnsupportedNode(f"node {place.node.name!r}: {place.node.data_type!r} is not supported yet")
    first, second = (compiler.value(place, f"{name}_{kind}") for name in "AB")
    if kind == "Vector" and place.node.factor_mode == "NON_UNIFORM":
        factor = compiler.value(place, "Factor_Vector")
        if place.node.clamp_factor:
            factor = compiler.program.add("saturate", factor)
        return compiler.program.add("mix.non_uniform", factor, first, second)
    factor = compiler.value(place, "Factor_Float")
    if kind == "Color":
        return blend(compiler, place, factor, first, second, place.node.clamp_result, place.node.clamp_factor)
    factor = compiler.program.clamped(factor) if place.node.clamp_factor else factor
    return compiler.program.mix(factor, first, second)


def blend(
    compiler: Compiler, place: Place, factor: int, first: int, second: int, clamps: bool, clamps_factor: bool
) -> int:
    factor = compiler.program.clamped(factor) if clamps_factor else factor
    result = compiler.operation(place, f"mix.{place.node.blend_type}", factor, first, second)
    return compiler.program.add("saturate", result) if clamps else result


def simple(identifier: str, operation: str, *names: str) -> None:
    """Registers a node that is one operation on inputs of these names."""

    @node(identifier)
    def compile_node(compiler: Compiler, place: Place, socket) -> int:
        return compiler.operation(place, operation, *(compiler.value(place, name) for name in names))


simple("ShaderNodeHueSaturation", "hue_saturation", "Fac", "Color", "Hue", "Saturation", "Value")
simple("ShaderNodeGamma", "gamma", "Color", "Gamma")
simple("ShaderNodeInvert", "invert", "Fac", "Color")
simple("ShaderNodeBrightContrast", "bright_contrast", "Color", "Bright", "Contrast")
simple("ShaderNodeRGBToBW", "luminance", "Color")


@node("ShaderNodeBlackbody")
def blackbody_colour(compiler: Compiler, place: Place, socket) -> int:
    kelvin = compiler.program.known(compiler.value(place, "Temperature"))
    if kelvin is None:
        raise UnsupportedNode(f"node {place.node.name!r}: a temperature that varies is not supported yet")
    return compiler.program.constant(blackbody(kelvin[0]))


@node("ShaderNodeLightFalloff")
def light_falloff(compiler: Compiler, place: Place, socket) -> int:
    """Quadratic is what light does by itself."""
    smooth = compiler.program.known(compiler.value(place, "Smooth"))
    if socket.name != "Quadratic" or smooth != (0.0, 0.0, 0.0):
        raise UnsupportedNode(f"node {place.node.name!r}: only quadratic, unsmoothed falloff is supported")
    return compiler.value(place, "Strength")


def separated(compiler: Compiler, place: Place, socket, mode: str) -> int:
    colour = compiler.socket(place.node.inputs[0], place.groups)
    if mode != "RGB":
        colour = compiler.operation(place, f"{mode.lower()}_from_rgb", colour)
    return compiler.program.add(f"separate.{'xyz'[list(place.node.outputs).index(socket)]}", colour)


def combined(compiler: Compiler, place: Place, mode: str) -> int:
    colour = compiler.program.add("combine", *(compiler.socket(s, place.groups) for s in place.node.inputs))
    return colour if mode == "RGB" else compiler.operation(place, f"rgb_from_{mode.lower()}", colour)


@node("ShaderNodeSeparateColor")
def separate_color(compiler: Compiler, place: Place, socket) -> int:
    return separated(compiler, place, socket, place.node.mode)


@node("ShaderNodeSeparateHSV")
def separate_hsv(compiler: Compiler, place: Place, socket) -> int:
    return separated(compiler, place, socket, "HSV")


@node("ShaderNodeCombineColor")
def combine_color(compiler: Compiler, place: Place, socket) -> int:
    return combined(compiler, place, place.node.mode)


@node("ShaderNodeCombineHSV")
def combine_hsv(compiler: Compiler, place: Place, socket) -> int:
    return combined(compiler, place, "HSV")


@node("ShaderNodeValToRGB")
def color_ramp(compiler: Compiler, place: Place, socket) -> int:
    ramp = place.node.color_ramp
    values = [channel for i in range(RAMP_TABLE_SIZE) for channel in ramp.evaluate(i / (RAMP_TABLE_SIZE - 1))]
    table = compiler.program.table([RAMP_TABLE_SIZE, ramp.interpolation == "CONSTANT", *values])
    result = compiler.operation(place, "ramp", compiler.value(place, "Fac"), data=table)
    return result + 1 if socket.name == "Alpha" else result


@node("ShaderNodeRGBCurve", "ShaderNodeVectorCurve", "ShaderNodeFloatCurve")
def curves(compiler: Compiler, place: Place, socket) -> int:
    """Each channel has its curve; those of an RGB Curves node follow the one they share."""
    mapping = place.node.mapping
    mapping.update()
    shared = mapping.curves[3] if len(mapping.curves) > 3 else None
    channels = list(mapping.curves)[:3] if len(mapping.curves) > 1 else [mapping.curves[0]] * 3
    places = [point.location[0] for curve in mapping.curves for point in curve.points]
    first, last = min(0.0, *places), max(1.0, *places)
    values = []
    for i in range(RAMP_TABLE_SIZE):
        x = first + (last - first) * i / (RAMP_TABLE_SIZE - 1)
        x = mapping.evaluate(shared, x) if shared else x
        values += [mapping.evaluate(curve, x) for curve in channels]
    table = compiler.program.table([RAMP_TABLE_SIZE, first, last, mapping.extend == "EXTRAPOLATED", *values])
    factor, value = (compiler.socket(s, place.groups) for s in place.node.inputs)
    return compiler.operation(place, "curves", factor, value, data=table)
