# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials: each becomes the paper's BRDF (see brdf.py), and one note per material says what was left out.

As in Cycles, a material whose surface is not linked is black, an empty slot grey.
"""

import numpy as np

from .. import compat
from ..notes import Notes
from .brdf import GREY, Brdf, Lobe, combine, lobes_of
from .errors import ExportError
from .nodes import follow


def surface_lobes(material, issues: list[str]) -> list[Lobe]:
    """The lobes of a material's surface, not yet checked; what was left out is added to `issues`."""
    tree = compat.node_tree(material)
    if tree is None:
        return [Lobe("diffuse", np.array(material.diffuse_color)[:3], 0.0, material.name)]
    output = tree.get_output_node("CYCLES") or tree.get_output_node("EEVEE")
    surface = follow(output.inputs["Surface"]) if output else None
    if surface is None:
        issues.append("no shader is linked to its surface; rendered black")
        return []
    lobes = lobes_of(surface, 1.0, issues)
    if output.inputs["Displacement"].is_linked:
        issues.append("Displacement not supported yet and ignored")
    return lobes


class Materials:
    """The native scene's materials: each of Blender's is exported once; a view layer's `override` replaces them all."""

    def __init__(self, native_scene, notes: Notes, override=None) -> None:
        self._scene, self._notes, self._override = native_scene, notes, override
        self._ids: dict[int, int] = {}
        self._default: int | None = None

    def of_slots(self, evaluated_object) -> list[int]:
        """Native ids of an object's material slots, linked to the object or to its data; at least one."""
        if self._override is not None:
            return [self._id(self._override)]
        return [self._id(slot.material) for slot in evaluated_object.material_slots] or [self._id(None)]

    def _id(self, material) -> int:
        if material is None:
            if self._default is None:
                self._default = self._scene.add_material("(no material)", diffuse=GREY)
            return self._default
        key = material.as_pointer()
        if key not in self._ids:
            self._ids[key] = self._export(material)
        return self._ids[key]

    def _export(self, material) -> int:
        issues: list[str] = []
        brdf = self._brdf(material, issues)
        if issues:
            self._notes.add(f"material {material.name!r}: {'; '.join(dict.fromkeys(issues))}")
        return self._scene.add_material(material.name, **brdf._asdict())

    def _brdf(self, material, issues: list[str]) -> Brdf:
        lobes = surface_lobes(material, issues)
        for lobe in lobes:
            if not np.isfinite(lobe.albedo).all():
                raise ExportError(f"material {material.name!r}: its colour is not a finite number")
            if not np.isfinite(lobe.exponent):
                raise ExportError(f"material {material.name!r}: its roughness is not a finite number")
        return combine(lobes, issues)
