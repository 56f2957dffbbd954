# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that read surface or ray: coordinates, UV maps, attributes, geometry, Fresnel, bumps and normal maps."""

import numpy as np

from ... import compat
from .attributes import DEFAULT_COLOUR, DEFAULT_UV, GENERATED, tangent_name
from .compiler import Compiler, Place, UnsupportedNode, node


def generated(compiler: Compiler) -> int:
    return compiler.attribute(GENERATED)


def default_uv(compiler: Compiler) -> int:
    return compiler.attribute(DEFAULT_UV)


def matrix_table(compiler: Compiler, matrix) -> int:
    return compiler.program.table(np.array(matrix, dtype=float)[:3].ravel())


@node("ShaderNodeTexCoord")
def texture_coordinate(compiler: Compiler, place: Place, socket) -> int:
    if place.node.from_instancer:
        compiler.note(place, "From Instancer is not supported yet and ignored")
    program = compiler.program
    if socket.name == "Generated":
        return generated(compiler)
    if socket.name == "UV":
        return default_uv(compiler)
    if socket.name == "Object":
        if place.node.object is None:
            return program.add("object_position", shift=compiler.shift)
        table = matrix_table(compiler, place.node.object.matrix_world.inverted_safe())
        return program.add("transform.point", program.add("position", shift=compiler.shift), data=table)
    if socket.name == "Normal":
        return program.add("object_normal")
    if socket.name == "Reflection":
        return program.add("reflection")
    raise UnsupportedNode(f"node {place.node.name!r}: {socket.name!r} is not supported yet")


@node("ShaderNodeUVMap")
def uv_map(compiler: Compiler, place: Place, socket) -> int:
    if place.node.from_instancer:
        compiler.note(place, "From Instancer is not supported yet and ignored")
    return compiler.attribute(place.node.uv_map or DEFAULT_UV)


@node("ShaderNodeVertexColor")
def vertex_colour(compiler: Compiler, place: Place, socket) -> int:
    return compiler.attribute(place.node.layer_name or DEFAULT_COLOUR) + (socket.name == "Alpha")


@node("ShaderNodeAttribute")
def attribute(compiler: Compiler, place: Place, socket) -> int:
    if place.node.attribute_type != "GEOMETRY":
        raise UnsupportedNode(f"node {place.node.name!r}: {place.node.attribute_type!r} is not supported yet")
    register = compiler.attribute(place.node.attribute_name)
    if socket.identifier == "Fac":
        return compiler.program.add("average", register)
    return register + (socket.name == "Alpha")


@node("ShaderNodeNewGeometry")
def geometry(compiler: Compiler, place: Place, socket) -> int:
    operation = {"Position": "position", "Normal": "normal", "True Normal": "true_normal", "Incoming": "incoming",
                 "Parametric": "parametric", "Backfacing": "backfacing"}.get(socket.name)  # fmt: skip
    if operation is None:
        raise UnsupportedNode(f"node {place.node.name!r}: {socket.name!r} is not supported yet")
    return compiler.program.add(operation, shift=compiler.shift)


@node("ShaderNodeLightPath")
def light_path(compiler: Compiler, place: Place, socket) -> int:
    """Rays are the camera's, a mirror's (glossy and singular ones, to Cycles) or shadow rays."""
    kind = {"Is Camera Ray": "camera", "Is Shadow Ray": "shadow", "Is Glossy Ray": "mirror",
            "Is Singular Ray": "mirror", "Is Reflection Ray": "mirror"}.get(socket.name)  # fmt: skip
    if kind:
        return compiler.program.add(f"is_ray.{kind}")
    if socket.name in ("Is Diffuse Ray", "Is Transmission Ray"):
        return compiler.program.constant(0.0)
    raise UnsupportedNode(f"node {place.node.name!r}: {socket.name!r} is not supported yet")


@node("ShaderNodeFresnel")
def fresnel(compiler: Compiler, place: Place, socket) -> int:
    return compiler.program.add("fresnel", compiler.value(place, "IOR"), compiler.normal(place))


@node("ShaderNodeLayerWeight")
def layer_weight(compiler: Compiler, place: Place, socket) -> int:
    register = compiler.program.add("layer_weight", compiler.value(place, "Blend"), compiler.normal(place))
    return register + (socket.name == "Facing")


@node("ShaderNodeNormal")
def normal(compiler: Compiler, place: Place, socket) -> int:
    """A direction chosen in the node, or how much another one points its way."""
    direction = compiler.program.add("vector.NORMALIZE", compiler.program.constant(place.node.outputs[0].default_value))
    if socket.name == "Normal":
        return direction
    other = compiler.program.add("vector.NORMALIZE", compiler.value(place, "Normal"))
    return compiler.program.add("vector.DOT_PRODUCT", direction, other)


@node("ShaderNodeBump")
def bump(compiler: Compiler, place: Place, socket) -> int:
    """The height is evaluated three times: at the point, and a pixel's width to two sides."""
    outer, heights = compiler.shift, []
    for compiler.shift in range(3):
        heights.append(compiler.value(place, "Height"))
    compiler.shift = outer
    distance = compiler.value(place, "Distance")
    if place.node.invert:
        distance = compiler.program.math("MULTIPLY", distance, -1.0)
    strength = compiler.value(place, "Strength")
    bumped = compiler.program.add("bump", strength, distance, *heights, compiler.normal(place))
    return compiler.program.add("valid_reflection", bumped) if compat.DIFFUSE_NORMALS_REFLECT else bumped


@node("ShaderNodeNormalMap")
def normal_map(compiler: Compiler, place: Place, socket) -> int:
    colour, strength = compiler.value(place, "Color"), compiler.value(place, "Strength")
    space = place.node.space
    if space != "TANGENT":
        return compiler.operation(place, f"normal_map.{space}", colour, strength)
    program = compiler.program
    if compat.NORMAL_MAP_BENDS_COLOUR:
        colour, strength = bent(program, colour, strength), program.constant(1.0)
    tangent = compiler.attribute(tangent_name(place.node.uv_map))
    return program.add("normal_map.TANGENT", colour, strength, tangent, tangent + 1)


def bent(program, colour: int, strength: int) -> int:
    """A normal map's colour moved from the flat one as far as the strength says, but no further upwards than it is."""
    flat = program.constant((0.5, 0.5, 1.0))
    sideways = program.multiply(strength, program.constant((1.0, 1.0, 0.0)))
    upwards = program.multiply(program.clamped(strength), program.constant((0.0, 0.0, 1.0)))
    moved = program.multiply(program.add("vector.SUBTRACT", colour, flat), program.add("vector.ADD", sideways, upwards))
    return program.add("vector.ADD", flat, moved)
