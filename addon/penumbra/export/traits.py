# SPDX-License-Identifier: GPL-3.0-or-later
"""What the passes and the film ask about objects and materials: indices, Cryptomatte's ids, light groups, holdouts.

Nothing is looked up that no pass wants.
"""

from ..cryptomatte import matte_id
from .shader.attributes import DEFAULT_UV

NO_MATERIAL = "default_surface"
"""What Cycles' Cryptomatte calls the material of an empty slot."""

WITHOUT_SURFACE = ("LIGHT", "CAMERA", "EMPTY")


def asset_name(scene_object) -> str:
    """The name of an object's uppermost parent."""
    while scene_object.parent:
        scene_object = scene_object.parent
    return scene_object.name


class Traits:
    """Tells a native scene what the passes (native names) want to know.

    After the export `names` holds the names of what was exported, by Cryptomatte's pass.
    """

    def __init__(self, native_scene, depsgraph, passes: frozenset[str]) -> None:
        self._scene, self._layer = native_scene, depsgraph.view_layer
        groups = [group.name for group in getattr(self._layer, "lightgroups", ())]
        wanted = [name for name in groups if f"Combined_{name}" in passes]
        self._groups = {name: native_scene.add_light_group(name) for name in wanted}
        self._wants_index, self._wants_material_index = "Object Index" in passes, "Material Index" in passes
        kinds = ("CryptoObject", "CryptoMaterial", "CryptoAsset")
        self.names: dict[str, set[str]] = {kind: set() for kind in kinds if f"{kind}00" in passes}
        self.reads_uv = "UV" in passes
        self._has_flags = any(self._flag(o, name) for o in self._layer.objects for name in ("holdout", "indirect_only"))
        self._is_needed = self._groups or self._wants_index or self.names or self._has_flags
        self._told: dict = {}

    def _flag(self, scene_object, name: str) -> bool:
        """A switch of an original object or of the collections that it is in, in this view layer."""
        return getattr(scene_object, f"{name}_get")(view_layer=self._layer)

    def light_group(self, owner) -> int | None:
        """The number of the group of an object or world; None: it has none that a pass shows."""
        return self._groups.get(getattr(owner, "lightgroup", ""))

    def set_for(self, instance) -> None:
        """To be called before an entry of depsgraph.object_instances is added. Its instancer's switches count."""
        if not self._is_needed:
            return
        found = instance.object
        traits = {}
        if self._wants_index:
            traits["pass_index"] = found.pass_index
        if (group := self.light_group(found)) is not None:
            traits["light_group"] = group
        for kind, name_of in ("CryptoObject", lambda o: o.name), ("CryptoAsset", asset_name):
            if kind in self.names and found.type not in WITHOUT_SURFACE:
                name = name_of(found)
                self.names[kind].add(name)
                traits["object_matte" if kind == "CryptoObject" else "asset_matte"] = matte_id(name)
        if self._has_flags:
            owner = (instance.parent if instance.is_instance else found).original
            traits |= {name: True for name in ("holdout", "indirect_only") if self._flag(owner, name)}
        if traits != self._told:
            self._scene.set_traits(**traits)
            self._told = traits

    def set_for_material(self, number: int, material) -> None:
        """To be called after a material was added under this number; None: that of an empty slot."""
        name = material.name if material else NO_MATERIAL
        wants_matte = "CryptoMaterial" in self.names
        if wants_matte:
            self.names["CryptoMaterial"].add(name)
        index = material.pass_index if material and self._wants_material_index else 0
        if wants_matte or index:
            self._scene.set_material_ids(number, index, matte_id(name) if wants_matte else 0.0)

    def attributes(self, names) -> frozenset[int]:
        """Numbers of the attributes that the passes read from every mesh."""
        if not self.reads_uv:
            return frozenset()
        number = names.number(DEFAULT_UV)
        self._scene.set_uv_attribute(number)
        return frozenset([number])
