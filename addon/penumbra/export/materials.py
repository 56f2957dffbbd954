# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials: the paper's BRDF where a material is no more than that (see brdf.py), else a program (see shader/).

One note per material says what was left out. As in Cycles, a material whose surface is not linked is black; what
an empty slot is depends on the version.
"""

from typing import NamedTuple

import numpy as np

from .. import compat
from ..notes import Notes
from .brdf import GREY, Brdf, Lobe, NotThePapers, combine, lobes_of
from .errors import ExportError
from .shader import AttributeNames, Compiler, Images, Shaders, default_surface
from .shader.compiler import UnsupportedNode, live_link, upstream_of
from .traits import Traits

MOST_SHADERS = 2048
NOT_REFLECTING = ("phong", "emission", "transparent", "holdout")


class Exported(NamedTuple):
    """A material in the native scene."""

    number: int
    attributes: frozenset[int] = frozenset()
    """Numbers of the attributes that it reads from meshes."""


def output_node(tree):
    return tree.get_output_node("CYCLES") or tree.get_output_node("EEVEE")


def paper_lobes(material) -> list[Lobe]:
    """The lobes of a material that is no more than the paper's BRDF, not yet checked; else NotThePapers is raised."""
    tree = compat.node_tree(material)
    if tree is None:
        return [Lobe("diffuse", np.array(material.diffuse_color)[:3], 0.0, material.name)]
    output = output_node(tree)
    return lobes_of(output.inputs["Surface"], 1.0) if output else []


def check_shaders(material) -> None:
    """Each way from the output to a shader is followed; where nodes join a shader with itself, they double."""
    tree = compat.node_tree(material)
    output = output_node(tree) if tree else None
    waiting = [(output.inputs["Surface"], ())] if output else []
    for _ in range(MOST_SHADERS):
        if not waiting:
            return
        socket, groups = waiting.pop()
        link = live_link(socket)
        if link is None:
            continue
        try:
            upstream = upstream_of(link.from_node, link.from_socket, groups)
        except UnsupportedNode:
            continue
        inner = [(s, groups) for s in link.from_node.inputs if s.type == "SHADER"]
        waiting += inner if upstream is None else [upstream]
    raise ExportError(f"material {material.name!r}: its nodes join shaders in more than {MOST_SHADERS} ways")


def check_finite(material, lobes: list[Lobe]) -> None:
    for lobe in lobes:
        if not np.isfinite(lobe.albedo).all():
            raise ExportError(f"material {material.name!r}: its colour is not a finite number")
        if not np.isfinite(lobe.exponent):
            raise ExportError(f"material {material.name!r}: its roughness is not a finite number")


class Materials:
    """The native scene's materials: each of Blender's is exported once; a view layer's `override` replaces them all."""

    def __init__(self, native_module, native_scene, notes: Notes, override, frame: int, traits: Traits,
                 attributes: AttributeNames | None = None) -> None:  # fmt: skip
        self._module, self._scene, self._notes, self._override = native_module, native_scene, notes, override
        self._traits = traits
        self._exported: dict[int, Exported] = {}
        self._default: Exported | None = None
        self._operations = frozenset(native_module.operations())
        self._images = Images(native_module, native_scene, frame)
        self.attributes = attributes or AttributeNames()
        self.attributes_of_all = traits.attributes(self.attributes)
        """Numbers of the attributes that are read from every mesh"""

    def of_slots(self, evaluated_object) -> list[Exported]:
        """An object's material slots, linked to the object or to its data; at least one."""
        if self._override is not None:
            return [self._of(self._override)]
        return [self._of(slot.material) for slot in evaluated_object.material_slots] or [self._of(None)]

    def emission_of_slots(self, evaluated_object) -> list[tuple[float, float, float] | None]:
        """Radiance of both sides of surfaces with each of these slots; None where it varies over them."""
        return [self._scene.emission_of(exported.number) for exported in self.of_slots(evaluated_object)]

    def _of(self, material) -> Exported:
        if material is None:
            if self._default is None:
                self._default = self._export_default("(no material)")
                self._traits.set_for_material(self._default.number, None)
            return self._default
        key = material.as_pointer()
        if key not in self._exported:
            self._exported[key] = self._export(material)
            self._traits.set_for_material(self._exported[key].number, material)
        return self._exported[key]

    def _export_default(self, name: str) -> Exported:
        if not compat.DEFAULT_SURFACE_IS_PRINCIPLED:
            return Exported(self._scene.add_material(name, diffuse=GREY))
        compiler = Compiler(name, self.attributes, self._images, [], self._operations)
        default_surface(compiler)
        return Exported(self._scene.add_program(name, **compiler.program.arrays()))

    def _export(self, material) -> Exported:
        try:
            check_shaders(material)
            return self._translate(material)
        except RecursionError:
            raise ExportError(f"material {material.name!r}: too many of its nodes are linked in a row") from None

    def _translate(self, material) -> Exported:
        issues: list[str] = []
        tree = compat.node_tree(material)
        output = output_node(tree) if tree else None
        if tree and not (output and output.inputs["Surface"].is_linked):
            issues.append("no shader is linked to its surface; rendered black")
        if output and output.inputs["Displacement"].is_linked:
            issues.append("Displacement not supported yet and ignored")
        try:
            lobes = paper_lobes(material)
        except NotThePapers:
            exported = self._program(material, output, issues)
        else:
            check_finite(material, lobes)
            brdf: Brdf = combine(lobes, issues)
            exported = Exported(self._scene.add_material(material.name, **brdf._asdict()))
        if issues:
            self._notes.add(f"material {material.name!r}: {'; '.join(dict.fromkeys(issues))}")
        return exported

    def _program(self, material, output, issues: list[str]) -> Exported:
        compiler = Compiler(material.name, self.attributes, self._images, issues, self._operations)
        Shaders(compiler).surface(output.inputs["Surface"])
        program = compiler.program
        if not np.isfinite(program.arrays()["registers"]).all():
            raise ExportError(f"material {material.name!r}: a value of its nodes is not a finite number")
        number = self._scene.add_program(
            material.name,
            **program.arrays(),
            grey_transparency=program.grey_transparency,
            facet_bumps=compat.BUMPS_ARE_FACETS,
        )
        if sum(kind not in NOT_REFLECTING for kind, *_ in program.closures) > self._module.MAX_LOBES:
            issues.append(f"only the first {self._module.MAX_LOBES} of its shaders reflect light")
        return Exported(number, frozenset(o[4] for o in program.operations if o[0] == "attribute"))
