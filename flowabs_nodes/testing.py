"""The compliance suite that every node should pass, ours or a plugin's.

::

    import pytest
    from flowabs_nodes.testing import compliance_checks
    from my_package import MY_NODE

    @pytest.mark.parametrize("check", compliance_checks(MY_NODE), ids=lambda check: check.name)
    def test_compliance(check):
        check()

Or, without pytest, ``check_node(MY_NODE)``. It asks of a node that

- it is documented, every port and parameter too, and its defaults and soft ranges lie inside the hard ones;
- it runs with its defaults on any picture: colour, noise, alpha, HDR, 1x1, 1xN, Nx1, and for each type its ports take;
- each parameter changes the key and, on some picture and perhaps with other parameters set, the result;
- windows, metadata and colour space are kept, and its inputs are left as they were;
- NaN and Inf give a clean error, or stay in the pixels where they were;
- an output comes out the same whether asked for alone or with others, a second time, and on any number of threads;
- a node that mixes gives the input where mask or mix is 0, the result where both are 1.

Nodes that read or write files are held to what does not need a picture's content.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, cast

import numpy as np

from flowabs_nodes.engine.apply import apply, deliver
from flowabs_nodes.engine.failures import InternalError
from flowabs_nodes.engine.keys import node_key
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.image import PORT_TYPES, Array, Image, PortType
from flowabs_nodes.io.settings import Settings
from flowabs_nodes.nodes.declare import MASK, Context, Node, Param
from flowabs_nodes.testing_pictures import SCENES, make_input

__all__ = ["Check", "ComplianceError", "check_node", "compliance_checks"]


class ComplianceError(AssertionError):
    """A node does not do what every node should."""


@dataclass(frozen=True)
class Check:
    """One thing to ask of a node; calling it raises :class:`ComplianceError` where the answer is no."""

    name: str
    run: Callable[[], None]

    def __call__(self) -> None:
        self.run()


def compliance_checks(node: Node) -> list[Check]:
    """Everything to ask of ``node``, by name."""
    checks: dict[str, Callable[[], None]] = {"is_documented": partial(_is_documented, node)}
    for param in node.all_params.values():
        if param.kind != "file":  # a file counts by its content
            checks[f"{param.name}_changes_the_key"] = partial(_changes_the_key, node, param)
    if node.file_param is not None:
        checks["reads_or_takes_a_picture"] = partial(_reads_or_takes_a_picture, node, node.file_param)
    else:
        checks |= {
            "runs_with_defaults": partial(_runs_with_defaults, node),
            "takes_small_pictures": partial(_takes_small_pictures, node),
            "takes_every_type_it_declares": partial(_takes_every_type, node),
            "keeps_windows_and_metadata": partial(_keeps_windows_and_metadata, node),
            "leaves_inputs_alone": partial(_leaves_inputs_alone, node),
            "survives_nan_and_inf": partial(_survives_nan_and_inf, node),
            "gives_the_same_again": partial(_gives_the_same_again, node),
            "gives_the_same_bits_on_any_number_of_threads": partial(_same_on_any_number_of_threads, node),
        }
        if node.mixes:
            checks["mixes"] = partial(_mixes, node)
        for param in node.all_params.values():
            if param.in_key:
                checks[f"{param.name}_changes_the_picture"] = partial(_changes_the_picture, node, param)
    return [Check(name, run) for name, run in checks.items()]


def check_node(node: Node) -> None:
    """Ask everything of ``node``; one :class:`ComplianceError` names all that is not as it should be."""
    failures = []
    for check in compliance_checks(node):
        try:
            check()
        except (ComplianceError, FlowabsError) as error:
            failures.append(f"{check.name}: {error}")
    _require(not failures, f"{node.name}:\n" + "\n".join(failures))


def _require(holds: bool, otherwise: str) -> None:
    if not holds:
        raise ComplianceError(otherwise)


# ---------------------------------------------------------------------- the declaration


def _is_documented(node: Node) -> None:
    extra = (node.extra_inputs,) if node.extra_inputs else ()
    for kind, name, text in (
        ("node", node.name, node.help),
        *(("input", port.name, port.help) for port in (*node.inputs, *extra)),
        *(("output", port.name, port.help) for port in node.outputs),
        *(("parameter", param.name, param.help) for param in node.params),
    ):
        _require(len(text.split()) >= 1 and text.strip() == text, f"{kind} {name} needs a help text")
    for param in node.params:
        if not param.required:
            param.check(param.default)
        for value in param.soft or ():
            inside = (param.min is None or value >= param.min) and (param.max is None or value <= param.max)
            _require(inside, f"parameter {param.name}: the soft range {param.soft} must lie in the hard range")


def _changes_the_key(node: Node, param: Param) -> None:
    defaults = _known_params(node)
    before = node_key(node, defaults, {})
    for value in alternatives(param):
        after = node_key(node, defaults | {param.name: value}, {})
        _require((after != before) == param.in_key, f"{param.name} = {value!r}: key {'un' * param.in_key}changed")


# ---------------------------------------------------------------------- pictures in, pictures out


def _run(
    node: Node, inputs: Mapping[str, Image], params: Mapping[str, Any] | None = None, wanted: str = ""
) -> dict[str, Image]:
    context = Context(node=node.type, wanted=frozenset({wanted} if wanted else ()))
    return apply(node, context, inputs, _known_params(node) | dict(params or {}))


def _known_params(node: Node) -> dict[str, Any]:
    """The defaults, and some value for what has none."""
    required = {param.name: next(alternatives(param)) for param in node.all_params.values() if param.required}
    return node.defaults() | required


def _inputs(node: Node, scene: str, height: int = 20, width: int = 24, optional: bool = True) -> dict[str, Image]:
    """An image for each declared input but the mask, each of the first type its port takes."""
    return {
        port.name: make_input(cast(PortType, port.accepts[0]), scene, height, width)
        for port in node.inputs
        if optional or not port.optional
    }


def _runs_with_defaults(node: Node) -> None:
    for scene in SCENES:
        for optional in (True, False):
            for name, image in _run(node, _inputs(node, scene, optional=optional)).items():
                _require(_finite(image), f"{scene}: output {name!r} is not finite")
                if image.type == "matte":
                    low, high = float(image.pixels.min()), float(image.pixels.max())
                    _require(
                        0 <= low <= high <= 1, f"{scene}: matte {name!r} must be 0 to 1, it is {low:g} to {high:g}"
                    )


def _takes_small_pictures(node: Node) -> None:
    for height, width in ((1, 1), (1, 7), (7, 1), (2, 2)):
        for scene in SCENES:
            for name, image in _run(node, _inputs(node, scene, height, width)).items():
                _require(_finite(image), f"{width}x{height}: output {name!r} is not finite")


def _takes_every_type(node: Node) -> None:
    for port in node.inputs:
        for kind in (kind for kind in PORT_TYPES if port.takes(kind)):
            changed = {port.name: make_input(kind, "shapes", 20, 24)}
            outputs = _run(node, _inputs(node, "shapes") | changed)
            _require(all(map(_finite, outputs.values())), f"{kind} into {port.name!r}: not finite")


def _keeps_windows_and_metadata(node: Node) -> None:
    inputs = _inputs(node, "alpha")
    if not inputs:
        return
    first = next(iter(inputs.values()))
    for name, image in _run(node, inputs).items():
        for what in ("data_window", "display_window", "origin"):
            found, expected = getattr(image, what), getattr(first, what)
            _require(found == expected, f"output {name!r}: {what} {found}, its input's is {expected}")
        for attribute in first.spec.extra_attribs:
            found = image.spec.getattribute(attribute.name)
            _require(found == attribute.value, f"output {name!r}: metadata {attribute.name!r} is {found!r}")
        if image.type == first.type == "color":
            _require(image.colorspace == first.colorspace, f"output {name!r}: colour space {image.colorspace}")


def _leaves_inputs_alone(node: Node) -> None:
    for scene in SCENES:
        inputs = _inputs(node, scene)
        before = {name: _content(image) for name, image in inputs.items()}
        _run(node, inputs)
        for name, image in inputs.items():
            same = all(np.array_equal(a, b) for a, b in zip(before[name], _content(image, copy=False), strict=True))
            _require(same, f"{scene}: input {name!r} was changed")


def _content(image: Image, copy: bool = True) -> list[Array]:
    """The pixels, and the code values that all nodes share."""
    held = [image.pixels]
    if image.type == "color":
        for space in ("lab", "acescct"):
            held += [image.encoded(space), image.encoded_mono(space), image.encoded(space, ground=1.0)]
    return [np.array(each) for each in held] if copy else held


def _survives_nan_and_inf(node: Node) -> None:
    for name in _inputs(node, "shapes"):
        for bad in (np.nan, np.inf, -np.inf):
            inputs = _inputs(node, "shapes")
            pixels = inputs[name].pixels.copy()
            pixels[3, 5, 0] = bad
            inputs[name] = inputs[name].with_pixels(pixels)
            try:
                with np.errstate(all="ignore"):
                    outputs = _run(node, inputs)
            except InternalError as error:
                raise ComplianceError(f"{bad} in {name!r}: {error}") from error
            except FlowabsError:
                continue  # a clean refusal
            for output, image in outputs.items():
                spread = np.logical_not(np.isfinite(image.pixels).all(axis=2))
                spread[3, 5] = False
                _require(not spread.any(), f"{bad} in one pixel of {name!r} spreads in output {output!r}")


def _gives_the_same_again(node: Node) -> None:
    for scene in SCENES:
        together = _run(node, _inputs(node, scene))
        for name, image in together.items():
            alone = _run(node, _inputs(node, scene), wanted=name)
            _require(_equal(alone[name], image), f"{scene}: output {name!r} differs when it is asked for alone")


def _same_on_any_number_of_threads(node: Node) -> None:
    inputs = partial(_inputs, node, "noise", 37, 41)
    expected = _run(node, inputs())
    if "numba" not in sys.modules:
        return
    import numba

    most = numba.get_num_threads()
    try:
        for threads in {1, 2, numba.config.NUMBA_NUM_THREADS}:
            if threads <= numba.config.NUMBA_NUM_THREADS:
                numba.set_num_threads(threads)
                for name, image in _run(node, inputs()).items():
                    _require(_equal(image, expected[name]), f"output {name!r} differs on {threads} threads")
    finally:
        numba.set_num_threads(most)


def _mixes(node: Node) -> None:
    inputs = _inputs(node, "alpha")
    image, first = inputs["image"], node.outputs[0].name
    full = _run(node, inputs)[first]
    _require(_run(node, inputs, {"mix": 0})[first] is image, "mix 0 must give the input itself")
    half = np.zeros(image.pixels.shape[:2], np.float32)
    half[:, ::2] = 1
    masked = _run(node, inputs | {MASK.name: image.with_pixels(half, "matte")})[first].pixels
    _require(np.array_equal(masked[:, ::2], full.pixels[:, ::2]), "where the mask is 1 the result must stand")
    _require(np.array_equal(masked[:, 1::2], image.pixels[:, 1::2]), "where the mask is 0 the input must stand")
    between = _run(node, inputs, {"mix": 0.5})[first].pixels
    _require(np.allclose(between, (image.pixels + full.pixels) / 2, atol=1e-5), "mix 0.5 must be half-way")


# ---------------------------------------------------------------------- nodes that read or write files


def _reads_or_takes_a_picture(node: Node, param: Param) -> None:
    """One that reads gives finite images of a small EXR; one that writes takes every type of image, and layers."""
    with tempfile.TemporaryDirectory() as folder:
        context, file = Context(node=node.type, services=Settings()), os.path.join(folder, "picture.exr")
        if param.role == "input":
            make_input("color", "alpha", 20, 24).to_imagebuf().write(file)
            for name, image in apply(node, context, {}, {param.name: file}).items():
                _require(_finite(image), f"output {name!r} is not finite")
            return
        for port in node.inputs:
            for kind in (kind for kind in PORT_TYPES if port.takes(kind)):
                layers = {f"layer_{each}": make_input(each, "shapes", 20, 24) for each in PORT_TYPES}
                inputs = {port.name: make_input(kind, "alpha", 20, 24), **(layers if node.extra_inputs else {})}
                deliver(node, context, inputs, {param.name: file})


# ---------------------------------------------------------------------- each parameter changes the picture


def _changes_the_picture(node: Node, param: Param) -> None:
    tried = 0
    for settings in _surroundings(node, param):
        for scene in SCENES:
            inputs = _inputs(node, scene)
            before = _try(node, inputs, settings)
            for value in alternatives(param):
                after = _try(node, inputs, settings | {param.name: value})
                tried += 1
                if before and after and not all(_equal(before[name], after[name]) for name in before):
                    return
    raise ComplianceError(
        f"{param.name} changes nothing, on {len(SCENES)} pictures in {tried} combinations of parameters"
    )


def _try(node: Node, inputs: Mapping[str, Image], params: Mapping[str, Any]) -> dict[str, Image] | None:
    try:
        return _run(node, inputs, params)
    except InternalError:
        raise
    except FlowabsError:
        return None  # a combination that the node refuses


def _surroundings(node: Node, param: Param) -> Iterator[dict[str, Any]]:
    """Values for the other parameters: the defaults, then one of them changed, then two."""
    others = [other for other in node.params if other.name != param.name and not other.required]
    single = [{other.name: value} for other in others for value in list(alternatives(other))[:3]]
    yield {}
    yield from single
    for i, one in enumerate(single):
        for two in single[:i]:
            if one.keys() != two.keys():
                yield one | two


def alternatives(param: Param) -> Iterator[Any]:
    """Values to try beside the default: mild ones first, and none that is wrong or the default itself."""
    default = param.default
    guesses: list[Any] = []
    match param.kind:
        case "float" | "int":
            guesses += [*(param.soft or ()), param.min, param.max]
            if default is not None:
                guesses += [default * 2, default / 2, default + 1]
            guesses = [round(guess) if param.kind == "int" else float(guess) for guess in guesses if guess is not None]
            guesses += [1, 0]
        case "bool":
            guesses += [not default]
        case "enum":
            guesses += param.choices
        case "color":
            guesses += [(1.0, 0.5, 0.25), (0.0, 0.0, 1.0)]
        case "string" | "file":
            guesses += ["other", ""]
        case "custom":
            schema = param.schema
            guesses += [*schema.get("examples", ()), *schema.get("enum", ())]
            guesses += [
                1.0,
                16.0,
                0.5,
                100.0,
                1,
                2,
                "max",
                "p50",
                "other",
                True,
                False,
                [],
                {},
                {"name": "value"},
                ["name"],
            ]
    if param.nullable:
        guesses.append(None)
    tried: list[Any] = [] if param.required else [default]
    for guess in guesses:
        if guess not in tried and param.problem(guess) is None:
            tried.append(guess)
            yield guess


def _equal(a: Image, b: Image) -> bool:
    return a.type == b.type and np.array_equal(a.pixels, b.pixels, equal_nan=True)


def _finite(image: Image) -> bool:
    return bool(np.isfinite(image.pixels).all())
