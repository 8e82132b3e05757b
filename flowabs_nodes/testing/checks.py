"""Checks of a node: what all nodes promise, apart from what each parameter has to do."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping
from functools import partial
from itertools import combinations
from typing import Any

import numpy as np

from flowabs_nodes.engine.call_node import call_node, call_sink
from flowabs_nodes.engine.error_boundary import InternalError
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.image import PORT_TYPES, Image
from flowabs_nodes.io.output_image import build_picture
from flowabs_nodes.io.settings import Settings
from flowabs_nodes.io.write import save
from flowabs_nodes.nodes.declare import MASK, Context, Node
from flowabs_nodes.nodes.param import Param
from flowabs_nodes.port_types import pixel_type
from flowabs_nodes.simd import bands
from flowabs_nodes.testing.parameters import alternatives
from flowabs_nodes.testing.pictures import SCENES, make_input
from flowabs_nodes.testing.running import ComplianceError, equal, finite, inputs_of, require, run_node

#: Frames that a node without windows of time is run on: neighbours, and such as are far away.
_FRAMES = (1, 2, 3, 6, 1001)


def is_documented(node: Node) -> None:
    """Check that node, ports and parameters have a help text, and that defaults and soft ranges are allowed values."""
    extra = (node.extra_inputs,) if node.extra_inputs else ()
    for kind, name, text in (
        ("node", node.name, node.help),
        *(("input", port.name, port.help) for port in (*node.inputs, *extra)),
        *(("output", port.name, port.help) for port in node.outputs),
        *(("parameter", param.name, param.help) for param in node.params),
    ):
        require(len(text.split()) >= 1 and text.strip() == text, f"{kind} {name} needs a help text")
    for kind, name, text in (
        ("label of the node", node.name, node.label),
        ("category of the node", node.name, node.category),
        *(("label of the parameter", param.name, param.label) for param in node.params),
    ):
        require(len(text.split()) >= 1 and text.strip() == text, f"{kind} {name} must be a text")
    for param in node.params:
        if not param.required:
            param.check(param.default)
        for value in param.soft or ():
            inside = (param.min is None or value >= param.min) and (param.max is None or value <= param.max)
            require(inside, f"parameter {param.name}: the soft range {param.soft} must lie in the hard range")


def runs_with_defaults(node: Node) -> None:
    """Check that on every scene, with optional inputs and without, outputs are finite and mattes 0 to 1."""
    for scene in SCENES:
        for optional in (True, False):
            for name, image in run_node(node, inputs_of(node, scene, optional=optional)).items():
                require(finite(image), f"{scene}: output {name!r} is not finite")
                if image.type == "matte":
                    low, high = float(image.pixels.min()), float(image.pixels.max())
                    require(0 <= low <= high <= 1, f"{scene}: matte {name!r} must be 0 to 1, it is {low:g} to {high:g}")


def takes_small_pictures(node: Node) -> None:
    """Check that outputs are finite on pictures of one pixel, one row and one column."""
    for height, width in ((1, 1), (1, 7), (7, 1), (2, 2)):
        for scene in SCENES:
            for name, image in run_node(node, inputs_of(node, scene, height, width)).items():
                require(finite(image), f"{width}x{height}: output {name!r} is not finite")


def takes_every_type(node: Node) -> None:
    """Check that outputs are finite for each port type that an input declares."""
    for port in node.inputs:
        for kind in (kind for kind in PORT_TYPES if port.takes(kind)):
            changed = {port.name: make_input(kind, "shapes", 20, 24)}
            outputs = run_node(node, inputs_of(node, "shapes") | changed)
            require(all(map(finite, outputs.values())), f"{kind} into {port.name!r}: not finite")


def keeps_windows_and_metadata(node: Node) -> None:
    """Check that windows, origin, metadata and colour space of the first input are the outputs' too.

    A node that declares windows of its own, or that it converts, may change these.
    """
    inputs = inputs_of(node, "alpha")
    if not inputs:
        return
    first = next(iter(inputs.values()))
    for name, image in run_node(node, inputs).items():
        windows = ("data_window", "display_window") if node.windows != "own" else ()
        for what in (*windows, "origin"):
            found, expected = getattr(image, what), getattr(first, what)
            require(found == expected, f"output {name!r}: {what} {found}, its input's is {expected}")
        for attribute in first.spec.extra_attribs:
            found = image.spec.getattribute(attribute.name)
            require(found == attribute.value, f"output {name!r}: metadata {attribute.name!r} is {found!r}")
        if image.type == first.type == "color" and not node.converts:
            require(image.colorspace == first.colorspace, f"output {name!r}: colour space {image.colorspace}")


def leaves_inputs_alone(node: Node) -> None:
    """Check that a run writes on none of its inputs' arrays: they are read-only, and their pixels the same after it."""
    for scene in SCENES:
        inputs = inputs_of(node, scene)
        before = {name: image.pixels.copy() for name, image in inputs.items()}
        try:
            run_node(node, inputs)
        except InternalError as error:
            raise ComplianceError(f"{scene}: {error}") from error
        for name, image in inputs.items():
            require(np.array_equal(before[name], image.pixels), f"{scene}: input {name!r} was changed")


def survives_nan_and_inf(node: Node) -> None:
    """Check that a NaN or Inf in one pixel is refused with a clean error, or stays in its pixel."""
    for name in inputs_of(node, "shapes"):
        for bad in (np.nan, np.inf, -np.inf):
            inputs = inputs_of(node, "shapes")
            if inputs[name].pixels.dtype.kind != "f":
                continue  # ids are always finite
            pixels = inputs[name].pixels.copy()
            pixels[3, 5, 0] = bad
            inputs[name] = inputs[name].with_pixels(pixels)
            try:
                with np.errstate(all="ignore"):
                    outputs = run_node(node, inputs)
            except InternalError as error:
                raise ComplianceError(f"{bad} in {name!r}: {error}") from error
            except FlowabsError:
                continue  # a clean refusal
            for output, image in outputs.items():
                spread = np.logical_not(np.isfinite(image.pixels).all(axis=2))
                spread[3, 5] = False
                require(not spread.any(), f"{bad} in one pixel of {name!r} spreads in output {output!r}")


def gives_the_same_again(node: Node) -> None:
    """Check that an output has the same bits when it is computed again, and alone."""
    for scene in SCENES:
        together = run_node(node, inputs_of(node, scene))
        for name, image in together.items():
            alone = run_node(node, inputs_of(node, scene), wanted=name)
            require(equal(alone[name], image), f"{scene}: output {name!r} differs when it is asked for alone")


def owes_to_the_frame_what_it_says(node: Node) -> None:
    """Check that results on two frames differ only where ``moment`` does, and with it where ``moment`` differs at all.

    The inputs are the same on all frames. Beside the defaults each other value of a parameter is tried.
    """
    several = [{param.name: value} for param in node.params for value in alternatives(param)] if node.moment else []
    differs, says = False, False
    for settings in ({}, *several):
        values, inputs = node.defaults() | settings, inputs_of(node, "shapes")
        moments = [None if node.moment is None else node.moment(values, frame) for frame in _FRAMES]
        results = [run_node(node, inputs, settings, frame=frame) for frame in _FRAMES]
        for i, j in combinations(range(len(_FRAMES)), 2):
            same = all(equal(results[i][name], results[j][name]) for name in results[i])
            frames = f"frames {_FRAMES[i]} and {_FRAMES[j]}"
            require(same or moments[i] != moments[j], f"{frames} differ beside {settings}, but not in their moment")
            differs, says = differs or not same, says or moments[i] != moments[j]
    require(differs == says, "frames differ in their moment, but not in any picture")


def same_on_any_number_of_threads(node: Node) -> None:
    """Check that outputs have the same bits on one thread, two, and all."""
    inputs = partial(inputs_of, node, "noise", 37, 41)
    expected = run_node(node, inputs())
    for count in {1, 2, bands.available_threads()}:
        with bands.limited(count):
            for name, image in run_node(node, inputs()).items():
                require(equal(image, expected[name]), f"output {name!r} differs on {count} threads")


def mixes(node: Node) -> None:
    """Check that mask and mix give the input at 0, the result at 1, and half of each at 0.5, for each type.

    Of what has no mean, such as ids, each pixel at 0.5 must be the input's or the result's.
    """
    alike = node.outputs[0].follows or (node.over,)
    for kind in node.all_inputs[node.over].accepts:
        _mixes(node, inputs_of(node, "alpha") | {name: make_input(kind, "alpha", 20, 24) for name in alike})


def _mixes(node: Node, inputs: dict[str, Image]) -> None:
    """Check mask and mix on these inputs."""
    image, first = inputs[node.over], node.outputs[0].name

    def result(inputs: Mapping[str, Image], params: Mapping[str, Any]) -> Image:
        """Return the node's first output on the input's data window, which it may reach beyond."""
        return run_node(node, inputs, params)[first].on_window(image.data_window)

    full = result(inputs, {})
    require(equal(result(inputs, {"mix": 0}), image), "mix 0 must give the input")
    half = np.zeros(image.pixels.shape[:2], np.float32)
    half[:, ::2] = 1
    masked = result(inputs | {MASK.name: image.with_pixels(half, "matte")}, {}).pixels
    require(np.array_equal(masked[:, ::2], full.pixels[:, ::2]), "where the mask is 1 the result must stand")
    require(np.array_equal(masked[:, 1::2], image.pixels[:, 1::2]), "where the mask is 0 the input must stand")
    between = result(inputs, {"mix": 0.5}).pixels
    if not pixel_type(full.type).blends:
        either = (between == image.pixels) | (between == full.pixels)
        require(bool(either.all()), f"mix 0.5 of {full.type} must be the input's value or the result's")
        return
    require(np.allclose(between, (image.pixels + full.pixels) / 2, atol=1e-5), "mix 0.5 must be half-way")


def mask_of_one_is_no_mask(node: Node) -> None:
    """Check of a node with a mask of its own that 1 everywhere, to rounding, is as if none were connected."""
    for scene in SCENES:
        inputs = inputs_of(node, scene)
        ones = inputs[MASK.name].with_pixels(np.ones_like(inputs[MASK.name].pixels))
        masked = run_node(node, inputs | {MASK.name: ones})
        del inputs[MASK.name]
        for name, image in run_node(node, inputs).items():
            same = np.allclose(masked[name].pixels, image.pixels, rtol=1e-3, atol=1e-3)
            require(same, f"{scene}: a mask of 1 changes output {name!r}")


# ---------------------------------------------------------------------- nodes that read or write files


def reads_or_takes_a_picture(node: Node, param: Param) -> None:
    """Check that a node that reads finds finite images in an EXR of all types, or that one that writes takes them all.

    Layers are called by their types: depth.Z, normal.X, id.id and so on.
    """
    with tempfile.TemporaryDirectory() as folder:
        context, file = Context(node=node.type, services=Settings()), os.path.join(folder, "picture.exr")
        if param.role == "input":
            layers = {kind: make_input(kind, "shapes", 20, 24) for kind in PORT_TYPES}
            plate = make_input("color", "alpha", 20, 24)
            save(build_picture(Image(plate.pixels, plate.spec, "color"), layers), file)
            for name, image in call_node(node, context, {}, {param.name: file}).items():
                require(finite(image), f"output {name!r} is not finite")
            return
        for port in node.inputs:
            for kind in (kind for kind in PORT_TYPES if port.takes(kind)):
                layers = {f"layer_{each}": make_input(each, "shapes", 20, 24) for each in PORT_TYPES}
                inputs = {port.name: make_input(kind, "alpha", 20, 24), **(layers if node.extra_inputs else {})}
                call_sink(node, context, inputs, {param.name: file})
