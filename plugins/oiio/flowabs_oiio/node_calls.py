"""A function from ImageBufs to an ImageBuf for each node, made from the node's declaration."""

from __future__ import annotations

import inspect
import textwrap
from collections.abc import Mapping
from typing import Any, Protocol

import OpenImageIO as oiio

from flowabs_nodes.encodings import remember_encodings
from flowabs_nodes.engine.call_node import call_node
from flowabs_nodes.errors import ArgumentError, nearest
from flowabs_nodes.image import Image
from flowabs_nodes.io.settings import Settings
from flowabs_nodes.nodes import catalogue
from flowabs_nodes.nodes.declare import Context, Node, Port
from flowabs_oiio.calls import delivered

_COMMON = """
output
    Which of the node's outputs is wanted: {outputs}.
dst
    An ImageBuf to fill. One that has pixels keeps its format and windows; one without is made to fit.
roi
    The pixels to deliver; the filter looks at the whole picture all the same.
nthreads
    How many threads the filter uses; 0: as many as there are processors.

Returns
-------
An ImageBuf with the windows and metadata of the first picture, float, scene-linear; with ``dst``, True where it was
filled. Where a picture or a parameter is wrong the ImageBuf has an error (``has_error``, ``geterror()``), or False
comes back, and ``flowabs_oiio.geterror()`` says why."""


class NodeCall(Protocol):
    """A function that runs one node; its signature has the node's inputs and parameters."""

    def __call__(
        self,
        *pictures: oiio.ImageBuf | None,
        output: str = "",
        dst: oiio.ImageBuf | None = None,
        roi: oiio.ROI | None = None,
        nthreads: int = 0,
        **params: Any,
    ) -> Any: ...


def takes_images(declaration: Node) -> bool:
    """Return whether a node takes images and gives one, and neither reads nor writes files nor other frames."""
    return bool(
        declaration.inputs and declaration.outputs and not declaration.file_param and declaration.frames is None
    )


def node_call(declaration: Node) -> NodeCall:
    """Return the function that runs a node on ImageBufs."""
    name = declaration.type
    signature = _signature(declaration)

    def call(
        *args: Any,
        dst: oiio.ImageBuf | None = None,
        roi: oiio.ROI | None = None,
        nthreads: int = 0,
        output: str = "",
        **named: Any,
    ) -> Any:
        bound = signature.bind(*args, **named)

        def compute() -> Image:
            pictures = {port: bound.arguments.pop(port, None) for port in declaration.all_inputs}
            given = {
                port: _image(declaration.all_inputs[port], buf) for port, buf in pictures.items() if buf is not None
            }
            wanted = _wanted(declaration, output)
            context = Context(node=name, wanted=frozenset((wanted,)), services=Settings())
            with remember_encodings():
                given |= _flow_of(declaration, given)
                return call_node(declaration, context, given, bound.arguments)[wanted].decoded()

        return delivered(name, compute, dst, roi, nthreads)

    call.__name__ = call.__qualname__ = name
    call.__doc__ = _docstring(declaration)
    common = [each for each in inspect.signature(call).parameters.values() if each.kind is each.KEYWORD_ONLY]
    call.__signature__ = signature.replace(  # type: ignore[attr-defined]
        parameters=[*signature.parameters.values(), *common]
    )
    return call


def _image(port: Port, buf: Any) -> Image:
    """Return an ImageBuf as an image of a type that the port takes: by its channels, or as one that it can only be."""
    if not isinstance(buf, oiio.ImageBuf):
        raise ArgumentError(f"{port.name}: expected an ImageBuf, found {type(buf).__name__}", parameter=port.name)
    if buf.has_error:
        raise ArgumentError(f"{port.name}: the ImageBuf has an error: {buf.geterror(False)}", parameter=port.name)
    image = Image.from_imagebuf(buf)
    if port.takes(image.type) is None and image.type in ("mono", "color", "data") and port.accepts == ("matte",):
        return Image.from_imagebuf(buf, type="matte")
    return image


def _flow_of(declaration: Node, given: Mapping[str, Image]) -> dict[str, Image]:
    """Return the flow of the first picture by the etf node's defaults, where a node needs a flow and is given none."""
    port = declaration.all_inputs.get("flow")
    if port is None or port.optional or "flow" in given or port.accepts != ("flow",) or not given:
        return {}
    etf = catalogue()["etf"]
    return {"flow": call_node(etf, Context(node="etf"), {"image": next(iter(given.values()))}, {})["flow"]}


def _wanted(declaration: Node, output: str) -> str:
    """Return the output that is asked for: the first one unless it is named."""
    outputs = declaration.all_outputs
    if output and output not in outputs:
        raise ArgumentError(
            f"output: {declaration.type} has no output {output!r}", hint=nearest(output, outputs), parameter="output"
        )
    return output or next(iter(outputs))


def _signature(declaration: Node) -> inspect.Signature:
    """Return what a function takes of its node: inputs in order, then parameters by name."""
    anywhere, named = inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY
    inputs = list(declaration.all_inputs.values())
    parameters = [
        inspect.Parameter(
            port.name, anywhere, default=inspect.Parameter.empty if i == 0 else None, annotation="oiio.ImageBuf"
        )
        for i, port in enumerate(inputs)
    ]
    parameters += [
        inspect.Parameter(
            param.name,
            named,
            default=inspect.Parameter.empty if param.required else param.default,
            annotation={"enum": "str", "string": "str", "color": "tuple"}.get(param.kind, param.kind),
        )
        for param in declaration.all_params.values()
    ]
    return inspect.Signature(parameters)


def _docstring(declaration: Node) -> str:
    """Return the help of a function: the node's own, its inputs and its parameters."""
    lines = [declaration.help, "", declaration.doc, "", "Parameters", "----------"]
    for i, port in enumerate(declaration.all_inputs.values()):
        unless = "" if i == 0 else ", optional" if port.optional else ", made by etf() unless given"
        lines += [
            f"{port.name}",
            f"    {port.types}{unless if port.name == 'flow' or port.optional else ''}. {port.help}",
        ]
    for param in declaration.all_params.values():
        default = "required" if param.required else f"{param.default!r} unless given"
        lines += [
            f"{param.name}",
            *textwrap.wrap(
                f"{param.help} {param.expected}; {default}.", 110, initial_indent="    ", subsequent_indent="    "
            ),
        ]
    outputs = " or ".join(f'"{name}"' for name in declaration.all_outputs)
    return "\n".join(lines) + _COMMON.format(outputs=outputs)
