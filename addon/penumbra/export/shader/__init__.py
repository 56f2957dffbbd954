# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials' node trees -> programs that the native renderer evaluates at each surface point."""

# The families of nodes register themselves.
from . import nodes_colours, nodes_surface, nodes_textures, nodes_values  # noqa: F401
from .attributes import AttributeNames, at_corners
from .closures import Shaders
from .compiler import Compiler
from .default_surface import default_surface
from .images import Images, NoImages

__all__ = ["AttributeNames", "Compiler", "Images", "NoImages", "Shaders", "at_corners", "default_surface"]
