# SPDX-License-Identifier: GPL-3.0-or-later
"""Emissive meshes: where a material emits, the triangles that have it are a luminaire, too."""

import numpy as np

from .errors import ExportError
from .light_linking import LightLinking
from .materials import Materials
from .meshes import MeshArrays, read_mesh
from .visibility import role_of


class MeshLights:
    """The native scene's luminaires made of meshes."""

    def __init__(self, native_module, native_scene, materials: Materials, linking: LightLinking) -> None:
        self._module, self._scene, self._materials, self._linking = native_module, native_scene, materials, linking
        self._arrays: dict[int, MeshArrays] = {}

    def shines(self, instance) -> bool:
        """Whether an entry of depsgraph.object_instances whose object is a mesh gives light."""
        return any(e is None or any(e) for e in self._materials.emission_of_slots(instance.object))

    def add(self, instance, number: int | None) -> None:
        """Adds one entry of depsgraph.object_instances whose object is a mesh, and whose native instance is `number`.

        A luminaire for each constant radiance; what varies over the surface is looked up by the native renderer.
        """
        if number is None or not self.shines(instance):
            return
        evaluated_object = instance.object
        emissions = self._materials.emission_of_slots(evaluated_object)
        role = role_of(self._module, evaluated_object, self._linking)
        if not (role.diffuse or role.glossy):
            return
        if None in emissions:
            self._scene.add_textured_mesh_light(evaluated_object.name, number, role=role)
        constant = np.array([e or (0.0, 0.0, 0.0) for e in emissions])
        if not np.isfinite(constant).all():
            raise ExportError(f"object {evaluated_object.name!r}: the emission of a material is not a finite number")
        if not constant.any():
            return
        arrays = self._read(evaluated_object)
        slot_of = np.minimum(arrays.material_slots, len(constant) - 1)
        matrix = np.array(instance.matrix_world, dtype=np.float64)
        for radiance in np.unique(constant, axis=0):
            triangles = arrays.triangles[(constant == radiance).all(1)[slot_of]]
            if radiance.any() and len(triangles):
                self._scene.add_mesh_light(evaluated_object.name, arrays.positions, triangles, matrix, tuple(radiance),
                                           role=role)  # fmt: skip

    def _read(self, evaluated_object) -> MeshArrays:
        mesh = evaluated_object.data
        key = mesh.as_pointer()
        if key not in self._arrays:
            self._arrays[key] = read_mesh(evaluated_object.to_mesh() if mesh.is_editmode else mesh)
            if mesh.is_editmode:
                evaluated_object.to_mesh_clear()
        return self._arrays[key]
