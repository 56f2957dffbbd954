# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials that are no more than the paper's BRDF: ideal diffuse + one Phong lobe + mirror, without textures.

Diffuse BSDFs, Glossy BSDFs that are mirrors or have the distribution Ashikhmin-Shirley, and Mix and Add Shader over
them, all with constants.

A Glossy BSDF is a mirror where Cycles takes it for one. Ashikhmin-Shirley is the distribution nearest to the paper's
Phong lobe: a Blinn-Phong lobe of exponent 2 / alpha^2 - 2 in the half-vector's angle, alpha being the square of
Blender's roughness (Walter et al. 2007, eq. 37). That is half the angle to the mirror direction, so Phong's exponent is
a quarter of it: 1 / (2 alpha^2) - 1/2.
"""

from typing import NamedTuple

import numpy as np

from .shader.compiler import live_link

GREY = (0.8, 0.8, 0.8)
GLOSSY = ("ShaderNodeBsdfGlossy", "ShaderNodeBsdfAnisotropic")  # the same node before and since Blender 4.0
MIRROR_ALPHA_SQUARED = 1e-7
"""At and below it Cycles' microfacets are a mirror (BSDF_ROUGHNESS_SQ_THRESH, 3.4)."""
ROUNDING = 1e-6
"""Albedos may add up to that much above 1, as in the native scene."""


class NotThePapers(Exception):
    """A material is more than the paper's BRDF."""


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


def constant(socket):
    """A socket's value, its own or that of an RGB or Value node; NotThePapers if something else is linked to it, or a
    colour to a number or the other way round."""
    node = node_at(socket)
    if node is None:
        return socket.default_value
    if node.bl_idname not in ("ShaderNodeRGB", "ShaderNodeValue") or node.mute:
        raise NotThePapers
    value = node.outputs[0].default_value
    if np.shape(value) != np.shape(socket.default_value):
        raise NotThePapers
    return value


def node_at(socket):
    """The node linked to an input socket, through reroutes; None without one."""
    link = live_link(socket)
    while link is not None and link.from_node.bl_idname == "NodeReroute":
        link = live_link(link.from_node.inputs[0])
    return link.from_node if link else None


def lobes_of(socket, weight: float) -> list[Lobe]:
    """The lobes of what is linked to a shader socket. NotThePapers if that is more than the paper has."""
    node = node_at(socket)
    if node is None or weight == 0:
        return []
    if node.mute:
        raise NotThePapers
    if node.bl_idname == "ShaderNodeMixShader":
        factor = min(max(constant(node.inputs[0]), 0.0), 1.0)
        return lobes_of(node.inputs[1], weight * (1 - factor)) + lobes_of(node.inputs[2], weight * factor)
    if node.bl_idname == "ShaderNodeAddShader":
        return [lobe for one in node.inputs[:2] for lobe in lobes_of(one, weight)]
    if node.bl_idname not in ("ShaderNodeBsdfDiffuse", *GLOSSY) or node.inputs["Normal"].is_linked:
        raise NotThePapers
    albedo = weight * np.array(constant(node.inputs["Color"]))[:3]
    roughness = constant(node.inputs["Roughness"])
    if node.bl_idname == "ShaderNodeBsdfDiffuse":
        if roughness > 0:
            raise NotThePapers
        return [Lobe("diffuse", albedo, 0.0, node.name)]
    if "Anisotropy" in node.inputs and (node.inputs["Anisotropy"].is_linked or node.inputs["Anisotropy"].default_value):
        raise NotThePapers
    exponent = None if node.distribution == "SHARP" else phong_exponent(roughness)
    if exponent is not None and node.distribution != "ASHIKHMIN_SHIRLEY":
        raise NotThePapers
    return [Lobe("mirror" if exponent is None else "phong", albedo, exponent or 0.0, node.name)]


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
