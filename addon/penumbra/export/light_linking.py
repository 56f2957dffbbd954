# SPDX-License-Identifier: GPL-3.0-or-later
"""Light and shadow linking (Blender 4.0 and later): which objects a luminaire lights, and which hide it.

A collection's objects, and those of its child collections, are included or excluded. Without an included one all
objects count as included; what is excluded is never meant.
"""

from typing import NamedTuple

from ..notes import Notes


class Group(NamedTuple):
    """Objects by the pointers of their originals."""

    included: frozenset[int]
    excluded: frozenset[int]

    def __contains__(self, pointer: int) -> bool:
        return (not self.included or pointer in self.included) and pointer not in self.excluded


def group_of(collection) -> Group:
    """What a linking collection means."""
    found: dict[str, set[int]] = {"INCLUDE": set(), "EXCLUDE": set()}
    for child, entry in zip(collection.children, collection.collection_children, strict=True):
        found[entry.light_linking.link_state].update(o.as_pointer() for o in child.all_objects)
    for member, entry in zip(collection.objects, collection.collection_objects, strict=True):
        found[entry.light_linking.link_state].add(member.as_pointer())
    return Group(frozenset(found["INCLUDE"]), frozenset(found["EXCLUDE"]))


class LightLinking:
    """The links of a depsgraph's objects, as ray masks and receiver sets of the native scene."""

    def __init__(self, native_module, depsgraph, notes: Notes) -> None:
        self._module = native_module
        self._receivers: dict[int, Group] = {}  # by the pointer of the luminaire's object
        self._blockers: dict[int, Group] = {}
        for evaluated_object in depsgraph.objects:
            original = evaluated_object.original  # whose collections hold originals
            linking, pointer = getattr(original, "light_linking", None), original.as_pointer()
            if linking and linking.receiver_collection:
                self._receivers[pointer] = group_of(linking.receiver_collection)
            if linking and linking.blocker_collection:
                group = group_of(linking.blocker_collection)
                most = native_module.MOST_BLOCKER_SETS
                if len({*self._blockers.values(), group}) > most:
                    notes.add(f"object {evaluated_object.name!r}: more than {most} different shadow links are not "
                              "supported; every object hides its light")  # fmt: skip
                else:
                    self._blockers[pointer] = group
        # Objects that the same luminaires light share a set; number 0 is for those that no collection names.
        self._named = frozenset().union(*(part for group in self._receivers.values() for part in group))
        self._sets = [self._lit(0)]
        self._sets += sorted({self._lit(pointer) for pointer in self._named} - set(self._sets))
        self._blocker_groups = list(dict.fromkeys(self._blockers.values()))

    def _lit(self, pointer: int) -> tuple[bool, ...]:
        """For each linked luminaire, whether it lights an object."""
        return tuple(pointer in group for group in self._receivers.values())

    def receiver_set(self, instance) -> int:
        """Of an entry of depsgraph.object_instances: as in Cycles an instancer's links count for its instances."""
        return self._sets.index(self._lit(self._pointer(instance, self._named))) if self._receivers else 0

    def shadow_rays(self, instance) -> int:
        """The kinds of shadow rays that an entry of depsgraph.object_instances blocks."""
        mask = self._module.SHADOW_RAY
        for number, group in enumerate(self._blocker_groups):
            if self._pointer(instance, group.included | group.excluded) in group:
                mask |= self._module.blocker_set_ray(number)
        return mask

    def of_luminaire(self, light_object) -> dict:
        """Arguments of the native LuminaireRole for an evaluated object that shines."""
        pointer, role = light_object.original.as_pointer(), {}
        if pointer in self._receivers:
            column = list(self._receivers).index(pointer)
            role["receivers"] = [lit[column] for lit in self._sets]
        if pointer in self._blockers:
            number = self._blocker_groups.index(self._blockers[pointer])
            role["shadow_rays"] = self._module.blocker_set_ray(number)
        return role

    @staticmethod
    def _pointer(instance, named) -> int:
        """Of the instancer if some collection names it, else of the object."""
        parent = instance.parent.original.as_pointer() if instance.is_instance else 0
        return parent if parent in named else instance.object.original.as_pointer()
