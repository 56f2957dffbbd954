# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that calculate: Value, Math, Clamp, Map Range, Vector Math, Mapping, Separate and Combine XYZ."""

from .compiler import Compiler, Place, node


@node("ShaderNodeValue", "ShaderNodeRGB")
def constant(compiler: Compiler, place: Place, socket) -> int:
    return compiler.program.constant(socket.default_value)


@node("ShaderNodeMath")
def math(compiler: Compiler, place: Place, socket) -> int:
    inputs = [compiler.socket(s, place.groups) for s in place.node.inputs if s.enabled]
    result = compiler.operation(place, f"math.{place.node.operation}", *inputs)
    return compiler.program.clamped(result) if place.node.use_clamp else result


@node("ShaderNodeClamp")
def clamp(compiler: Compiler, place: Place, socket) -> int:
    inputs = [compiler.value(place, name) for name in ("Value", "Min", "Max")]
    return compiler.operation(place, f"clamp.{place.node.clamp_type}", *inputs)


@node("ShaderNodeMapRange")
def map_range(compiler: Compiler, place: Place, socket) -> int:
    is_vector = place.node.data_type == "FLOAT_VECTOR"
    if is_vector:
        names = ["Vector"] + [f"{name}_FLOAT3" for name in ("From_Min", "From_Max", "To_Min", "To_Max", "Steps")]
    else:
        names = ["Value", "From Min", "From Max", "To Min", "To Max", "Steps"]
    inputs = [compiler.value(place, name) for name in names]
    kind = place.node.interpolation_type
    result = compiler.operation(place, f"map_range.{kind}", *inputs)
    if place.node.clamp and kind in ("LINEAR", "STEPPED"):
        result = compiler.program.add("clamp.vector_range", result, inputs[3], inputs[4])
    return result


@node("ShaderNodeVectorMath")
def vector_math(compiler: Compiler, place: Place, socket) -> int:
    operation = place.node.operation
    vectors = [compiler.socket(s, place.groups) for s in place.node.inputs if s.enabled and s.type == "VECTOR"]
    scale = compiler.value(place, "Scale")
    if operation == "REFRACT":
        return compiler.operation(place, "vector.REFRACT", vectors[0], vectors[1], 0, scale)
    if operation == "SCALE":
        vectors.append(scale)
    return compiler.operation(place, f"vector.{operation}", *vectors)


@node("ShaderNodeMapping")
def mapping(compiler: Compiler, place: Place, socket) -> int:
    inputs = [compiler.value(place, name) for name in ("Vector", "Location", "Rotation", "Scale")]
    return compiler.operation(place, f"mapping.{place.node.vector_type}", *inputs)


@node("ShaderNodeSeparateXYZ", "ShaderNodeSeparateRGB")
def separate(compiler: Compiler, place: Place, socket) -> int:
    axis = "xyz"[list(place.node.outputs).index(socket)]
    return compiler.program.add(f"separate.{axis}", compiler.socket(place.node.inputs[0], place.groups))


@node("ShaderNodeCombineXYZ", "ShaderNodeCombineRGB")
def combine(compiler: Compiler, place: Place, socket) -> int:
    return compiler.program.add("combine", *(compiler.socket(s, place.groups) for s in place.node.inputs))
