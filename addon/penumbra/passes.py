# SPDX-License-Identifier: GPL-3.0-or-later
"""The passes: which are wanted, how Blender is told of them, and how a finished bucket gets into them."""

from collections.abc import Callable
from typing import NamedTuple

from . import compat


class Pass(NamedTuple):
    """A pass as Blender and the native renderer both name it."""

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
)


def wanted_by(view_layer) -> list[Pass]:
    """The passes this view layer asks for; Combined always."""
    return [entry for entry in PASSES if entry.wanted(view_layer)]


def register(engine, scene, view_layer) -> None:
    """Tells Blender, for its compositor, which passes the engine will deliver."""
    for entry in wanted_by(view_layer):
        engine.register_pass(scene, view_layer, entry.name, len(entry.channels), entry.channels, entry.kind)


def add_to_result(engine, view_layer) -> None:
    """Makes room in the render result for the passes that Blender does not know itself."""
    for entry in wanted_by(view_layer):
        engine.add_pass(entry.name, len(entry.channels), entry.channels, layer=view_layer.name)


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
            compat.write_pass(layer.passes.find_by_name(entry.name, ""), pixels)
    except BaseException:
        engine.end_result(result, cancel=True)
        raise
    engine.end_result(result)
