# SPDX-License-Identifier: GPL-3.0-or-later
"""Mesh-like objects: each evaluated mesh is exported once, each place it appears in is an instance of it."""

from typing import NamedTuple

import numpy as np

from .. import compat, in_place, native
from ..notes import Notes
from .kept import Kept
from .light_linking import LightLinking
from .materials import Exported, Materials
from .shader import at_corners
from .visibility import rays_of


class MeshArrays(NamedTuple):
    """A mesh in object space, as the native scene takes it."""

    positions: np.ndarray
    """(V, 3) float32"""
    triangles: np.ndarray
    """(T, 3) int32, indices of vertices"""
    corner_normals: np.ndarray | None
    """(T, 3, 3) float32, one at each corner of each triangle; (V, 3) where those at a vertex share one; None: flat"""
    material_slots: np.ndarray
    """(T,) int32"""


def read_mesh(mesh) -> MeshArrays:
    """Copies an evaluated mesh into arrays."""
    gather = native.require().gather
    mesh.calc_loop_triangles()
    positions = np.empty((len(mesh.vertices), 3), dtype=np.float32)
    mesh.vertices.foreach_get("co", positions.ravel())
    corners = in_place.column(mesh.loop_triangles, "loops", np.int32, 3)
    triangles = gather(in_place.column(mesh.loops, "vertex_index", np.int32), corners)
    has_slots = len(mesh.materials) > 1  # with a single slot its material is that of all triangles
    material_slots = compat.triangle_slots(mesh) if has_slots else np.zeros(len(triangles), dtype=np.int32)
    corner_normals = None
    if len(triangles) and (found := compat.normals(mesh)):
        domain, normals = found
        corner_normals = normals if domain == "POINT" else gather(normals, corners)
    return MeshArrays(positions, triangles, corner_normals, material_slots)


def unsupported(evaluated_object) -> list[str]:
    """What an object asks for that Penumbra leaves out."""
    found = ["shadow catcher"] if getattr(evaluated_object, "is_shadow_catcher", False) else []
    return found


class Meshes:
    """The native scene's meshes and instances."""

    def __init__(self, native_module, native_scene, materials: Materials, notes: Notes, linking: LightLinking,
                 kept: Kept | None = None) -> None:  # fmt: skip
        self._module, self._scene, self._notes = native_module, native_scene, notes
        self._materials, self._linking, self._kept = materials, linking, kept
        self._mesh_ids: dict[tuple[int, frozenset[int]], int | None] = {}
        self._slots: dict[tuple[int, int], list[Exported]] = {}

    def add(self, instance, matrix: np.ndarray, motion=None) -> int | None:
        """Adds one entry of depsgraph.object_instances whose object is a mesh, placed by a (4, 4) matrix.

        Returns the native instance's number, None if there is nothing of it.

        The key is the evaluated mesh: Blender gives all instances, and all objects that share a mesh and do not modify
        it, the same one. Its materials may still differ by object (slots linked to the object); where they read other
        attributes, the mesh is exported once more.
        """
        evaluated_object = instance.object
        slots_key = evaluated_object.data.as_pointer(), evaluated_object.original.as_pointer()
        if slots_key not in self._slots:
            self._slots[slots_key] = self._materials.of_slots(evaluated_object)
            if found := unsupported(evaluated_object):
                self._notes.add(f"object {evaluated_object.name!r}: {', '.join(found)} not supported yet and ignored")
        slots = self._slots[slots_key]
        mesh_key = slots_key[0], self._materials.attributes_of_all.union(*(slot.attributes for slot in slots))
        if mesh_key not in self._mesh_ids:
            self._mesh_ids[mesh_key] = self._export(instance, mesh_key, motion)
        mesh_id = self._mesh_ids[mesh_key]
        if mesh_id is None:
            return None
        return self._scene.add_instance(evaluated_object.name, mesh_id, matrix, [slot.number for slot in slots],
                                 rays=rays_of(self._module, instance, self._linking),
                                 receiver_set=self._linking.receiver_set(instance),
                                 **({"motion": motion.matrices(instance)} if motion else {}))  # fmt: skip

    def _export(self, instance, key: tuple[int, frozenset[int]], motion) -> int | None:
        """The native id of an object's mesh with the attributes of a key, None if it has no triangles."""
        evaluated_object = instance.object
        name = evaluated_object.name
        if motion and motion.may_deform(instance):
            arrays = self._read(evaluated_object, key[1])
            if arrays is None:
                return None
            shapes = motion.shapes(instance, MeshArrays(*arrays[1:5]))
            normals = [shape.corner_normals for shape in shapes if shape.corner_normals is not None]
            return self._scene.add_mesh(*arrays, position_motion=[shape.positions for shape in shapes],
                                        normal_motion=normals)  # fmt: skip
        if self._kept is None:
            arrays = self._read(evaluated_object, key[1])
            return self._scene.add_mesh(*arrays) if arrays else None
        mesh = self._kept.mesh(key, lambda: self._read(evaluated_object, key[1]))
        return self._scene.add_kept_mesh(name, mesh) if mesh else None

    def _read(self, evaluated_object, attributes: frozenset[int]) -> tuple | None:
        """The arguments of add_mesh for an object's mesh, None if it has no triangles.

        Read in place, not through to_mesh(): on the temporary objects that stand for geometry nodes' instances
        to_mesh() leaks. Only an object in edit mode needs it, as its mesh is still in the editor's own form.
        """
        mesh = evaluated_object.data
        is_edited = mesh.is_editmode
        mesh = evaluated_object.to_mesh() if is_edited else mesh
        arrays = read_mesh(mesh)
        values = self._attributes(evaluated_object, mesh, attributes, arrays.triangles)
        if is_edited:
            evaluated_object.to_mesh_clear()
        return (evaluated_object.name, *arrays, values) if len(arrays.triangles) else None

    def _attributes(self, evaluated_object, mesh, wanted: frozenset[int], triangles) -> dict[int, np.ndarray]:
        """What the materials read of a mesh, at the corners of its triangles; what it has not got is left out."""
        found = {}
        for number in sorted(wanted):
            name = self._materials.attributes.names[number]
            try:
                values = at_corners(mesh, name, triangles)
            except ValueError as problem:
                self._notes.add(f"object {evaluated_object.name!r}: {name.strip()!r}: {problem}")
                continue
            if values is not None:
                found[number] = values
        return found
