# SPDX-License-Identifier: GPL-3.0-or-later
"""The passes: which are wanted, how Blender is told of them, and how a finished bucket gets into them.

The native renderer calls them as Blender 5 does.
"""

from collections.abc import Callable
from typing import NamedTuple

from . import compat


class Pass(NamedTuple):
    """A pass by its name in the native renderer; see compat.pass_name for Blender's."""

    name: str
    channels: str
    kind: str
    wanted: Callable
    """view layer -> bool"""


PASSES = (
    Pass("Combined", "RGBA", "COLOR", lambda layer: True),
    Pass("Depth", "Z", "VALUE", lambda layer: layer.use_pass_z),
    Pass("Normal", "XYZ", "VECTOR", lambda layer: layer.use_pass_normal),
    Pass("Position", "XYZ", "VECTOR", lambda layer: layer.use_pass_position),
    Pass("Light Samples", "X", "VALUE", lambda layer: layer.penumbra.use_pass_light_samples),
    Pass("Error Estimate", "X", "VALUE", lambda layer: layer.penumbra.use_pass_error_estimate),
    Pass("Mist", "Z", "VALUE", lambda layer: layer.use_pass_mist),
    Pass("UV", "UVA", "VECTOR", lambda layer: layer.use_pass_uv),
    Pass("Object Index", "X", "VALUE", lambda layer: layer.use_pass_object_index),
    Pass("Material Index", "X", "VALUE", lambda layer: layer.use_pass_material_index),
    Pass("Diffuse Direct", "RGB", "COLOR", lambda layer: layer.use_pass_diffuse_direct),
    Pass("Diffuse Color", "RGB", "COLOR", lambda layer: layer.use_pass_diffuse_color),
    Pass("Glossy Direct", "RGB", "COLOR", lambda layer: layer.use_pass_glossy_direct),
    Pass("Glossy Indirect", "RGB", "COLOR", lambda layer: layer.use_pass_glossy_indirect),
    Pass("Glossy Color", "RGB", "COLOR", lambda layer: layer.use_pass_glossy_color),
    Pass("Emission", "RGB", "COLOR", lambda layer: layer.use_pass_emit),
    Pass("Environment", "RGB", "COLOR", lambda layer: layer.use_pass_environment),
    Pass("Shadow", "RGB", "COLOR", lambda layer: layer.use_pass_shadow),
)

MATTES = {"CryptoObject": "use_pass_cryptomatte_object", "CryptoMaterial": "use_pass_cryptomatte_material",
          "CryptoAsset": "use_pass_cryptomatte_asset"}  # fmt: skip
"""Cryptomatte's passes without their numbers, and their switches."""

NOT_THERE = {
    "use_pass_vector": "Vector", "use_pass_diffuse_indirect": "Diffuse Indirect",
    "use_pass_transmission_direct": "Transmission Direct", "use_pass_transmission_indirect": "Transmission Indirect",
    "use_pass_transmission_color": "Transmission Color", "use_pass_subsurface_direct": "Subsurface Direct",
    "use_pass_subsurface_indirect": "Subsurface Indirect", "use_pass_subsurface_color": "Subsurface Color",
    "use_pass_ambient_occlusion": "Ambient Occlusion",
}  # fmt: skip

MIST_EXPONENTS = {"QUADRATIC": 2.0, "LINEAR": 1.0, "INVERSE_QUADRATIC": 0.5}


def wanted_by(view_layer) -> list[Pass]:
    """The passes this view layer asks for; Combined always."""
    found = [entry for entry in PASSES if entry.wanted(view_layer)]
    # Lower case: other letters would be compressed with loss by some codecs, and ids bear none.
    numbers = range((min(view_layer.pass_cryptomatte_depth, 16) + 1) // 2)
    found += [Pass(f"{kind}{number:02d}", "rgba", "COLOR", lambda layer: True)
              for kind, switch in MATTES.items() if getattr(view_layer, switch) for number in numbers]  # fmt: skip
    groups = getattr(view_layer, "lightgroups", ())
    found += [Pass(f"Combined_{group.name}", "RGB", "COLOR", lambda layer: True) for group in groups]
    return found


def note_missing(view_layer, notes) -> None:
    """Notes the passes that this view layer asks for in vain."""
    missing = [name for switch, name in NOT_THERE.items() if getattr(view_layer, switch, False)]
    missing += [f"{aov.name!r} (a shader AOV)" for aov in view_layer.aovs]
    if missing:
        notes.add(f"view layer {view_layer.name!r}: there is no pass {', '.join(missing)}")


def native_settings(scene, view_layer) -> dict:
    """The settings of the native render that a view layer's passes and its number of samples ask for."""
    names = [entry.name for entry in wanted_by(view_layer)]
    settings: dict = {"passes": names}
    if "Mist" in names and scene.world:
        mist = scene.world.mist_settings
        settings["mist"] = mist.start, mist.depth, MIST_EXPONENTS[mist.falloff]
    if view_layer.samples > 0:
        settings["pixel_samples"] = view_layer.samples
    return settings


def register(engine, scene, view_layer) -> None:
    """Tells Blender, for its compositor, which passes the engine will deliver."""
    for entry in wanted_by(view_layer):
        name = compat.pass_name(entry.name)
        engine.register_pass(scene, view_layer, name, len(entry.channels), entry.channels, entry.kind)


def add_to_result(engine, view_layer) -> None:
    """Makes room in the render result for the passes that Blender does not know itself."""
    for entry in wanted_by(view_layer):
        name = compat.pass_name(entry.name)
        engine.add_pass(name, len(entry.channels), entry.channels, layer=view_layer.name)


def write_bucket(engine, render, view_layer, bucket: tuple[int, int, int, int], is_all: bool = False) -> None:
    """Copies a finished bucket (x, y, w, h: pixels from the border's bottom left) into Blender's render result.

    is_all: it is the whole picture, of a render that is finished. Raises RuntimeError if Blender's bucket is not of
    that size: the picture would be torn.
    """
    x, y, width, height = bucket
    result = engine.begin_result(x, y, width, height, layer=view_layer.name)
    try:
        if (result.resolution_x, result.resolution_y) != (width, height):
            raise RuntimeError(
                f"Blender gave a bucket of {result.resolution_x} x {result.resolution_y} pixels instead of"
                f" {width} x {height} at ({x}, {y})"
            )
        layer = result.layers[0]
        for entry in wanted_by(view_layer):
            pixels = render.view(entry.name) if is_all else render.read(entry.name, x, y, width, height)
            compat.write_pass(layer.passes.find_by_name(compat.pass_name(entry.name), ""), pixels)
    except BaseException:
        engine.end_result(result, cancel=True)
        raise
    engine.end_result(result)
