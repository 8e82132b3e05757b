"""A small catalogue for the graph's tests: every kind of port and parameter, and nothing that runs."""

from __future__ import annotations

from typing import Any

from flowabs_nodes.nodes.declare import Node, Param, Port


def _run(*args: Any, **kwargs: Any) -> Any:
    raise AssertionError("a graph is checked without running anything")


def _reference(value: Any) -> str | None:
    fits = value == "max" or (isinstance(value, int | float) and not isinstance(value, bool) and value >= 0)
    return None if fits else '"max" or a number of at least 0'


IMAGE = Port("image", "color", "A picture.")

NODES = (
    Node(
        "read",
        1,
        "Reads.",
        (),
        (Port("image", "color", "The picture."),),
        (Param.file("file", role="input", help="File."), Param.string("layer", "", help="Layer.")),
        _run,
    ),
    Node(
        "read_aov",
        1,
        "Reads data.",
        (),
        (Port("data", "data", "The data."),),
        (Param.file("file", role="input", help="File."),),
        _run,
    ),
    Node(
        "write",
        1,
        "Writes.",
        (Port("image", "any", "The picture."),),
        (),
        (Param.file("file", role="output", help="File."),),
        _run,
        extra_inputs=Port("layer", "any", "A layer."),
    ),
    Node(
        "flow",
        1,
        "Finds a flow.",
        (IMAGE,),
        (Port("flow", "flow", "The flow."),),
        (
            Param.float("radius", 5.0, min=0, max=100, soft=(2, 15), unit="px", help="Radius."),
            Param.int("iterations", 3, min=0, max=10, soft=(1, 5), help="Passes."),
            Param.enum("kernel", "full", ("full", "separable"), help="Kernel."),
            Param.bool("color", False, help="All channels."),
            Param.custom(
                "reference",
                "max",
                schema={
                    "anyOf": [{"const": "max"}, {"type": "number", "minimum": 0}],
                    "description": '"max" or a number',
                },
                parse=_reference,
                help="What counts as strong.",
            ),
        ),
        _run,
    ),
    Node(
        "lines",
        1,
        "Draws lines.",
        (IMAGE, Port("flow", "flow", "The flow.")),
        (Port("lines", "matte", "The drawing."), Port("response", "mono", "The response.")),
        (
            Param.float("sigma", 1.0, min=0, above=True, max=200, unit="px", help="Width."),
            Param.float("contrast", None, min=0, nullable=True, help="Contrast."),
        ),
        _run,
    ),
    Node(
        "blur",
        1,
        "Blurs.",
        (Port("image", "color|mono|matte", "What to blur."),),
        (Port("image", "=image", "The same kind, blurred."),),
        (Param.float("sigma", 1.0, min=0, help="Sigma."),),
        _run,
    ),
    Node(
        "comp",
        1,
        "Lays lines over a picture.",
        (IMAGE, Port("lines", "matte", "The drawing.")),
        (Port("image", "color", "Both."), Port("ink", "color", "The ink.")),
        (Param.color("ink", (0.0, 0.0, 0.0), help="Ink."), Param.string("note", "", help="A text.")),
        _run,
    ),
    Node(
        "needy",
        1,
        "Has a parameter without a default.",
        (IMAGE,),
        (Port("image", "color", "Out."),),
        (Param("amount", "float", None, "Needed.", min=0, required=True),),
        _run,
    ),
)

CATALOGUE = {node.type: node for node in NODES}


def document(**changes: Any) -> dict[str, Any]:
    """A valid graph that has something of everything; ``changes`` replace top-level keys."""
    return {
        "$schema": "graph.schema.json",
        "format": "flowabs.graph/1",
        "name": "toon",
        "description": "Lines over a picture.",
        "reference_height": 1080,
        "interface": {
            "width": {"type": "float", "default": 1.0, "min": 0.3, "max": 4, "unit": "px", "help": "Width."},
            "calm": {"type": "float", "default": 0.5, "min": 0, "max": 1},
            "passes": {"type": "int", "default": 2, "min": 0, "max": 4},
            "how": {"type": "enum", "default": "full", "choices": ["full", "separable"]},
            "tint": {"type": "color", "default": [0, 0.1, 0]},
            "words": {"type": "string", "default": "hello"},
            "all": {"type": "bool", "default": True},
        },
        "nodes": {
            "plate": {"type": "read@1", "params": {"file": "plate.####.exr"}},
            "field": {
                "type": "flow@1",
                "inputs": {"image": "plate"},
                "params": {
                    "radius": {"from": "calm", "map": [[0, 5], [0.5, 6], [1, 10]]},
                    "iterations": {"from": "passes"},
                    "kernel": {"from": "how"},
                    "color": {"from": "all"},
                    "reference": 16,
                },
            },
            "drawing": {
                "type": "lines@1",
                "inputs": {"image": "plate", "flow": "field"},
                "params": {"sigma": {"from": "width"}, "contrast": {"curve": {"1001": 1, "1011": 2.0}}},
            },
            "soft": {"type": "blur@1", "inputs": {"image": "drawing.lines"}},
            "toon": {
                "type": "comp@1",
                "inputs": {"image": "plate", "lines": "soft", "mask": "drawing"},
                "params": {"ink": {"from": "tint"}, "note": {"from": "words"}, "mix": 0.5},
            },
            "out": {
                "type": "write@1",
                "inputs": {"image": "toon", "ink": "toon.ink", "flow": "field"},
                "params": {"file": "out.####.exr"},
            },
        },
        "ui": {"plate": {"pos": [0, 0], "anything": None}},
    } | changes


def nodes(**entries: Any) -> dict[str, Any]:
    """A graph of these nodes beside a plate, named ``plate``."""
    return {"format": "flowabs.graph/1", "nodes": {"plate": {"type": "read@1"}, **entries}}
