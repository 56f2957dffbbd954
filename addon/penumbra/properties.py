# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings: `scene.penumbra` and the pass switches `view_layer.penumbra`."""

import bpy
from bpy.app.handlers import persistent
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from . import compat

# Files hold the numbers at the end of these entries: a number keeps its meaning for ever.
STOP_RULES = [
    (
        "BOUNDED",
        "Bounded",
        "Add points until a calibrated bound of the error is below the tolerance, where penumbra can be: at least 99 %"
        " of the pixels keep it. Needs the Owen-scrambled Sobol' sampler with scrambled reuse",
        0,
    ),
    ("FIXED", "Fixed", "The same number of light points everywhere: Light Samples", 1),
    (
        "PAPER",
        "Running Mean",
        "Ohbuchi and Aono's rule: add points until the running mean of red, green and blue has moved by less than the"
        " error tolerance since the check before",
        2,
    ),
    ("VARIANCE", "Variance", "Add points until the standard error of the mean is below the error tolerance", 3),
]
SAMPLERS = [
    ("PRS", "Pseudo-random", "Pairs of drand48(): plain Monte Carlo, drawn anew at each pixel", 0),
    (
        "SPRS",
        "Stratified",
        "One random point in each of n x n cells, drawn anew at each pixel; only with the fixed stop rule and a square"
        " number of light samples",
        1,
    ),
    ("SOBOL", "Sobol'", "Sobol' sequence with the direction numbers of Numerical Recipes", 2),
    ("HALTON", "Halton", "Halton sequence in bases 2 and 3", 3),
    (
        "OWEN_SOBOL",
        "Owen-scrambled Sobol'",
        "A (0,2)-sequence with Owen's scrambling: the least error for most scenes",
        4,
    ),
]
SAMPLE_REUSES = [
    ("SAME", "Same Points", "Every pixel uses the same points", 0),
    ("CONTINUED", "Continued", "Each pixel goes on in the sequence where the pixel before it stopped", 1),
    ("ROTATED", "Rotated", "The same points, shifted by a random offset in each pixel (Cranley-Patterson rotation)", 2),
    ("SCRAMBLED", "Scrambled", "The same points, scrambled differently in each pixel", 3),
]
FILTERS = [
    ("BLACKMAN_HARRIS", "Blackman-Harris", "Smooth filter, sharp edges without ringing", 0),
    ("BOX", "Box", "Plain average over the filter's width", 1),
]


PREVIEW = {
    "stop_rule": "FIXED", "sampler": "OWEN_SOBOL", "sample_reuse": "SCRAMBLED", "light_samples": 16, "pixel_samples": 4,
    "mirror_depth": 2,
}  # fmt: skip
"""What the previews of materials, lights and worlds are rendered with: they are to be there at once."""

NOT_FOR_THE_NATIVE_RENDER = ("statistics_file", "checkpoint_folder", "saved_by")


class PenumbraSettings(bpy.types.PropertyGroup):
    """`scene.penumbra`. Names, defaults and meanings are a contract with scripts: see the README's table."""

    error_tolerance: FloatProperty(
        name="Error Tolerance",
        description="Largest error of a pixel's colour, in display units: 1 is white after exposure and before the view"
        " transform; relative to the pixel's value above white",
        default=0.004, min=1e-9, max=1e9, soft_min=1e-4, soft_max=0.1, precision=4, step=0.1,
    )  # fmt: skip
    stop_rule: EnumProperty(
        name="Stop Rule",
        description="When a shading point has enough light points",
        items=STOP_RULES,
        default="BOUNDED",
    )
    sampler: EnumProperty(
        name="Sampler", description="The sequence of points on a light", items=SAMPLERS, default="OWEN_SOBOL"
    )
    sample_reuse: EnumProperty(
        name="Reuse",
        description="How pixels share one sequence of points; the pseudo-random and stratified samplers ignore it",
        items=SAMPLE_REUSES, default="SCRAMBLED",
    )  # fmt: skip
    light_samples: IntProperty(
        name="Light Samples",
        description="Points per light and shading point with the fixed stop rule",
        default=64, min=1, max=2**24, soft_max=4096,
    )  # fmt: skip
    max_light_samples: IntProperty(
        name="Max Light Samples",
        description="Upper limit of points per light and shading point; the statistics count the pixels that hit it",
        default=8192, min=1, max=2**24, soft_max=65536,
    )  # fmt: skip
    check_interval: IntProperty(
        name="Check Interval",
        description="Points added between two checks of the running-mean rule (t in the paper)",
        default=5, min=1, max=2**20, soft_max=64,
    )  # fmt: skip
    pixel_samples: IntProperty(
        name="Pixel Samples",
        description="Camera rays per pixel; 1 is a single ray through the pixel's centre, without antialiasing. With"
        " the bounded stop rule any value above 1 turns antialiasing on, with as many rays as the tolerance needs",
        default=16, min=1, max=2**20, soft_max=256,
    )  # fmt: skip
    max_pixel_samples: IntProperty(
        name="Max Pixel Samples",
        description="Upper limit of camera rays per pixel with the bounded stop rule; the statistics count the pixels"
        " that hit it",
        default=8192, min=1, max=2**20, soft_max=65536,
    )  # fmt: skip
    filter_type: EnumProperty(
        name="Filter", description="Pixel filter, with more than one pixel sample", items=FILTERS,
        default="BLACKMAN_HARRIS",
    )  # fmt: skip
    filter_width: FloatProperty(
        name="Filter Width", subtype="PIXEL",
        description="Width of the pixel filter as Cycles has it: Blackman-Harris reaches that far to each side, Box"
        " half as far",
        default=1.5, min=0.01, max=10.0, soft_min=1.0, soft_max=4.0,
    )  # fmt: skip
    mirror_depth: IntProperty(
        name="Mirror Depth", description="Mirror bounces followed; 0 shows mirrors black", default=4, min=0, max=1024,
        soft_max=16,
    )  # fmt: skip
    seed: IntProperty(
        name="Seed", description="Seed of all random numbers; the same seed gives the same picture", default=0,
        min=0, max=2**31 - 1,
    )  # fmt: skip
    statistics_file: StringProperty(
        name="Statistics File",
        description="JSON file written after a final render, none if empty; // is the .blend file's folder and #### the"
        " frame number",
        subtype="FILE_PATH", default="", options=compat.FILE_PATH_OPTIONS,
    )  # fmt: skip
    checkpoint_folder: StringProperty(
        name="Checkpoint",
        description="Folder in which a final render keeps its finished tiles, none if empty. The same render started"
        " again goes on from there; remove the folder when it is not needed any more",
        subtype="DIR_PATH", default="", options=compat.FILE_PATH_OPTIONS,
    )  # fmt: skip
    memory_limit: IntProperty(
        name="Memory Limit",
        description="Most memory for the picture and the ray tracing structure, in MiB: needing more is an"
        " error. 0: no limit",
        default=0, min=0, max=2**31 - 1, soft_max=2**17,
    )  # fmt: skip
    saved_by: StringProperty(
        name="Saved By", description="Version of Penumbra that the file was saved with; empty for one never saved",
        default="", options={"HIDDEN"},
    )  # fmt: skip


class PenumbraViewLayerSettings(bpy.types.PropertyGroup):
    """`view_layer.penumbra`: the passes that only Penumbra has. On by default; each costs four bytes a pixel."""

    use_pass_light_samples: BoolProperty(
        name="Light Samples", description="Deliver the number of light points used in each pixel", default=True
    )
    use_pass_error_estimate: BoolProperty(
        name="Error Estimate", description="Deliver the estimated error of each pixel, in display units", default=True
    )


def value_of(settings, name: str):
    """A setting; the default where a file holds a choice that this version of Penumbra does not know."""
    definition = settings.bl_rna.properties[name]
    value = getattr(settings, name)
    return definition.default if definition.type == "ENUM" and value not in definition.enum_items else value


def unknown_choices(settings) -> list[str]:
    """Names of the settings whose choice this version of Penumbra does not know."""
    names = [name for name in type(settings).__annotations__ if settings.bl_rna.properties[name].type == "ENUM"]
    return [name for name in names if value_of(settings, name) != getattr(settings, name)]


@persistent
def upgrade(*_) -> None:
    """Called when a file was loaded: what another version has chosen and this one does not know becomes the default."""
    for scene in bpy.data.scenes:
        for name in unknown_choices(scene.penumbra):
            scene.penumbra.property_unset(name)
            print(f"Penumbra note: scene {scene.name!r}: its {name} is none that this version knows; the default "
                  f"{getattr(scene.penumbra, name)} is used", flush=True)  # fmt: skip


@persistent
def stamp(*_) -> None:
    """Called before a file is saved: it remembers which version's settings these are."""
    from . import bl_info

    version = ".".join(map(str, bl_info["version"]))
    for scene in bpy.data.scenes:
        if scene.render.engine == "PENUMBRA":
            scene.penumbra.saved_by = version


def native_settings(scene, size: tuple[int, int], region: tuple[int, int, int, int], passes: list[str]) -> dict:
    """The settings of the native render; `size` (width, height) of the full frame, `region` (x, y, w, h), in pixels."""
    own = scene.penumbra
    names = [name for name in PenumbraSettings.__annotations__ if name not in NOT_FOR_THE_NATIVE_RENDER]
    return {name: value_of(own, name) for name in names} | {
        "width": size[0],
        "height": size[1],
        "region": region,
        "exposure": scene.view_settings.exposure,
        "threads": scene.render.threads if scene.render.threads_mode == "FIXED" else 0,
        "passes": passes,
    }


def register() -> None:
    bpy.utils.register_class(PenumbraSettings)
    bpy.utils.register_class(PenumbraViewLayerSettings)
    bpy.types.Scene.penumbra = PointerProperty(type=PenumbraSettings)
    bpy.types.ViewLayer.penumbra = PointerProperty(type=PenumbraViewLayerSettings)
    bpy.app.handlers.load_post.append(upgrade)
    bpy.app.handlers.save_pre.append(stamp)


def unregister() -> None:
    bpy.app.handlers.save_pre.remove(stamp)
    bpy.app.handlers.load_post.remove(upgrade)
    del bpy.types.ViewLayer.penumbra
    del bpy.types.Scene.penumbra
    bpy.utils.unregister_class(PenumbraViewLayerSettings)
    bpy.utils.unregister_class(PenumbraSettings)
