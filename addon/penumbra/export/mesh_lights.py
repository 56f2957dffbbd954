# SPDX-License-Identifier: GPL-3.0-or-later
"""Emissive meshes: where a material emits, the triangles that have it are a luminaire, too."""

import numpy as np

from ..notes import Notes
from .emission import emission_of
from .errors import ExportError
from .light_linking import LightLinking
from .meshes import MeshArrays, read_mesh
from .visibility import role_of


class MeshLights:
    """The native scene's luminaires made of meshes; a view layer's `override` replaces all materials."""

    def __init__(self, native_module, native_scene, notes: Notes, linking: LightLinking, override=None) -> None:
        self._module, self._scene, self._notes, self._linking = native_module, native_scene, notes, linking
        self._override = override
        self._emissions: dict[int, np.ndarray] = {}
        self._arrays: dict[int, MeshArrays] = {}

    def add(self, instance) -> bool:
        """Adds one entry of depsgraph.object_instances whose object is a mesh: a luminaire for each radiance. Whether
        there are any."""
        evaluated_object = instance.object
        slots = [self._override or slot.material for slot in evaluated_object.material_slots] or [self._override]
        emissions = np.array([self._emission(material) for material in slots])
        role = role_of(self._module, evaluated_object, self._linking)
        if not emissions.any() or not (role.diffuse or role.glossy):
            return False
        arrays = self._read(evaluated_object)
        slot_of = np.minimum(arrays.material_slots, len(slots) - 1)
        matrix = np.array(instance.matrix_world, dtype=np.float64)
        for radiance in np.unique(emissions, axis=0):
            triangles = arrays.triangles[(emissions == radiance).all(1)[slot_of]]
            if radiance.any() and len(triangles):
                self._scene.add_mesh_light(evaluated_object.name, arrays.positions, triangles, matrix, tuple(radiance),
                                           role=role)  # fmt: skip
        return True

    def _emission(self, material) -> np.ndarray:
        if material is None:
            return np.zeros(3)
        key = material.as_pointer()
        if key not in self._emissions:
            issues: list[str] = []
            radiance = emission_of(material, issues)
            if not np.isfinite(radiance).all():
                raise ExportError(f"material {material.name!r}: its emission is not a finite number")
            if issues:
                self._notes.add(f"material {material.name!r}: {'; '.join(dict.fromkeys(issues))}")
            self._emissions[key] = radiance
        return self._emissions[key]

    def _read(self, evaluated_object) -> MeshArrays:
        mesh = evaluated_object.data
        key = mesh.as_pointer()
        if key not in self._arrays:
            self._arrays[key] = read_mesh(evaluated_object.to_mesh() if mesh.is_editmode else mesh)
            if mesh.is_editmode:
                evaluated_object.to_mesh_clear()
        return self._arrays[key]
