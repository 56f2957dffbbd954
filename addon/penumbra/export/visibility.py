# SPDX-License-Identifier: GPL-3.0-or-later
"""Ray visibility: which rays meet an object, what a luminaire lights, and where it is seen itself."""

from .. import compat
from .light_linking import LightLinking


def rays_of(native_module, instance, linking: LightLinking) -> int:
    """The kinds of rays that meet an entry of depsgraph.object_instances; what hides its instancer hides it, too."""
    owners = [instance.object, instance.parent] if instance.is_instance else [instance.object]
    mask = 0
    if all(owner.visible_camera for owner in owners):
        mask |= native_module.CAMERA_RAY
    if all(owner.visible_glossy for owner in owners):
        mask |= native_module.MIRROR_RAY
    if all(owner.visible_shadow for owner in owners):
        mask |= linking.shadow_rays(instance)
    return mask


def role_of(native_module, shining_object, linking: LightLinking):
    """The native LuminaireRole of an evaluated object that shines, a light or a mesh."""
    is_light = shining_object.type == "LIGHT"  # a mesh is a surface, seen as such
    return native_module.LuminaireRole(
        to_camera=is_light and shining_object.visible_camera,
        in_mirrors=is_light and shining_object.visible_glossy and compat.light_is_met_by_rays(shining_object.data),
        diffuse=shining_object.visible_diffuse, glossy=shining_object.visible_glossy,
        **linking.of_luminaire(shining_object),
    )  # fmt: skip
