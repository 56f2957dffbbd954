# SPDX-License-Identifier: GPL-3.0-or-later
"""Attributes of meshes that materials read: UV maps, colours, generated coordinates, tangents. Only what is asked for.

Names that no attribute can have in Blender (they begin with a line break) stand for what is not an attribute there.
"""

import numpy as np

from ... import compat

DEFAULT_UV = "\nuv"
"""The UV map that is active for rendering."""
DEFAULT_COLOUR = "\ncolour"
"""The colour attribute that is active for rendering."""
GENERATED = "\ngenerated"
"""0 ... 1 over the mesh's own bounds (its texture space), before deformation."""
TANGENT = "\ntangent"
"""Before the name of a UV map: its tangents, with the bitangent's sign as fourth component."""

COMPONENTS = {"FLOAT": ("value", 1), "INT": ("value", 1), "INT8": ("value", 1), "BOOLEAN": ("value", 1),
              "FLOAT2": ("vector", 2), "FLOAT_VECTOR": ("vector", 3), "FLOAT_COLOR": ("color", 4),
              "BYTE_COLOR": ("color", 4)}  # fmt: skip
"""Property and number of components of an attribute's elements, by its data type."""


def tangent_name(uv_map: str) -> str:
    return TANGENT + (uv_map or DEFAULT_UV)


class AttributeNames:
    """Numbers of the attributes that the scene's materials ask for."""

    def __init__(self) -> None:
        self.names: list[str] = []

    def number(self, name: str) -> int:
        if name not in self.names:
            self.names.append(name)
        return self.names.index(name)


def elements(collection, name: str, components: int, kind=np.float32) -> np.ndarray:
    """(N, components) of a property of Blender's collections."""
    values = np.empty((len(collection), components), dtype=kind)
    collection.foreach_get(name, values.ravel())
    return values.astype(np.float32, copy=False)


def uv_layer(mesh, name: str):
    if name == DEFAULT_UV:
        return next((layer for layer in mesh.uv_layers if layer.active_render), None)
    return mesh.uv_layers.get(name)


def generated(mesh) -> np.ndarray:
    """(V, 3) generated coordinates."""
    size = np.array(mesh.texspace_size)
    size[size == 0] = 0.5
    return (elements(mesh.vertices, "undeformed_co", 3) - np.array(mesh.texspace_location)) / (2 * size) + 0.5


def tangents(mesh, uv_map: str) -> np.ndarray:
    """(loops, 4) tangents of a UV map and signs of their bitangents; ValueError where Blender makes none."""
    layer = uv_layer(mesh, uv_map)
    if layer is None:
        raise ValueError("it has no such UV map")
    try:
        mesh.calc_tangents(uvmap=layer.name)
    except RuntimeError as error:
        raise ValueError("Blender makes tangents of triangles and quads only") from error
    try:
        return np.hstack([elements(mesh.loops, "tangent", 3), elements(mesh.loops, "bitangent_sign", 1)])
    finally:
        mesh.free_tangents()


def read(mesh, name: str) -> tuple[str, np.ndarray] | None:
    """(domain, (N, 1 to 4) values) of an attribute; None if the mesh has none of this name. ValueError if it cannot be
    had."""
    if name == GENERATED:
        return "POINT", generated(mesh)
    if name.startswith(TANGENT):
        return "CORNER", tangents(mesh, name[len(TANGENT) :])
    layer = uv_layer(mesh, name)
    if layer is not None:
        return "CORNER", elements(layer.data, "uv", 2)
    found = compat.render_colour(mesh) if name == DEFAULT_COLOUR else mesh.attributes.get(name)
    if found is None:
        return None
    if found.data_type not in COMPONENTS or found.domain not in ("POINT", "CORNER", "FACE"):
        raise ValueError(f"{found.data_type} on {found.domain} is not supported yet")
    return found.domain, elements(found.data, *COMPONENTS[found.data_type])


def at_corners(mesh, name: str, triangles: np.ndarray) -> np.ndarray | None:
    """(T, 3, 4) float32 at the corners of the mesh's (T, 3) triangles; None if there is no such attribute. A number is
    repeated, a missing third component 0, a missing fourth 1."""
    found = read(mesh, name)
    if found is None:
        return None
    domain, values = found
    if domain == "POINT":
        at = triangles
    elif domain == "CORNER":
        at = np.empty_like(triangles)
        mesh.loop_triangles.foreach_get("loops", at.ravel())
    else:
        at = np.empty(len(triangles), dtype=np.int32)
        mesh.loop_triangles.foreach_get("polygon_index", at)
        at = at[:, None].repeat(3, axis=1)
    full = np.zeros((*triangles.shape, 4), dtype=np.float32)
    full[..., 3] = 1.0
    components = values.shape[1]
    full[..., : max(components, 3) if components == 1 else components] = values[at]
    return full
