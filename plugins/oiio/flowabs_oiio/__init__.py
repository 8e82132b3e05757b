"""flowabs in the manner of OpenImageIO's ImageBufAlgo: ImageBufs in, ImageBufs out.

::

    import OpenImageIO as oiio
    import flowabs_oiio as fabuf

    src = oiio.ImageBuf("plate.exr")
    flow = fabuf.etf(src, radius=5)
    lines = fabuf.fdog(src, flow, sigma_c=1.5)
    if lines.has_error:
        print(lines.geterror())
    cartoon = fabuf.run("abstraction", src, line_width=1.5)

There is a function for each node that takes images and gives one, nodes of other packages among them:
``dir(flowabs_oiio)`` lists them, and the help of each is made from the node's declaration.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from flowabs_nodes.nodes import catalogue
from flowabs_oiio.calls import geterror
from flowabs_oiio.graph_calls import run
from flowabs_oiio.node_calls import node_call, takes_images

if TYPE_CHECKING:
    from flowabs_oiio.node_calls import NodeCall

__version__ = "0.1.0"

_NODES = {declaration.type: declaration for declaration in catalogue().values() if takes_images(declaration)}

__all__ = ["geterror", "run", *sorted(_NODES)]


def __getattr__(name: str) -> NodeCall:
    if name not in _NODES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = call = node_call(_NODES[name])
    return call


def __dir__() -> list[str]:
    return sorted(__all__)
