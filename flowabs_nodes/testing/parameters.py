"""Checks of a parameter: it changes the key, and on some picture the result, but neither where it is disabled."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from flowabs_nodes.engine.error_boundary import InternalError
from flowabs_nodes.engine.keys import node_key
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Node
from flowabs_nodes.nodes.param import Param
from flowabs_nodes.testing.pictures import SCENES
from flowabs_nodes.testing.running import ComplianceError, equal, inputs_of, require, run_node

#: Values that a custom parameter might take.
_SHAPES: tuple[Any, ...] = (1.0, 16.0, 0.5, 100, 1, 2, "max", "p50", "other", True, False, [], {}, ["a"], {"a": "b"})


def changes_the_key(node: Node, param: Param) -> None:
    """Check that every value gives another key than the default, or none does if the parameter is not in the key."""
    settings = node.defaults() | _enabling(node, param)
    before = node_key(node, settings, {})
    for value in alternatives(param):
        after = node_key(node, settings | {param.name: value}, {})
        require((after != before) == param.in_key, f"{param.name} = {value!r}: key {'un' * param.in_key}changed")


def changes_the_picture(node: Node, param: Param) -> None:
    """Check that on some scene, beside some values of the other parameters, some value changes some output."""
    tried = 0
    for settings in _surroundings(node, param):
        for inputs in _all_inputs(node):
            before = _try(node, inputs, settings)
            for value in alternatives(param):
                after = _try(node, inputs, settings | {param.name: value})
                tried += 1
                if before and after and not all(equal(before[name], after[name]) for name in before):
                    return
    raise ComplianceError(
        f"{param.name} changes nothing, on {len(SCENES)} pictures in {tried} combinations of parameters"
    )


def _all_inputs(node: Node) -> Iterator[dict[str, Image]]:
    """Yield inputs of every scene, of several scenes at once, and without the optional ones, where a node has any."""
    yield from (inputs_of(node, scene) for scene in SCENES)
    if len(node.inputs) > 1:
        yield {port.name: inputs_of(node, SCENES[i % len(SCENES)])[port.name] for i, port in enumerate(node.inputs)}
    if any(port.optional for port in node.inputs):
        yield from (inputs_of(node, scene, optional=False) for scene in SCENES)


def nothing_where_disabled(node: Node, param: Param) -> None:
    """Check that no value changes the key or any output beside the values of other parameters that disable this one."""
    for settings in _disabling(node, param):
        key = node_key(node, node.defaults() | settings, {})
        for scene in SCENES if node.file_param is None else ():
            inputs = inputs_of(node, scene)
            before = _try(node, inputs, settings)
            for value in alternatives(param):
                after = _try(node, inputs, settings | {param.name: value})
                same = before and after and all(equal(before[name], after[name]) for name in before)
                require(bool(same), f"{param.name} = {value!r} changes the result, though {settings} disables it")
        for value in alternatives(param):
            same_key = node_key(node, node.defaults() | settings | {param.name: value}, {}) == key
            require(same_key, f"{param.name} = {value!r} changes the key, though {settings} disables it")


def _enabling(node: Node, param: Param) -> dict[str, Any]:
    """Return the values of other parameters, if defaults will not do, beside which ``param`` does something."""
    if node.is_enabled(param.name, {}):
        return {}
    return {switch: values[0] for switch, values in param.enabled_when.items()}


def _disabling(node: Node, param: Param) -> Iterator[dict[str, Any]]:
    """Yield a value of another parameter, one at a time, that disables ``param``."""
    for switch in param.enabled_when:
        declared = node.all_params[switch]
        for value in (declared.default, *alternatives(declared)):
            if not node.is_enabled(param.name, _enabling(node, param) | {switch: value}):
                yield {switch: value}


def _try(node: Node, inputs: Mapping[str, Image], params: Mapping[str, Any]) -> dict[str, Image] | None:
    try:
        return run_node(node, inputs, params)
    except InternalError:
        raise
    except FlowabsError:
        return None  # a combination that the node refuses


def _surroundings(node: Node, param: Param) -> Iterator[dict[str, Any]]:
    """Yield values for the others: defaults beside which ``param`` does something, one of them changed, then two."""
    enabling = _enabling(node, param)
    fixed = {param.name, *param.enabled_when}
    others = [other for other in node.params if other.name not in fixed and not other.required]
    single = [{other.name: value} for other in others for value in list(alternatives(other))[:3]]
    yield enabling
    yield from ({**enabling, **one} for one in single)
    for i, one in enumerate(single):
        for two in single[:i]:
            if one.keys() != two.keys():
                yield {**enabling, **one, **two}


def alternatives(param: Param) -> Iterator[Any]:
    """Yield values to try beside the default: mild ones first, and none that is wrong or the default itself."""
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
            guesses += [*param.schema.get("examples", ()), "other", ""]
        case "custom":
            schema = param.schema
            guesses += [*schema.get("examples", ()), *schema.get("enum", ())]
            guesses += _SHAPES
    if param.nullable:
        guesses.append(None)
    tried: list[Any] = [] if param.required else [default]
    for guess in guesses:
        if guess not in tried and param.problem(guess) is None:
            tried.append(guess)
            yield guess
