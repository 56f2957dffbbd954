# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes -> the paper's BRDF: ideal diffuse + one Phong lobe + mirror.

Diffuse, Glossy and Principled BSDF (of which the base colour counts), and Mix and Add Shader over them; a shader of
another kind is replaced by the first Diffuse or Principled BSDF that feeds it, and by 80 % grey if there is none.

A Glossy BSDF is a mirror where Cycles takes it for one, else a Phong lobe as wide as Cycles' microfacets: a
distribution of roughness alpha (the square of Blender's slider) resembles a Blinn-Phong lobe of exponent
2 / alpha^2 - 2 (Walter et al. 2007, eq. 37) in the half-vector's angle. That is half the angle to the mirror direction,
so Phong's exponent is a quarter of it: 1 / (2 alpha^2) - 1/2.
"""

from typing import NamedTuple

import numpy as np

from .nodes import follow, socket_colour, socket_value

GREY = (0.8, 0.8, 0.8)
COLOUR_SOCKETS = {"ShaderNodeBsdfDiffuse": "Color", "ShaderNodeBsdfPrincipled": "Base Color"}
GLOSSY = ("ShaderNodeBsdfGlossy", "ShaderNodeBsdfAnisotropic")  # the same node before and since Blender 4.0
NEUTRAL_VALUES = {"Alpha": 1.0, "Metallic": 0.0, "Anisotropy": 0.0} | {
    name + suffix: 0.0
    for name in ("Subsurface", "Transmission", "Sheen", "Clearcoat", "Coat")
    for suffix in ("", " Weight")
}
"""Sockets of the BSDFs that change the picture unless they have this value, under their names in all versions."""
MIRROR_ALPHA_SQUARED = 1e-7
"""At and below it Cycles' microfacets are a mirror (BSDF_ROUGHNESS_SQ_THRESH, 3.4)."""
ROUNDING = 1e-6
"""Albedos may add up to that much above 1, as in the native scene."""


class Lobe(NamedTuple):
    """A part of a material's BRDF: "diffuse", "phong" or "mirror", its albedo (r, g, b), exponent and node's name."""

    kind: str
    albedo: np.ndarray
    exponent: float
    node: str


class Brdf(NamedTuple):
    """Albedos (r, g, b) that add up to at most 1, and the exponent of the Phong lobe."""

    diffuse: tuple[float, float, float]
    phong: tuple[float, float, float]
    mirror: tuple[float, float, float]
    phong_exponent: float


def phong_exponent(roughness: float) -> float | None:
    """The exponent of a Phong lobe as wide as Cycles' microfacets of this roughness; None for a mirror."""
    alpha_squared = min(max(roughness, 0.0), 1.0) ** 4
    return None if alpha_squared <= MIRROR_ALPHA_SQUARED else 0.5 / alpha_squared - 0.5


def lobes_of(node, weight: float, issues: list[str]) -> list[Lobe]:
    """The lobes of what a shader node (None: nothing) adds to a surface; what was left out is added to `issues`."""
    if node is None or weight == 0:
        return []
    if node.bl_idname == "ShaderNodeMixShader" and not node.mute:
        factor = min(max(socket_value(node.inputs[0], issues), 0.0), 1.0)
        first, second = (follow(socket) for socket in node.inputs[1:3])
        return lobes_of(first, weight * (1 - factor), issues) + lobes_of(second, weight * factor, issues)
    if node.bl_idname == "ShaderNodeAddShader" and not node.mute:
        return [lobe for socket in node.inputs[:2] for lobe in lobes_of(follow(socket), weight, issues)]
    if node.bl_idname in GLOSSY and not node.mute:
        note_ignored(node, issues)
        albedo = weight * np.array(socket_colour(node.inputs["Color"], issues))
        exponent = None
        if node.distribution != "SHARP":
            exponent = phong_exponent(socket_value(node.inputs["Roughness"], issues))
        return [Lobe("mirror" if exponent is None else "phong", albedo, exponent or 0.0, node.name)]
    bsdf = first_diffuse(node)
    if bsdf is None:
        issues.append(f"node {node.name!r} is not supported yet; rendered as 80 % grey")
        return [Lobe("diffuse", weight * np.array(GREY), 0.0, node.name)]
    if bsdf != node:
        issues.append(f"node {node.name!r} is not supported yet; the colour of {bsdf.name!r} was used")
    note_ignored(bsdf, issues)
    colour = socket_colour(bsdf.inputs[COLOUR_SOCKETS[bsdf.bl_idname]], issues)
    return [Lobe("diffuse", weight * np.array(colour), 0.0, bsdf.name)]


def combine(lobes: list[Lobe], issues: list[str]) -> Brdf:
    """One BRDF of lobes with finite albedos, which the native scene accepts.

    Phong lobes of different exponents become one with that of the strongest. Albedos that add up to more than 1 are
    scaled down, channel by channel.
    """
    phong = sorted((lobe for lobe in lobes if lobe.kind == "phong"), key=lambda lobe: -lobe.albedo.sum())
    if any(not np.isclose(lobe.exponent, phong[0].exponent) for lobe in phong):
        issues.append(f"its glossy nodes differ in roughness; that of {phong[0].node!r} was used for all")
    total = {kind: sum((lobe.albedo for lobe in lobes if lobe.kind == kind), np.zeros(3))
             for kind in ("diffuse", "phong", "mirror")}  # fmt: skip
    kept = {kind: np.maximum(albedo, 0.0) for kind, albedo in total.items()}
    sums = sum(kept.values())
    too_much = sums > 1 + ROUNDING
    if sum(map(np.any, kept.values())) > 1 and too_much.any():
        issues.append("its albedos add up to more than 1 and were scaled down")
    elif too_much.any() or any((albedo < 0).any() for albedo in total.values()):
        issues.append("its colour was clamped to 0 ... 1")
    scale = np.where(too_much, 1 / np.maximum(sums, 1), 1.0)
    albedos = (tuple(float(c) for c in kept[kind] * scale) for kind in ("diffuse", "phong", "mirror"))
    return Brdf(*albedos, phong[0].exponent if phong else 0.0)


def first_diffuse(node):
    """The Diffuse or Principled BSDF nearest to a shader node, against the flow, into groups; None if there is none."""
    queue, seen = [node], set()
    while queue:
        node = queue.pop(0)
        if node.as_pointer() in seen:
            continue
        seen.add(node.as_pointer())
        if node.bl_idname in COLOUR_SOCKETS and not node.mute:
            return node
        if node.bl_idname == "ShaderNodeGroup" and node.node_tree:
            queue += [inner for inner in node.node_tree.nodes if inner.bl_idname == "NodeGroupOutput"]
        queue += filter(None, (follow(socket) for socket in node.inputs if socket.type == "SHADER"))
    return None


def note_ignored(bsdf, issues: list[str]) -> None:
    """Adds to `issues` the sockets of a BSDF that ask for more than is rendered."""
    names = [
        name
        for name, neutral in NEUTRAL_VALUES.items()
        if (socket := bsdf.inputs.get(name)) and (socket.is_linked or socket.default_value != neutral)
    ]
    if bsdf.bl_idname == "ShaderNodeBsdfDiffuse" and bsdf.inputs["Roughness"].default_value != 0:
        names.append("Roughness")
    if bsdf.inputs["Normal"].is_linked:
        names.append("Normal")
    emission = bsdf.inputs.get("Emission Color") or bsdf.inputs.get("Emission")
    strength = bsdf.inputs.get("Emission Strength")
    shines = emission and (strength.is_linked or strength.default_value != 0)
    if shines and (emission.is_linked or any(emission.default_value[:3])):
        names.append(emission.name)
    if names:
        issues.append(f"{', '.join(names)} of {bsdf.name!r} not supported yet and ignored")
