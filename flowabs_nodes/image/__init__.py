"""The value that travels along every edge of a graph, :class:`Image`, and what brings it to hosts and back."""

from flowabs_nodes.image.image import Image
from flowabs_nodes.image.parts import Origin, PixelSource, Window
from flowabs_nodes.port_types import PORT_TYPES, PortType

__all__ = ["PORT_TYPES", "Image", "Origin", "PixelSource", "PortType", "Window"]
