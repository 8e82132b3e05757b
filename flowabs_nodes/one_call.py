"""Draws a picture in one call: an array in, an array of the same kind out, by the graphs that come with the package.

``fa.abstraction(rgb, line_width=1.5)``. What the array's numbers mean is in :mod:`flowabs_nodes.array_kind`.
"""

from __future__ import annotations

import inspect
from typing import TYPE_CHECKING, Any, Protocol, TypeVar, overload

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_kind import array_and_kind
from flowabs_nodes.array_types import HasArray
from flowabs_nodes.engine.plan import sinks
from flowabs_nodes.engine.runnable import RunnableGraph, load_graph
from flowabs_nodes.errors import ArgumentError, nearest

if TYPE_CHECKING:
    import OpenImageIO as oiio

Number = TypeVar("Number", np.uint8, np.uint16, np.float16, np.float32, np.float64)


class OneCall(Protocol):
    """A function from a picture to the same picture drawn; its keywords are the knobs of a graph."""

    @overload
    def __call__(
        self, rgb: npt.NDArray[Number], *, encoding: str | None = None, **knobs: float
    ) -> npt.NDArray[Number]: ...

    @overload
    def __call__(
        self, rgb: HasArray | oiio.ImageBuf, *, encoding: str | None = None, **knobs: float
    ) -> npt.NDArray[np.generic]: ...


_DOC = """{description}

Runs the graph {name!r} that comes with flowabs (``flowabs graphs {name}`` prints it). Lengths in pixels
grow with the picture, from the size that the graph is meant for.

Parameters
----------
rgb
    The picture: (H, W), (H, W, 3) or (H, W, 4) in the order R, G, B, A; a NumPy array, whatever NumPy makes one of
    (a tensor, a Pillow image), or an OpenImageIO ImageBuf. uint8 and uint16 have white at 255 and 65535, floats at 1.
encoding
    What the numbers mean: "sRGB", as screens show them; "linear", scene-linear light of Rec.709 primaries; or another
    name of a colour space ("ACEScg", a camera's log). Without it whole numbers are sRGB, and floats linear: where
    floats from 0 to 1 could be either, the logger "flowabs" says so.
    Alpha is straight, but premultiplied with floats of a linear space.
{knobs}

Returns
-------
An array of the same shape, dtype and encoding as ``rgb``, alpha as it was.{drawing}

Raises
------
ArgumentError
    ``rgb`` is no such picture, or there is no such knob.
GraphError
    A knob's value is wrong.
ColorError
    ``encoding`` is no colour space.
"""


def one_call(name: str) -> OneCall:
    """Return the function that runs a graph that comes with the package, with the graph's knobs in its signature."""
    graph = load_graph(name)

    def draw(rgb: Any, *, encoding: str | None = None, **knobs: float) -> npt.NDArray[Any]:
        unknown = next((knob for knob in knobs if knob not in graph.interface), None)
        if unknown is not None:
            known = [*graph.interface, "encoding"]
            raise ArgumentError(f"{name} has no knob {unknown!r}", code="unknown-param", hint=nearest(unknown, known))
        array, kind = array_and_kind(rgb, encoding, name)
        plate = next(node for node, found in graph.nodes.items() if found.declaration.type == "read")
        drawn = _drawn(graph)
        return kind.array(graph.run(given={plate: kind.image(array)}, set=knobs, outputs=drawn)[drawn], array)

    draw.__name__ = draw.__qualname__ = name
    draw.__doc__ = _docstring(graph)
    draw.__signature__ = _signature(draw, graph)  # type: ignore[attr-defined]
    return draw


def _drawn(graph: RunnableGraph) -> str:
    """Return the name of the output that the graph's write node writes."""
    return str(graph.nodes[sinks(graph)[0]].inputs["image"])


def _docstring(graph: RunnableGraph) -> str:
    knobs = (
        f"{knob.name}\n    {knob.help} {knob.param.expected.capitalize()}; {knob.default} unless given."
        for knob in graph.interface.values()
    )
    node, _, output = _drawn(graph).partition(".")
    matte = graph.nodes[node].declaration.all_outputs[output].types == "matte"
    return _DOC.format(
        name=graph.name,
        description=graph.description,
        knobs="\n".join(knobs),
        drawing="\nIts channels are equal: paper is white, 1 or 255, and ink 0, in any encoding." if matte else "",
    )


def _signature(draw: Any, graph: RunnableGraph) -> inspect.Signature:
    own = inspect.signature(draw)
    kind = inspect.Parameter.KEYWORD_ONLY
    parameters = [each for each in own.parameters.values() if each.kind is not inspect.Parameter.VAR_KEYWORD]
    parameters += [
        inspect.Parameter(knob.name, kind, default=knob.default, annotation=knob.type)
        for knob in graph.interface.values()
    ]
    return own.replace(parameters=parameters)


abstraction = one_call("abstraction")
abstraction_hdr = one_call("abstraction_hdr")
bold = one_call("bold")
flat = one_call("flat")
inked = one_call("inked")
lines = one_call("lines")
pencil = one_call("pencil")
portrait = one_call("portrait")
