"""Calls one node on images, and does what all nodes have in common: widening, windows, checks, mask and mix."""

from __future__ import annotations

import os
from collections.abc import Mapping
from copy import copy
from dataclasses import replace
from typing import Any

import numpy as np

from flowabs_nodes.engine.data_windows import around, check_picture_size, on_display, on_union, with_alpha
from flowabs_nodes.engine.error_boundary import error_boundary
from flowabs_nodes.engine.window_inputs import NodeInputs, join_windows
from flowabs_nodes.errors import ArgumentError, FlowabsError, nearest
from flowabs_nodes.image import Image, Window
from flowabs_nodes.nodes.declare import MASK, MIX, Context, Node
from flowabs_nodes.port_types import pixel_type, widest


def call_node(declaration: Node, context: Context, inputs: NodeInputs, params: Mapping[str, Any]) -> dict[str, Image]:
    """Compute the outputs of one node that ``context.wanted`` names; all, where it names none.

    Inputs are widened to what their port asks for and brought to the data window that the node works on: of its first
    input, unless its declaration says else. An input that has more pixels is cut; one that has fewer is an error, but a
    mask, other inputs that may be cut and ``write``'s layers are 0 where they have no pixels. So are the other frames
    of an input that the node reads on several, which is given as a dict from frame offset to Image. Inputs that the
    node does not need with these parameters are left out. Parameters that are not given take their default; all are
    checked. The result goes over the input by mask x mix.

    Returns
    -------
    dict
        An Image by the output's name.

    Raises
    ------
    FlowabsError
        With node and frame. Codes of its own: missing-input, unknown-input, wrong-type, window-mismatch, missing-param,
        unknown-param, wrong-output, wrong-frames; whatever else the node raises is "internal", with its cause.
    """
    wanted = context.wanted or frozenset(declaration.all_outputs)
    context = replace(context, node=context.node or declaration.type, wanted=wanted)
    with error_boundary(context.node, context.frame):
        declaration, inputs = join_windows(declaration, _needed(declaration, inputs, params), params)
        images = fit_inputs(declaration, inputs)
        values = check_params(declaration, params)
        if not declaration.mixes:
            return _call(declaration, context, images, values)
        mask, mix = images.pop(MASK.name, None), values.pop(MIX.name)
        first = declaration.outputs[0].name
        image = images[declaration.over]
        if mix == 0 and wanted == {first} and declaration.windows == "first":
            return {first: copy(image)}
        outputs = _call(declaration, context, images, values)
        if declaration.windows == "union" and first in outputs:
            image = _as_result(image, outputs[first])
        return _mix_over(image, outputs, first, mask, mix)


def call_sink(declaration: Node, context: Context, inputs: NodeInputs, params: Mapping[str, Any]) -> Any:
    """Call a node without outputs, such as ``write``, and return what its function returns.

    Inputs and parameters are treated, and errors raised, as by :func:`call_node`.
    """
    context = replace(context, node=context.node or declaration.type)
    with error_boundary(context.node, context.frame):
        declaration, inputs = join_windows(declaration, _needed(declaration, inputs, params), params)
        images = fit_inputs(declaration, inputs)
        return declaration.run(context, **images, **check_params(declaration, params))


# ---------------------------------------------------------------------- before: inputs and parameters


def _needed(declaration: Node, inputs: NodeInputs, params: Mapping[str, Any]) -> NodeInputs:
    """Return the inputs that the node needs with these parameters."""
    if declaration.needs is None:
        return inputs
    return {name: inputs[name] for name in declaration.needed(inputs, check_params(declaration, params))}


def fit_inputs(declaration: Node, inputs: Mapping[str, Image]) -> dict[str, Image]:
    """Return the inputs as the node's function gets them: each of a type its port takes, all on one data window.

    Raises
    ------
    FlowabsError
        unknown-input, missing-input, wrong-type or window-mismatch.
    """
    ports = declaration.all_inputs
    for name in inputs:
        if declaration.input(name) is None:
            raise FlowabsError(
                f"{declaration.name} has no input {name!r}", code="unknown-input", hint=nearest(name, ports)
            )
        if name not in ports and (name in declaration.all_params or name == "context"):
            raise FlowabsError(f"an extra input cannot be called {name!r}: that is a parameter", code="unknown-input")
    for name, port in ports.items():
        if name not in inputs and not port.optional and declaration.needs is None:
            raise FlowabsError(f"input {name!r} is not connected: {port.help}", code="missing-input")
    for name, port in ports.items():
        if name in inputs and port.beside and port.beside not in inputs:
            raise FlowabsError(f"input {name!r} needs {port.beside!r} too", code="missing-input")
    if declaration.one_of and not any(name in inputs for name in declaration.one_of):
        raise FlowabsError(f"connect at least one of {', '.join(declaration.one_of)}", code="missing-input")
    declared = {name: inputs[name] for name in ports if name in inputs}
    images = {name: _widen(declaration, name, image) for name, image in (declared | dict(inputs)).items()}
    first = next(iter(declared), None)
    if first is None or declaration.windows == "own":
        return images
    if declaration.windows == "display":
        images[first] = on_display(images[first])
    if declaration.windows == "union":
        images |= on_union({name: image for name, image in images.items() if not ports[name].cut})
    window = images[first].data_window
    for name, image in images.items():
        if image.data_window == window:
            continue
        may_be_cut = name not in declared or ports[name].cut or _holds(image, images[first])
        if not may_be_cut:
            raise FlowabsError(
                f"input {name!r} has the data window {_describe(image.data_window)}, "
                f"but input {first!r} has {_describe(window)}",
                code="window-mismatch",
                hint=_files(images, name, first),
            )
        if name in declared:
            check_picture_size(name, image, images[first], first)
        images[name] = image.on_window(window)
    return images


def _holds(image: Image, other: Image) -> bool:
    """Return whether an image has every pixel of the data window of another one, of pictures of one size."""
    return around(image.data_window, other.data_window) == image.data_window and (
        image.display_window == other.display_window
    )


def _files(images: Mapping[str, Image], *names: str) -> str:
    """Return of which files some inputs are; empty where that is not known of all, or all are of one."""
    files = {name: origin.file for name in names if (origin := images[name].origin) is not None}
    if len(files) < len(names) or len(set(files.values())) < 2:
        return ""
    return ", ".join(f"{name} is of {os.path.basename(file)}" for name, file in files.items())


def _widen(declaration: Node, name: str, image: Image) -> Image:
    """Return ``image`` as the type that the input ``name`` takes."""
    port = declaration.input(name)
    assert port is not None
    kind = port.takes(image.type)
    if kind is None:
        accepted = port.types.replace("|", " or ")
        raise FlowabsError(f"input {name!r} takes {accepted}, not {image.type}", code="wrong-type")
    return image.as_type(kind)


def check_params(declaration: Node, params: Mapping[str, Any]) -> dict[str, Any]:
    """Return every parameter of the node in the type its function gets, defaults filled in.

    Raises
    ------
    ArgumentError
        unknown-param, missing-param, or what is wrong with a value.
    """
    known = declaration.all_params
    for name in params:
        if name not in known:
            hint = nearest(name, known)
            raise ArgumentError(f"{declaration.name} has no parameter {name!r}", code="unknown-param", hint=hint)
    values = declaration.defaults() | dict(params)
    for name, param in known.items():
        if name not in values:
            raise ArgumentError(f"needs a value: {param.expected}", code="missing-param", parameter=name)
    return {name: param.check(values[name]) for name, param in known.items()}


def _describe(window: Window) -> str:
    """Return a window in words: "1920x1080+0-10"."""
    return f"{window.width}x{window.height}{window.x:+d}{window.y:+d}"


# ---------------------------------------------------------------------- the node itself


def _call(
    declaration: Node, context: Context, images: Mapping[str, Image], values: Mapping[str, Any]
) -> dict[str, Image]:
    """Call the node's function and check what it returns against the declaration."""
    optional = {port.name: images.get(port.name) for port in declaration.inputs}
    result = declaration.run(context, **{**optional, **images}, **values)
    found = result if isinstance(result, dict) else {declaration.outputs[0].name: result}
    outputs = {}
    for name, port in declaration.all_outputs.items():
        if name not in context.wanted:
            continue
        image = found.get(name)
        if not isinstance(image, Image):
            raise _wrong_output(declaration, name, f"an Image, the node returned {_kind(image)}")
        given = [images[name].type for name in port.follows if name in images]
        kinds = (widest(given) or given[0],) if given else port.accepts
        if image.type not in kinds:
            raise _wrong_output(declaration, name, f"{' or '.join(kinds)}, the node returned {image.type}")
        outputs[name] = _restore_metadata(images, image, declaration, name)
    return outputs


def _kind(value: object) -> str:
    """Return in words what a node returned in place of an image."""
    if isinstance(value, np.ndarray):
        return f"an array of {value.dtype} {value.shape}: image.with_pixels(array) makes an Image"
    return type(value).__name__


def _restore_metadata(images: Mapping[str, Image], image: Image, declaration: Node, name: str) -> Image:
    """Return an output with what the node lost of the first input's metadata and origin.

    Raises
    ------
    FlowabsError
        wrong-output, where its windows are not those of the first input.
    """
    source = next(iter(images.values()), None)
    if source is None:
        return image
    found, expected = (image.data_window, image.display_window), (source.data_window, source.display_window)
    if found != expected and declaration.windows != "own":
        raise _wrong_output(
            declaration,
            name,
            f"the windows of its input ({' in '.join(map(_describe, expected))}), the node returned "
            f"{' in '.join(map(_describe, found))}: make outputs with image.with_pixels(...)",
        )
    spec, metadata = image.spec, source.spec.extra_attribs
    present = {attribute.name for attribute in spec.extra_attribs}
    lost = [attribute for attribute in metadata if attribute.name not in present]
    if not lost and image.origin == source.origin:
        return image
    for attribute in lost:
        spec.attribute(attribute.name, attribute.type, attribute.value)
    pixels = image.deferred or image.pixels
    return Image(pixels, spec, image.type, colorspace=image.colorspace, origin=source.origin)


def _wrong_output(declaration: Node, name: str, what: str) -> FlowabsError:
    """Return the error for an output that is not ``what`` it must be."""
    return FlowabsError(f"output {name!r} of {declaration.name} must be {what}", code="wrong-output")


# ---------------------------------------------------------------------- after: mask and mix


def _mix_over(image: Image, outputs: dict[str, Image], first: str, mask: Image | None, mix: float) -> dict[str, Image]:
    """Lay each result over the input by k = mask x mix, alpha too; an id is the result's where k is at least 1/2.

    A color output beside the first, such as an ink alone, is multiplied by k.
    """
    if mask is None and mix == 1:
        return outputs
    k = np.full((1, 1, 1), mix, np.float32) if mask is None else np.clip(mask.pixels, 0, 1) * np.float32(mix)
    mixed = {}
    for name, result in outputs.items():
        if name != first:
            mixed[name] = result.with_pixels(result.pixels * k) if result.type == "color" else result
        elif mix == 0:
            mixed[name] = copy(image)
        elif result.channels != image.channels:
            raise FlowabsError(
                f"output {name!r} must have the channels of the input to be mixed with it, {','.join(image.channels)}, "
                f"the node returned {','.join(result.channels)}",
                code="wrong-output",
            )
        elif not pixel_type(result.type).blends:
            mixed[name] = result.with_pixels(np.where(k >= 0.5, result.pixels, image.pixels))
        else:
            # The weights' sum is exactly 1 at both ends, so that k = 0 and k = 1 change no bit.
            pixels = result.pixels * k
            pixels += image.pixels * (1 - k)
            mixed[name] = result.with_pixels(pixels)
    return mixed


def _as_result(image: Image, result: Image) -> Image:
    """Return the input that a result goes over in the result's type; opaque, where only the result has alpha."""
    image = image.as_type(result.type)
    return with_alpha(image) if "A" in result.channels and result.type == "color" else image
