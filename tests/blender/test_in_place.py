# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's arrays read in place: every element is what foreach_get gives, and nothing is read that is not laid out as
known."""

from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from penumbra import compat, in_place
from penumbra.export.meshes import read_mesh

SIDE = 40


def make_mesh(smooth=(), slots=1):
    """A bumpy grid of SIDE x SIDE quads and a triangle; face i is smooth where smooth[i % len(smooth)] says so."""
    x, y = (a.ravel() for a in np.meshgrid(np.linspace(0, 1, SIDE + 1), np.linspace(0, 1, SIDE + 1)))
    z = 0.2 * np.sin(9 * x) * np.cos(7 * y)
    corner = (np.arange(SIDE)[:, None] * (SIDE + 1) + np.arange(SIDE)).ravel()
    quads = np.stack([corner, corner + 1, corner + SIDE + 2, corner + SIDE + 1], axis=-1)
    mesh = bpy.data.meshes.new("Grid")
    mesh.from_pydata(np.stack([x, y, z], axis=-1).tolist(), [], [*quads.tolist(), [0, 5, 300]])
    if smooth:
        flags = np.resize(np.array(smooth, dtype=bool), len(mesh.polygons))
        mesh.polygons.foreach_set("use_smooth", flags)
    for slot in range(slots):
        mesh.materials.append(bpy.data.materials.new(f"Material {slot}"))
    mesh.polygons.foreach_set("material_index", np.arange(len(mesh.polygons), dtype=np.int32) % slots)
    mesh.uv_layers.new(name="UV").data.foreach_set("uv", np.linspace(0, 1, 2 * len(mesh.loops), dtype=np.float32))
    mesh.update()
    mesh.calc_loop_triangles()
    return mesh


def by_foreach_get(collection, name, kind, components):
    values = np.empty((len(collection), components), dtype=kind)
    collection.foreach_get(name, values.ravel())
    return values if components > 1 else values[:, 0]


def collections(mesh):
    """(collection, property, whether it is known to lie in memory in this version) of all that is read in place."""
    is_old = not hasattr(mesh, "loop_triangle_polygons")
    yield mesh.loops, "vertex_index", True
    yield mesh.loop_triangles, "loops", True
    yield mesh.uv_layers[0].data, "uv", True
    yield mesh.loop_triangles, "polygon_index", is_old
    yield mesh.attributes["material_index"].data, "value", True
    yield mesh.polygons, "use_smooth", is_old
    yield mesh.polygons, "loop_start", is_old
    yield mesh.polygons, "loop_total", is_old
    yield mesh.polygon_normals, "vector", True
    yield mesh.vertex_normals, "vector", True
    if not is_old:
        yield mesh.loop_triangle_polygons, "value", True
        yield mesh.corner_normals, "vector", True


def test_every_element_is_that_of_foreach_get(scene):
    mesh = make_mesh(smooth=(True, False, False), slots=3)
    for collection, name, is_known in collections(mesh):
        layout = in_place.LAYOUTS[name]
        found = in_place.view(collection, name)
        assert (found is not None) == is_known, name
        expected = by_foreach_get(collection, name, bool if layout.mask else layout.kind, layout.components)
        assert len(np.unique(expected)) > 1
        if found is not None:
            np.testing.assert_array_equal(found, expected, err_msg=name)
        np.testing.assert_array_equal(
            in_place.column(collection, name, layout.kind, layout.components), expected, err_msg=name
        )


@pytest.mark.parametrize("smooth", [(), (True,), (True, False, True)], ids=["flat", "smooth", "both"])
@pytest.mark.parametrize("slots", [1, 3])
def test_a_mesh_is_what_blender_says_it_is(scene, smooth, slots):
    """Against foreach_get of the loop triangles, and the normals that each version computes for face corners."""
    mesh = make_mesh(smooth, slots)
    arrays = read_mesh(mesh)
    triangles = by_foreach_get(mesh.loop_triangles, "vertices", np.int32, 3)
    np.testing.assert_array_equal(arrays.triangles, triangles)
    np.testing.assert_array_equal(arrays.positions, by_foreach_get(mesh.vertices, "co", np.float32, 3))
    np.testing.assert_array_equal(
        arrays.material_slots, by_foreach_get(mesh.loop_triangles, "material_index", np.int32, 1)
    )
    if not smooth:
        assert arrays.corner_normals is None
        return
    if hasattr(mesh, "calc_normals_split"):
        mesh.calc_normals_split()
    normals = np.array([loop.normal[:] for loop in mesh.loops], dtype=np.float32)
    corners = by_foreach_get(mesh.loop_triangles, "loops", np.int32, 3)
    found = arrays.corner_normals if arrays.corner_normals.ndim == 3 else arrays.corner_normals[triangles]
    np.testing.assert_allclose(found, normals[corners], atol=4e-6)  # single precision knows a sliver's angles to 3e-4


@pytest.mark.parametrize("auto_smooth", [False, True])
@pytest.mark.parametrize("smooth", [(True,), (True, False, True)], ids=["smooth", "both"])
def test_the_same_mesh_has_the_same_normals_bit_for_bit(scene, smooth, auto_smooth):
    """Blender before 4.1 adds them up by several threads in any order: without auto smooth no two of eight such spheres
    were the same on two cores, and render.py --checkpoint refused to go on."""
    found = set()
    for _ in range(8):
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=7)
        mesh = bpy.context.object.data
        positions = by_foreach_get(mesh.vertices, "co", np.float32, 3)
        positions += np.random.default_rng(1).uniform(-0.004, 0.004, positions.shape).astype(np.float32)
        mesh.vertices.foreach_set("co", positions.ravel())
        mesh.polygons.foreach_set("use_smooth", np.resize(np.array(smooth, dtype=bool), len(mesh.polygons)))
        mesh.update()
        if hasattr(mesh, "use_auto_smooth"):
            mesh.use_auto_smooth, mesh.auto_smooth_angle = auto_smooth, 0.5  # both sharp and smooth edges
        found.add(read_mesh(mesh).corner_normals.tobytes())
        bpy.data.meshes.remove(mesh)
    assert len(found) == 1


class Memory:
    """A collection that lies in an array of ours, laid out as we like."""

    def __init__(self, stride=12, count=1000, wrong_address=None, wrong_value=None) -> None:
        self.bytes = np.zeros(count * stride, dtype=np.uint8)
        self.values = np.arange(3 * count, dtype=np.float32).reshape(count, 3)
        rows = np.lib.stride_tricks.as_strided(self.bytes.view(np.float32), (count, 3), (stride, 4))
        rows[:] = self.values
        self.stride, self.count, self.wrong_address, self.wrong_value = stride, count, wrong_address, wrong_value

    def __len__(self):
        return self.count

    def __getitem__(self, i):
        address = self.bytes.ctypes.data + i * self.stride + (4 if i == self.wrong_address else 0)
        value = self.values[i] + (1 if i == self.wrong_value else 0)
        return SimpleNamespace(as_pointer=lambda: address, vector=value)

    def foreach_get(self, name, target):
        assert name == "vector"
        target[:] = self.values.ravel()


def test_only_known_layouts_are_read(monkeypatch):
    """Another stride, an element elsewhere, another value: memory is not even looked at but where all addresses fit."""
    memory = Memory()  # stays, since it is read in place
    found = in_place.view(memory, "vector")
    np.testing.assert_array_equal(found, memory.values)
    assert not found.flags.writeable
    for i in (0, 1, 500, 999):
        assert in_place.view(Memory(wrong_value=i), "vector") is None
    few = Memory(count=in_place.FEW - 1)
    monkeypatch.setattr(in_place.ctypes, "c_char", None)  # any look at memory fails from here on
    for collection in (Memory(stride=16), Memory(stride=20), few, *(Memory(wrong_address=i) for i in (0, 1, 500, 999))):
        assert in_place.view(collection, "vector") is None
        np.testing.assert_array_equal(in_place.column(collection, "vector", np.float32, 3), collection.values)
    assert in_place.view(Memory(), "unheard_of") is None


def test_an_index_beyond_an_array_is_refused():
    from penumbra import native

    gather = native.module.gather
    values = np.arange(12, dtype=np.float32).reshape(4, 3)
    indices = np.array([[3, 0], [1, 1]], dtype=np.int32)
    np.testing.assert_array_equal(gather(values, indices), values[indices])
    np.testing.assert_array_equal(gather(values[::2, 1], indices[1]), values[::2, 1][indices[1]])
    for wrong in (-1, 4):
        with pytest.raises(IndexError, match=f"index {wrong} in 4"):
            gather(values, np.array([0, wrong], dtype=np.int32))
    with pytest.raises(ValueError, match="four bytes"):
        gather(values.astype(float), indices)


def test_normals_that_are_neither_flat_nor_smooth_by_vertex(scene):
    """Auto smooth before Blender 4.1, custom normals in all: those of the corners, read by foreach_get or in place."""
    mesh = make_mesh(smooth=(True,))
    custom = np.tile(np.array([[0.6, 0.0, 0.8]], dtype=np.float32), (len(mesh.loops), 1))
    mesh.normals_split_custom_set(custom.tolist())
    if hasattr(mesh, "use_auto_smooth"):
        mesh.use_auto_smooth = True
    domain, normals = compat.normals(mesh)
    assert domain == "CORNER"
    np.testing.assert_allclose(normals, custom, atol=0.02)  # kept as angles in 16 bits, from a normal nearby
