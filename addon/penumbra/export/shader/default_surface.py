# SPDX-License-Identifier: GPL-3.0-or-later
"""What stands for a material where an object has none: from Blender 5.0 on a Principled BSDF nobody has touched."""

from types import SimpleNamespace
from typing import NamedTuple

from .compiler import Compiler, Place
from .principled import layers

UNTOUCHED = {
    "Base Color": (0.8, 0.8, 0.8), "Roughness": 0.5, "IOR": 1.5, "Specular IOR Level": 0.5,
    "Specular Tint": (1.0, 1.0, 1.0), "Coat Roughness": 0.03, "Coat IOR": 1.5, "Coat Tint": (1.0, 1.0, 1.0),
    "Emission Color": (1.0, 1.0, 1.0),
}  # fmt: skip
"""Cycles' values of a new Principled BSDF; what is not here is 0 (test_against_cycles_materials.py)."""


class Socket(NamedTuple):
    """An input that is not linked."""

    default_value: float | tuple[float, float, float]
    links: tuple = ()


class Untouched(Place):
    """No node stands behind it: none may be made while Blender renders."""

    def input(self, name: str) -> Socket | None:
        return Socket(UNTOUCHED[name]) if name in UNTOUCHED else None


def default_surface(compiler: Compiler) -> None:
    """Adds the closures of the surface of an object without material."""
    node = SimpleNamespace(name="Principled BSDF", distribution="MULTI_GGX")
    layers(compiler, Untouched(node), compiler.program.constant(1.0))
