# SPDX-License-Identifier: GPL-3.0-or-later
"""Walking through Blender's shader nodes."""


def follow(socket):
    """The node that an input socket is linked to, through reroutes; None if it is not linked (or the link is muted)."""
    while socket.is_linked and socket.links and not socket.links[0].is_muted:
        node = socket.links[0].from_node
        if node.bl_idname != "NodeReroute":
            return node
        socket = node.inputs[0]
    return None


def socket_colour(socket, issues: list[str]) -> tuple[float, float, float]:
    """The (r, g, b) of a colour input, scene linear: its own value or that of an RGB node.

    Anything else linked to it adds an issue, and the socket's own value is taken.
    """
    node = follow(socket)
    if node is not None and node.bl_idname == "ShaderNodeRGB" and not node.mute:
        return tuple(node.outputs[0].default_value)[:3]
    if node is not None:
        issues.append(f"node {node.name!r} at {socket.name!r} is not supported yet; the socket's own colour was used")
    return tuple(socket.default_value)[:3]


def socket_value(socket, issues: list[str]) -> float:
    """The number of a float input: its own value or that of a Value node; else as socket_colour."""
    node = follow(socket)
    if node is not None and node.bl_idname == "ShaderNodeValue" and not node.mute:
        return node.outputs[0].default_value
    if node is not None:
        issues.append(f"node {node.name!r} at {socket.name!r} is not supported yet; the socket's own value was used")
    return socket.default_value
