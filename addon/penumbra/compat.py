# SPDX-License-Identifier: GPL-3.0-or-later
"""All that differs between the Blender versions Penumbra runs in (3.4 to 5.2). No other file asks for the version."""

import bl_ui.properties_view_layer
import bpy
import numpy as np

from . import in_place, native

AREA_LIGHT_WATTS_OVER_FOUR_AREAS = bpy.app.version < (4, 0, 0)
"""The radiance of an area light of power P and area A: P / (4 A) before Blender 4.0, P / (pi A) since."""

SPOT_HAS_COSINE = bpy.app.version < (4, 0, 0)
"""Before Blender 4.0 a spot fades with the cosine to its axis, too."""

SPOT_IGNORES_SCALE = bpy.app.version < (4, 0, 0)
"""Since Blender 4.0 the object's scale widens a spot's cone."""

ORTHOGRAPHIC_LENS_AT_CLIP_START = bpy.app.version < (4, 0, 0)
"""The lens of an orthographic camera is in the plane of its clip start, later in the camera's own."""

SUN_IS_FLAT = bpy.app.version < (4, 0, 0)
"""Before Blender 4.0 the sun is a flat disk with the whole strength, since then a cap that shines as strong on a
surface that faces it."""

PRINCIPLED_HAS_LAYERS = bpy.app.version >= (4, 0, 0)
"""The Principled BSDF is made of layers since Blender 4.0, of Burley's closures before."""

DEFAULT_SURFACE_IS_PRINCIPLED = bpy.app.version >= (5, 0, 0)
"""What has no material is rendered with an untouched Principled BSDF since Blender 5.0, 80 % grey before."""

ROUGH_DIFFUSE_KEEPS_ENERGY = bpy.app.version >= (4, 3, 0)
"""Cycles' rough diffuse has light that bounces between its facets since Blender 4.3."""

NORMAL_MAP_BENDS_COLOUR = bpy.app.version >= (4, 3, 0)
"""The strength of a normal map in tangent space acts on the colour (seen in 4.3.2), before that on the normal."""

DIFFUSE_NORMALS_REFLECT = bpy.app.version < (4, 3, 0)
"""Every bumped normal is bent until the viewer's mirror direction leaves the surface; later for glossy shaders only."""

BUMPS_ARE_FACETS = bpy.app.version >= (4, 5, 0)
"""How light fades where a diffuse surface is bumped: Conty et al. 2019 since Blender 4.5, before Chiang et al. 2019."""

RAMP_TABLE_SIZE = 257 if bpy.app.version >= (4, 0, 0) else 256
"""Places at which Cycles evaluates ramps and curves (measured in 3.4.1, 4.3.2 and 5.2.2)."""

GGX_IS_CORRELATED = bpy.app.version >= (3, 5, 0)
"""Cycles' microfacets know of masking and shadowing together since Blender 3.5."""

PASSES_HAVE_SHORT_NAMES = bpy.app.version < (5, 0, 0)
"""Before Blender 5.0 some passes have short names; since then all have those that the native renderer has, too."""

SHORT_PASS_NAMES = {
    "Diffuse Direct": "DiffDir", "Diffuse Color": "DiffCol", "Glossy Direct": "GlossDir",
    "Glossy Indirect": "GlossInd", "Glossy Color": "GlossCol", "Emission": "Emit", "Environment": "Env",
    "Object Index": "IndexOB", "Material Index": "IndexMA",
}  # fmt: skip

UNFED_GROUP_INPUTS_COUNT = bpy.app.version >= (5, 0, 0)
"""What a group's input feeds that nothing feeds has that input's own value (seen in 5.2); before that it counts as
unlinked (seen in 3.4 and 4.3)."""

PREMULTIPLIED_IS_DIVIDED = bpy.app.version >= (5, 0, 0)
"""An image of 8 bits whose alpha is said to be premultiplied is divided by it (seen in 5.2); before that it is read as
one with straight alpha."""

FILE_PATH_OPTIONS = (
    {"PATH_SUPPORTS_BLEND_RELATIVE"}
    if "is_path_supports_blend_relative" in bpy.types.Property.bl_rna.properties
    else set()
)
"""The options of a path property that may start with //, which newer versions want to be told."""


def view_layer_panel(topic: str) -> type:
    """The class that draws Blender's own panel of view layers on Cryptomatte or Lightgroups."""
    module = bl_ui.properties_view_layer
    return getattr(module, f"ViewLayer{topic}PanelHelper", None) or getattr(module, f"ViewLayer{topic}Panel")


def pass_name(name: str) -> str:
    """Blender's name of a pass."""
    return SHORT_PASS_NAMES.get(name, name) if PASSES_HAVE_SHORT_NAMES else name


def write_pass(render_pass, pixels: np.ndarray) -> None:
    """Writes `pixels`, (N, channels) float32, into a pass of a render result.

    Blender 4 takes the flat array and 3.4 insists on (N, channels): the faster is tried first.
    """
    try:
        render_pass.rect.foreach_set(pixels.ravel())
    except TypeError:
        render_pass.rect.foreach_set(pixels)


def normals(mesh) -> tuple[str, np.ndarray] | None:
    """("CORNER" or "POINT", (N, 3) float32): the normals of face corners, or of vertices where those are the same, with
    smoothing, sharp edges and custom normals applied. None: each corner has its face's normal.

    In place where possible: valid while the mesh is as it is.
    """
    if hasattr(mesh, "normals_domain"):  # Blender 4.1+
        if mesh.normals_domain == "FACE":
            return None
        return "CORNER", in_place.column(mesh.corner_normals, "vector", np.float32, 3)
    smooth = in_place.column(mesh.polygons, "use_smooth", bool)
    if not smooth.any() and not mesh.has_custom_normals:
        return None
    if not mesh.use_auto_smooth:
        return _normals_without_auto_smooth(mesh, smooth)
    mesh.calc_normals_split()
    values = np.empty((len(mesh.loops), 3), dtype=np.float32)
    mesh.loops.foreach_get("normal", values.ravel())
    return "CORNER", values


def _normals_without_auto_smooth(mesh, smooth: np.ndarray) -> tuple[str, np.ndarray]:
    """normals() before Blender 4.1 of a mesh whose polygons are wholly smooth or flat.

    Those of its vertices are made here: Blender's own are added up by several threads in whatever order (seen in 3.4;
    not so with auto smooth), so that their last bits differ each time. The same scene would have another picture, and
    its checkpoint would be refused.
    """
    positions = np.empty((len(mesh.vertices), 3), dtype=np.float32)
    mesh.vertices.foreach_get("co", positions.ravel())
    vertices = in_place.column(mesh.loops, "vertex_index", np.int32)
    starts = in_place.column(mesh.polygons, "loop_start", np.int32)
    totals = in_place.column(mesh.polygons, "loop_total", np.int32)
    of_polygons = in_place.column(mesh.polygon_normals, "vector", np.float32, 3)
    of_vertices = native.require().vertex_normals(positions, vertices, starts, totals, of_polygons)
    if smooth.all():
        return "POINT", of_vertices
    values = of_vertices[vertices]
    polygon = np.repeat(np.arange(len(totals)), totals)  # of each corner, in the order of the polygons
    corner = np.arange(len(polygon)) + (starts - (np.cumsum(totals) - totals))[polygon]
    flat = ~smooth[polygon]
    values[corner[flat]] = of_polygons[polygon[flat]]
    return "CORNER", values


def triangle_slots(mesh) -> np.ndarray:
    """(T,) int32: the material slot of each of the mesh's loop triangles."""
    attribute = mesh.attributes.get("material_index")
    if attribute is None:
        return np.zeros(len(mesh.loop_triangles), dtype=np.int32)
    if hasattr(mesh, "loop_triangle_polygons"):  # Blender 4.1+
        polygons = in_place.column(mesh.loop_triangle_polygons, "value", np.int32)
    else:
        polygons = in_place.column(mesh.loop_triangles, "polygon_index", np.int32)
    return in_place.column(attribute.data, "value", np.int32)[polygons]


def render_colour(mesh):
    """The colour attribute of a mesh that is active for rendering; None without one."""
    return mesh.attributes.get(mesh.color_attributes.default_color_name or "")


def node_tree(datablock):
    """The shader node tree in use of a material, world or light; None without one.

    Where `use_nodes` is deprecated (materials and worlds from Blender 5.0 on, lights from 5.1) nodes are always used.
    """
    switch = datablock.bl_rna.properties.get("use_nodes")
    if switch and not getattr(switch, "is_deprecated", False) and not datablock.use_nodes:
        return None
    return datablock.node_tree


def world_visibility(world) -> dict[str, bool]:
    """Whether camera, diffuse and glossy rays see a world; all do where it has no such switches."""
    switches = getattr(world, "cycles_visibility", None)
    return {name: getattr(switches, name, True) for name in ("camera", "diffuse", "glossy")}


def light_is_sphere(light) -> bool:
    """Whether a point light or spot is a sphere, not a disk that faces whoever looks at it.

    Before Blender 4.0 it is a disk; later it is a sphere, but where it has `use_soft_falloff` switched on.
    """
    return bpy.app.version >= (4, 0, 0) and not getattr(light, "use_soft_falloff", False)


def light_colour(light) -> tuple[float, float, float]:
    """A light's colour times its exposure and temperature, where the version has them (Blender 4.5+)."""
    factor = 2.0 ** getattr(light, "exposure", 0.0)
    temperature = light.temperature_color if getattr(light, "use_temperature", False) else (1.0, 1.0, 1.0)
    return tuple(factor * c * t for c, t in zip(light.color, temperature, strict=True))


def light_is_normalized(light) -> bool:
    """Whether a light's power is that of the whole, not of each square metre (Blender 4.5+ has the choice)."""
    return getattr(light, "normalize", True)


def light_casts_shadows(light) -> bool:
    """Whether a light casts shadows. In older versions Cycles has a switch of its own beside Blender's: both count."""
    return light.use_shadow and getattr(getattr(light, "cycles", None), "cast_shadow", True)


def light_is_met_by_rays(light) -> bool:
    """Whether Cycles shows a light in mirrors: one without multiple importance sampling is not met by rays."""
    return getattr(getattr(light, "cycles", None), "use_multiple_importance_sampling", True)


def motion_blur_position(scene) -> str:
    """START, CENTER or END: what the frame is of the time that the shutter is open (Cycles' own before Blender 4.2)."""
    return getattr(scene.render, "motion_blur_position", None) or scene.cycles.motion_blur_position


def hair_shape(scene) -> str:
    """RIBBON or TUBE, the native scene's names for Cycles' two shapes of strands."""
    return "TUBE" if getattr(getattr(scene, "cycles_curves", None), "shape", "RIBBONS") == "THICK" else "RIBBON"


def set_file_format(image_settings, file_format: str) -> None:
    """Chooses the file format of a scene's pictures; from Blender 5.0 on the kind of medium has to be chosen first."""
    if hasattr(image_settings, "media_type"):
        image_settings.media_type = "MULTI_LAYER_IMAGE" if file_format == "OPEN_EXR_MULTILAYER" else "IMAGE"
    image_settings.file_format = file_format
