# SPDX-License-Identifier: GPL-3.0-or-later
"""A node tree -> a program. Links are followed against their flow, through reroutes, muted nodes and into groups.

Each kind of node has a function in one of the `nodes_*` files, registered by its bl_idname; it returns the register of
the output asked for. What has none makes an issue, and the socket that wanted it keeps its own value.
"""

from collections.abc import Callable
from typing import NamedTuple

from ... import compat
from .program import Program

NODES: dict[str, Callable] = {}
"""bl_idname -> function(compiler, Place, output socket) -> register"""


class UnsupportedNode(Exception):
    """A node, or a mode of it, that Penumbra cannot evaluate; the text is for the user."""


def node(*identifiers: str):
    """Registers a function for these kinds of nodes."""

    def register(function):
        for identifier in identifiers:
            NODES[identifier] = function
        return function

    return register


class Place(NamedTuple):
    """A node, and the group nodes that it is in, from the outside to the inside."""

    node: object
    groups: tuple = ()

    def input(self, name: str):
        """An input socket by its identifier, or by its name; None if there is none."""
        inputs = self.node.inputs
        return next((s for s in inputs if s.identifier == name), None) or inputs.get(name)


def live_link(socket):
    """The link that feeds an input socket; None without one."""
    return next((link for link in socket.links if link.is_valid and not link.is_muted), None)


def group_output(tree):
    """The active output node of a group's tree; None without one."""
    outputs = [n for n in tree.nodes if n.bl_idname == "NodeGroupOutput"]
    return next((n for n in outputs if n.is_active_output), outputs[0] if outputs else None)


def socket_with(sockets, identifier: str):
    return next((s for s in sockets if s.identifier == identifier), None)


def upstream_of(source, socket, groups: tuple):
    """(input socket, groups) that an output of a reroute, group, group input or muted node stands for; or None."""
    if source.bl_idname == "NodeReroute":
        return source.inputs[0], groups
    if source.mute:
        inner = next((link for link in source.internal_links if link.to_socket == socket), None)
        if inner is None:
            raise UnsupportedNode(f"node {source.name!r} is muted")
        return inner.from_socket, groups
    if source.bl_idname == "NodeGroupInput" and groups:
        found, inside = socket_with(groups[-1].inputs, socket.identifier), groups[:-1]
    elif source.bl_idname == "ShaderNodeGroup" and source.node_tree:
        last, inside = group_output(source.node_tree), (*groups, source)
        found = socket_with(last.inputs, socket.identifier) if last else None
    else:
        return None
    if found is None:
        raise UnsupportedNode(f"node {source.name!r} has nothing at {socket.name!r}")
    return found, inside


def is_fed(socket, groups: tuple) -> bool:
    """Whether a node stands behind an input socket. As in Cycles before Blender 5, a link from a group's input that
    nothing feeds is none: a Normal is then the surface's, and a Vector the node's usual coordinates."""
    link = live_link(socket)
    if link is None:
        return False
    if compat.UNFED_GROUP_INPUTS_COUNT:
        return True
    try:
        upstream = upstream_of(link.from_node, link.from_socket, groups)
    except UnsupportedNode:  # muted with nothing behind it, or a group without this output
        return False
    return upstream is None or is_fed(*upstream)


class Compiler:
    """Writes one material's program. `attributes` gives numbers to names of attributes, `images` to images."""

    def __init__(self, material_name: str, attributes, images, issues: list[str], operations: frozenset[str]) -> None:
        self.material_name = material_name
        self.program = Program()
        self.attributes, self.images, self.issues = attributes, images, issues
        self.operations = operations
        self.shift = 0
        """Where on the surface operations look: 0 here, 1 and 2 beside it (for bumps)."""
        self._registers: dict[tuple, int] = {}
        self._open: set[tuple] = set()

    def note(self, place: Place, text: str) -> None:
        self.issues.append(f"node {place.node.name!r}: {text}")

    def is_linked(self, place: Place, name: str) -> bool:
        socket = place.input(name)
        return socket is not None and is_fed(socket, place.groups)

    def value(self, place: Place, name: str) -> int:
        """The register of an input socket's value; zero if the node has no such socket in this version."""
        socket = place.input(name)
        return 0 if socket is None else self.socket(socket, place.groups)

    def socket(self, socket, groups: tuple) -> int:
        link = live_link(socket)
        if link is not None:
            try:
                register = self.output(link.from_node, link.from_socket, groups)
                return self.converted(register, link.from_socket.type, socket.type)
            except UnsupportedNode as problem:
                self.issues.append(f"{problem} at {socket.name!r}; the socket's own value was used")
        return self.program.constant(getattr(socket, "default_value", 0.0))

    def output(self, source, socket, groups: tuple) -> int:
        """The register of a node's output."""
        upstream = upstream_of(source, socket, groups)
        if upstream is not None:
            return self.socket(*upstream)
        function = NODES.get(source.bl_idname)
        if function is None:
            raise UnsupportedNode(f"node {source.name!r} is not supported yet")
        key = source.as_pointer(), tuple(g.as_pointer() for g in groups), socket.identifier, self.shift
        if key not in self._registers:
            if key in self._open:
                raise UnsupportedNode(f"node {source.name!r} feeds itself")
            self._open.add(key)
            self._registers[key] = function(self, Place(source, groups), socket)
            self._open.discard(key)
        return self._registers[key]

    def converted(self, register: int, source_type: str, target_type: str) -> int:
        """A value as a socket of another type takes it."""
        if target_type not in ("VALUE", "INT", "BOOLEAN") or source_type == target_type:
            return register
        if source_type == "RGBA":
            return self.program.add("luminance", register)
        return self.program.add("average", register) if source_type == "VECTOR" else register

    def operation(self, place: Place, name: str, *inputs: int, data: int = 0) -> int:
        """An operation of the native renderer; UnsupportedNode if it has none of this name."""
        if name not in self.operations:
            mode = name.rpartition(".")[2]
            raise UnsupportedNode(f"node {place.node.name!r}: {mode!r} is not supported yet")
        return self.program.add(name, *inputs, shift=self.shift, data=data)

    def attribute(self, name: str) -> int:
        """The register of an attribute of the mesh; its alpha is in the next one."""
        return self.program.add("attribute", shift=self.shift, data=self.attributes.number(name))

    def normal(self, place: Place, name: str = "Normal") -> int:
        """The register of a Normal input, or of the surface's own normal."""
        return self.value(place, name) if self.is_linked(place, name) else self.program.add("normal")

    def coordinates(self, place: Place, fallback: Callable[[], int]) -> int:
        """The register of a Vector input; where it is not linked of `fallback`."""
        return self.value(place, "Vector") if self.is_linked(place, "Vector") else fallback()
