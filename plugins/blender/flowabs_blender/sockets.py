"""Makes a socket class for each port type, with a colour and a shape of its own, and puts ports on nodes as sockets."""

from __future__ import annotations

from typing import Any

import bpy

from flowabs_nodes.choices import readable
from flowabs_nodes.nodes.declare import Port
from flowabs_nodes.port_types import TYPES

from .identifiers import socket_id

ANY = "any"

#: The colour (linear red, green, blue, alpha) and the shape of each port type's sockets; near Blender's own where it
#: has the type too. A port type that is not here looks like "any".
LOOKS: dict[str, tuple[tuple[float, float, float, float], str]] = {
    "color": ((0.78, 0.78, 0.16, 1.0), "CIRCLE"),
    "mono": ((0.63, 0.63, 0.63, 1.0), "CIRCLE"),
    "matte": ((0.95, 0.95, 0.95, 1.0), "CIRCLE"),
    "flow": ((0.2, 0.75, 0.7, 1.0), "DIAMOND"),
    "depth": ((0.35, 0.5, 0.9, 1.0), "SQUARE"),
    "normal": ((0.39, 0.39, 0.9, 1.0), "SQUARE"),
    "motion": ((0.9, 0.45, 0.25, 1.0), "DIAMOND"),
    "id": ((0.55, 0.75, 0.3, 1.0), "SQUARE"),
    "data": ((0.8, 0.4, 0.7, 1.0), "SQUARE"),
    ANY: ((0.4, 0.4, 0.4, 1.0), "CIRCLE_DOT"),
}


class FlowabsSocket:
    """Draws a socket; mixed into the class of each port type.

    ``port`` is the port's name, of any length. ``kind`` is the port type that comes out, or goes in, with the links as
    they are: it differs from the class's own where an output is of the type of an input.
    """

    def draw(self, context: bpy.types.Context, layout: Any, node: bpy.types.Node, text: str) -> None:
        """Draw the port's name; of a further layer of ``write``, a field to change it and a button to take it away."""
        if not self.is_extra:
            layout.label(text=text)
            return
        row = layout.row(align=True)
        row.prop(self, "port", text="")
        button = row.operator("flowabs.remove_layer", text="", icon="X")
        button.node, button.layer = node.name, self.port

    def draw_color(self, context: bpy.types.Context, node: bpy.types.Node) -> tuple[float, float, float, float]:
        """Return the colour of what comes out or goes in."""
        return LOOKS.get(self.kind, LOOKS[ANY])[0]

    @classmethod
    def draw_color_simple(cls) -> tuple[float, float, float, float]:
        """Return the colour of the port type."""
        return LOOKS.get(cls.own_kind, LOOKS[ANY])[0]


def _renamed(socket: bpy.types.NodeSocket, context: bpy.types.Context) -> None:
    socket.id_data.update()


def classes() -> list[type]:
    """Return a socket class for each port type, and one for sockets that take any."""
    return [_socket_class(kind, TYPES[kind].label if kind in TYPES else "Any image") for kind in (*TYPES, ANY)]


def _socket_class(kind: str, label: str) -> type:
    properties = {
        "port": bpy.props.StringProperty(name="Layer", description="Name of the layer", update=_renamed),
        "kind": bpy.props.StringProperty(default=kind),
        "is_extra": bpy.props.BoolProperty(),
    }
    content = {"__annotations__": properties, "bl_idname": socket_id(kind), "bl_label": label, "own_kind": kind}
    return type(socket_id(kind), (FlowabsSocket, bpy.types.NodeSocket), content)


def kind_of(port: Port) -> str:
    """Return the port type that a port's socket looks like: its widest one, or "any" where there is none."""
    if not port.accepts:
        return ANY
    first = port.accepts[0]
    return first if all(kind == first or first in TYPES[kind].widens_to for kind in port.accepts) else ANY


def add_socket(sockets: Any, name: str, port: Port | None, *, extra: bool = False) -> bpy.types.NodeSocket:
    """Add a socket for a port to a node's ``inputs`` or ``outputs``; ``port`` is None where nothing is known of it."""
    kind = ANY if port is None else kind_of(port)
    socket = sockets.new(socket_id(kind), readable(name))
    socket.is_extra = extra
    socket.port = name
    look = LOOKS.get(kind, LOOKS[ANY])[1]
    optional = port is not None and port.optional
    socket.display_shape = f"{look}_DOT" if optional and not look.endswith("_DOT") else look
    if port is not None and hasattr(socket, "description"):
        socket.description = port.help
    return socket


def socket_of(sockets: Any, name: str) -> bpy.types.NodeSocket | None:
    """Return the socket of a port by the port's name; None where there is none."""
    return next((socket for socket in sockets if socket.port == name), None)
