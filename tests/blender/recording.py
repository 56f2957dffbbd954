# SPDX-License-Identifier: GPL-3.0-or-later
"""What the export handed to the native renderer, seen while a real render goes on."""

from types import SimpleNamespace

import numpy as np
from helpers import render_pixels
from penumbra import native, statistics


class Recording:
    """Stands for the native module: its Scene is the real one, with everything added to it noted down here."""

    def __init__(self, module) -> None:
        self._module = module
        self.meshes, self.instances, self.lights, self.materials = [], [], [], []
        self.camera = self.background = self.settings = None

    def __getattr__(self, name):
        return getattr(self._module, name)

    def Render(self, scene, settings):  # noqa: N802  (the native module's name)
        self.settings = settings
        return self._module.Render(scene, settings)

    def Scene(self):  # noqa: N802
        recording = self

        class Scene(self._module.Scene):
            def add_mesh(self, name, positions, triangles, corner_normals=None, material_slots=None, attributes=None):
                given = corner_normals
                if given is not None and given.ndim == 2:  # of vertices
                    corner_normals = given[triangles]
                recording.meshes.append(
                    SimpleNamespace(name=name, positions=positions, triangles=triangles, corner_normals=corner_normals,
                                    material_slots=material_slots, attributes=attributes or {})
                )  # fmt: skip
                return super().add_mesh(name, positions, triangles, given, material_slots, attributes or {})

            def add_material(self, name, diffuse, **lobes):
                recording.materials.append(SimpleNamespace(name=name, diffuse=diffuse, **lobes))
                return super().add_material(name, diffuse=diffuse, **lobes)

            def add_program(self, name, **program):
                recording.materials.append(SimpleNamespace(name=name, **program))
                return super().add_program(name, **program)

            def add_instance(self, name, mesh, matrix, materials, **visibility):
                recording.instances.append(
                    SimpleNamespace(name=name, mesh=mesh, matrix=matrix, materials=materials, **visibility)
                )
                return super().add_instance(name, mesh, matrix, materials, **visibility)

            def add_area_light(self, name, shape, matrix, size, radiance, cast_shadow, spread, role):
                recording.lights.append(
                    SimpleNamespace(name=name, shape=shape, matrix=matrix, size=size, radiance=radiance,
                                    cast_shadow=cast_shadow, spread=spread, role=role)
                )  # fmt: skip
                return super().add_area_light(name, shape, matrix, size, radiance, cast_shadow, spread, role)

            def add_point_light(self, name, matrix, radius, intensity, **shape):
                recording.lights.append(
                    SimpleNamespace(name=name, matrix=matrix, radius=radius, intensity=intensity, **shape)
                )
                return super().add_point_light(name, matrix, radius, intensity, **shape)

            def add_sun(self, name, to_sun, angle, irradiance, cast_shadow, role):
                recording.lights.append(
                    SimpleNamespace(name=name, to_sun=to_sun, angle=angle, irradiance=irradiance,
                                    cast_shadow=cast_shadow, role=role)
                )  # fmt: skip
                return super().add_sun(name, to_sun, angle, irradiance, cast_shadow, role)

            def add_mesh_light(self, name, positions, triangles, matrix, radiance, role):
                recording.lights.append(
                    SimpleNamespace(name=name, positions=positions, triangles=triangles, matrix=matrix,
                                    radiance=radiance, role=role)
                )  # fmt: skip
                return super().add_mesh_light(name, positions, triangles, matrix, radiance, role=role)

            def set_camera(self, kind, matrix, window, clip, aperture=None):
                recording.camera = SimpleNamespace(
                    kind=kind, matrix=matrix, window=window, clip=clip, aperture=aperture
                )
                return super().set_camera(kind, matrix, window, clip, aperture)

            def set_background(self, **background):
                recording.background = SimpleNamespace(**background)
                return super().set_background(**background)

        return Scene()

    def instances_of(self, name: str) -> list:
        return [instance for instance in self.instances if instance.name == name]

    def mesh_of(self, name: str):
        """The mesh of the one instance of this name."""
        (instance,) = self.instances_of(name)
        return self.meshes[instance.mesh]

    def world_positions(self, name: str) -> np.ndarray:
        """(V, 3) vertices of the one instance of this name, in world space."""
        (instance,) = self.instances_of(name)
        return self.mesh_of(name).positions @ instance.matrix[:3, :3].T + instance.matrix[:3, 3]


def record(scene, monkeypatch, lambertian: bool = True) -> Recording:
    """Renders `scene` with Penumbra and returns what was exported, with `pixels` and `notes` of the render.

    `lambertian`: see helpers.render_to_file.
    """
    recording = Recording(native.module)
    with monkeypatch.context() as patch:
        patch.setattr(native, "module", recording)
        recording.pixels = render_pixels(scene, lambertian=lambertian)
    recording.notes = statistics.last_render["warnings"]
    return recording
