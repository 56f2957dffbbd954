# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes -> closures of a program, each weighted by the Mix Shaders that it goes through."""

from ... import compat
from .compiler import Compiler, Place, UnsupportedNode, live_link, upstream_of
from .principled import add_diffuse, principled

GREY = (0.8, 0.8, 0.8)
GLOSSY = ("ShaderNodeBsdfGlossy", "ShaderNodeBsdfAnisotropic")  # the same node before and since Blender 4.0
REFLECTING = ("glossy", "correlated glossy", "beckmann", "clearcoat", "phong")
"""Closures that reflect light about a direction."""


class Shaders:
    """Adds the closures of a surface to a compiler's program."""

    def __init__(self, compiler: Compiler) -> None:
        self.compiler, self.program = compiler, compiler.program
        self._normals: list[int] = []

    def surface(self, socket) -> None:
        """Everything that feeds the Surface input of a material's output node."""
        self._follow(socket, (), self.program.constant(1.0))
        self._choose_normal()

    def _follow(self, socket, groups: tuple, weight: int) -> None:
        link = live_link(socket)
        if link is None or self.program.known(weight) == (0.0, 0.0, 0.0):
            return
        try:
            upstream = upstream_of(link.from_node, link.from_socket, groups)
        except UnsupportedNode:  # muted without a shader behind it, or an empty group
            return
        if upstream is not None:
            self._follow(*upstream, weight)
            return
        place = Place(link.from_node, groups)
        KINDS.get(place.node.bl_idname, Shaders._unknown)(self, place, weight)

    def _mix(self, place: Place, weight: int) -> None:
        factor = self.program.clamped(self.compiler.socket(place.node.inputs[0], place.groups))
        first, second = place.node.inputs[1:3]
        self._follow(first, place.groups, self.program.multiply(weight, self.program.one_minus(factor)))
        self._follow(second, place.groups, self.program.multiply(weight, factor))

    def _add(self, place: Place, weight: int) -> None:
        passing = []
        for socket in place.node.inputs[:2]:
            before = len(self.program.closures)
            self._follow(socket, place.groups, weight)
            colours = [colour for kind, colour, *_ in self.program.closures[before:] if kind == "transparent"]
            passing.append([self.program.known(colour) for colour in colours])
        added = passing[0] + passing[1]
        if all(passing) and (None in added or max(map(sum, zip(*added, strict=True))) > 1):
            self.compiler.note(place, "adds transparent shaders; in shadows no more than all light goes through")

    def _coloured(self, place: Place, weight: int, name: str = "Color") -> int:
        return self.program.multiply(weight, self.compiler.value(place, name))

    def _diffuse(self, place: Place, weight: int) -> None:
        self.use_normal(place)
        add_diffuse(self.program, weight, self.compiler.value(place, "Color"), self.compiler.value(place, "Roughness"))

    def _glossy(self, place: Place, weight: int) -> None:
        self.use_normal(place)
        distribution, colour = place.node.distribution, self.compiler.value(place, "Color")
        roughness = self.compiler.value(place, "Roughness")
        if distribution == "SHARP":
            self.program.add_closure("glossy", self.program.multiply(weight, colour))
        elif distribution == "ASHIKHMIN_SHIRLEY":
            self._phong(self.program.multiply(weight, colour), roughness)
        else:
            if distribution == "MULTI_GGX" and compat.PRINCIPLED_HAS_LAYERS:
                colour = self.program.add("multiple_scattering", colour, roughness, self.program.add("normal"))
            elif distribution == "MULTI_GGX":
                self.compiler.note(place, "multiple scattering is not supported in this version; rendered as GGX")
            colour = self.program.multiply(weight, colour)
            ggx = "correlated glossy" if compat.GGX_IS_CORRELATED else "glossy"
            self.program.add_closure("beckmann" if distribution == "BECKMANN" else ggx, colour, roughness)
        if self.compiler.is_linked(place, "Anisotropy") or self.program.known(
            self.compiler.value(place, "Anisotropy")
        ) != (0.0, 0.0, 0.0):
            self.compiler.note(place, "Anisotropy is not supported yet and ignored")

    def _phong(self, colour: int, roughness: int) -> None:
        """The paper's Phong lobe; see brdf.py for its width."""
        alpha_squared = self.program.math("POWER", self.program.clamped(roughness), 4.0)
        exponent = self.program.math("SUBTRACT", self.program.math("DIVIDE", 0.5, alpha_squared), 0.5)
        self.program.add_closure("phong", colour, exponent)

    def _emission(self, place: Place, weight: int) -> None:
        strength = self.compiler.value(place, "Strength")
        self.program.add_closure("emission", self.program.multiply(self._coloured(place, weight), strength))

    def _transparent(self, place: Place, weight: int) -> None:
        colour = self.program.known(self.compiler.value(place, "Color"))
        if colour is None or len(set(colour)) > 1:
            self.program.grey_transparency = False
        self.program.add_closure("transparent", self._coloured(place, weight))

    def _holdout(self, place: Place, weight: int) -> None:
        self.program.add_closure("holdout", weight)

    def _principled(self, place: Place, weight: int) -> None:
        self.use_normal(place)
        principled(self.compiler, place, weight)

    def _unknown(self, place: Place, weight: int) -> None:
        """Lambert's law with the node's colour, or 80 % grey if it has none."""
        has_colour = place.input("Color") is not None
        what = "its colour as diffuse" if has_colour else "80 % grey"
        self.compiler.note(place, f"is not supported yet; rendered with {what}")
        colour = self.compiler.value(place, "Color") if has_colour else self.program.constant(GREY)
        self.program.add_closure("diffuse", self.program.multiply(weight, colour))

    def use_normal(self, place: Place) -> None:
        self._normals.append(self.compiler.value(place, "Normal") if self.compiler.is_linked(place, "Normal") else 0)

    def _choose_normal(self) -> None:
        """A surface has one shading normal: the first one that bumps it, bent where a shader reflects."""
        different = list(dict.fromkeys(self._normals))
        normal = next((n for n in different if n), 0)
        reflects = any(kind in REFLECTING for kind, *_ in self.program.closures)
        if normal and (reflects or compat.DIFFUSE_NORMALS_REFLECT):
            normal = self.program.add("valid_reflection", normal)
        self.program.normal = normal
        if len(different) > 1:
            self.compiler.issues.append("its shaders differ in their normals; the first bumped one was used for all")


KINDS = {
    "ShaderNodeMixShader": Shaders._mix,
    "ShaderNodeAddShader": Shaders._add,
    "ShaderNodeBsdfDiffuse": Shaders._diffuse,
    "ShaderNodeEmission": Shaders._emission,
    "ShaderNodeBsdfTransparent": Shaders._transparent,
    "ShaderNodeHoldout": Shaders._holdout,
    "ShaderNodeBsdfPrincipled": Shaders._principled,
} | dict.fromkeys(GLOSSY, Shaders._glossy)
