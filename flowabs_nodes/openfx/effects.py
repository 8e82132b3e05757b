"""Describe graphs as OpenFX effects: what ``effects.json`` holds, from which the plug-in describes itself.

A host lists its plug-ins at each start, hence nothing may be started for it: whatever it asks for stands in that file.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import flowabs_nodes
from flowabs_nodes.choices import readable
from flowabs_nodes.engine.plan import sinks
from flowabs_nodes.engine.runnable import load_graph
from flowabs_nodes.engine.unit_params import reads_other_frames
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.graph.model import Graph
from flowabs_nodes.graph.shipped import shipped
from flowabs_nodes.graph.values import Curve, FromKnob
from flowabs_nodes.nodes.declare import Param
from flowabs_nodes.port_types import TYPES
from flowabs_nodes.serve.describing import described

FORMAT = "flowabs.openfx/1"

#: Folders of graphs beside those that come with the package, separated as in ``$PATH``.
GRAPHS_VARIABLE = "FLOWABS_GRAPHS"

#: The colour spaces that a host's pixels may be in: what an artist reads, and the toolkit's name; "" is any by name.
COLORSPACES: Mapping[str, str] = {
    "Scene-linear Rec.709": "lin_rec709",
    "ACEScg": "ACEScg",
    "ACEScct": "ACEScct",
    "sRGB display": "sRGB",
    "DaVinci Intermediate": "DaVinci Intermediate WideGamut",
    "Other, by name": "",
}

#: The most effects that one library can hold: MOST_EFFECTS of the C source.
MOST_EFFECTS = 256

#: The clips that every effect has; no other may be called so.
_CLIPS = ("Source", "Output", "Mask")

#: Said of a graph that looks at other frames: OpenFX gives the server those of the frame at hand.
ALONE = "It steadies its lines by the frames before and after. A host does not give those: flowabs run reads them."

_TYPES = {"float": "double", "int": "int", "enum": "choice", "bool": "boolean", "color": "rgb", "string": "string"}


def effects_document(folders: Iterable[str | os.PathLike[str]] | None = None) -> tuple[dict[str, Any], list[str]]:
    """Return what ``effects.json`` holds, and a sentence for each graph that can be no effect.

    ``folders`` hold graphs of the user's own; None: those that ``$FLOWABS_GRAPHS`` lists.
    """
    effects: dict[str, dict[str, Any]] = {}
    problems = []
    for identifier, source in _graphs(_folders() if folders is None else [Path(each) for each in folders]):
        if len(effects) == MOST_EFFECTS:
            problems.append(f"{source}: a library holds {MOST_EFFECTS} effects at most")
            continue
        if identifier in effects:
            problems.append(f"{source}: another graph is called {Path(source).stem!r} already")
            continue
        try:
            effects[identifier] = effect(identifier, source)
        except FlowabsError as error:
            problems.append(f"{error}" if source in str(error) else f"{source}: {error}")
    document = {"format": FORMAT, "flowabs": flowabs_nodes.__version__, "effects": list(effects.values())}
    return document, problems


def _folders() -> list[Path]:
    """Return the folders that ``$FLOWABS_GRAPHS`` lists."""
    return [Path(each).expanduser() for each in os.environ.get(GRAPHS_VARIABLE, "").split(os.pathsep) if each]


def _graphs(folders: Iterable[Path]) -> Iterator[tuple[str, str]]:
    """Yield an identifier and a source of each graph: the name of one that comes with the package, else a path."""
    for name in shipped():
        yield f"org.flowabs.{name}", name
    for folder in folders:
        for path in sorted(folder.glob("*.json")):
            yield f"org.flowabs.user.{re.sub(r'[^A-Za-z0-9_]', '_', path.stem)}", str(path.resolve())


def effect(identifier: str, source: str) -> dict[str, Any]:
    """Return a graph as an effect. Raises FlowabsError for a graph that is wrong, or that filters no picture."""
    told, graph = described(source, {}, 1), load_graph(source)
    inputs = told["inputs"]
    outputs = [output["name"] for output in told["outputs"] if TYPES[output["type"]].shown]
    if not inputs or not outputs:
        found = "that reads a picture" if not inputs else "whose write gets a picture: color, mono or matte"
        raise FlowabsError(f"expected a graph {found}", code="no-effect")
    labels = _output_labels(graph)
    return {
        "identifier": identifier,
        "label": f"Flowabs {readable(Path(source).stem)}",
        "grouping": "Flowabs",
        "description": f"{told['description']} {ALONE}" if reads_other_frames(graph) else told["description"],
        "graph": source,
        "plate": _given(graph, inputs[0]),
        "clips": _clips(graph, inputs[1:]),
        "outputs": outputs,
        "colorspaces": list(COLORSPACES.values()),
        "varies": _varies(graph),
        "params": _params(graph, told["knobs"], [labels.get(name, readable(name)) for name in outputs]),
    }


# ---------------------------------------------------------------------- clips


def _given(graph: Graph, read: Mapping[str, Any]) -> str:
    """Return the name under which the server is given the picture of a node that reads."""
    node, output = read["node"], read["output"]
    return node if output == next(iter(graph.nodes[node].declaration.all_outputs)) else f"{node}.{output}"


def _clips(graph: Graph, reads: Iterable[Mapping[str, Any]]) -> list[dict[str, str]]:
    """Return the optional clips for what a graph reads beside the plate."""
    found = []
    for read in reads:
        given, channels = _given(graph, read), TYPES[read["type"].partition("|")[0]].rgba
        if not channels:
            continue
        name = given.replace(".", "_")
        name = f"{name}_" if name in _CLIPS else name
        found.append({"name": name, "label": read["label"], "given": given, "channels": channels})
    return found


def _output_labels(graph: Graph) -> dict[str, str]:
    """Return what people read for each output that is written: the names of the inputs of ``write`` nodes."""
    labels = {}
    for sink in sinks(graph):
        for name, link in graph.nodes[sink].inputs.items():
            first = next(iter(graph.nodes[link.node].declaration.all_outputs))
            labels[link.node if link.output == first else str(link)] = readable(name)
    return labels


def _varies(graph: Graph) -> bool:
    """Return whether a graph moves from frame to frame though the pictures that go in do not."""
    curves = [value for node in graph.nodes.values() for value in node.params.values() if isinstance(value, Curve)]
    return bool(curves) or any(knob.curve is not None for knob in graph.interface.values())


# ---------------------------------------------------------------------- parameters


def _params(graph: Graph, knobs: Iterable[Mapping[str, Any]], outputs: list[str]) -> list[dict[str, Any]]:
    """Return the parameters as a panel shows them: which output, the graph's knobs, mix and colour space."""
    own: list[dict[str, Any]] = []
    if len(outputs) > 1:
        own.append(_choice("output", outputs, "Output", "Which of the graph's pictures to give."))
    mix = {"name": "mix", "role": "mix", "type": "double", "default": 1.0, "min": 0.0, "max": 1.0, "label": "Mix"}
    mix |= {"display_min": 0.0, "display_max": 1.0, "increment": 0.01, "digits": 3, "group": ""}
    mix["hint"] = "How much of the result goes over the source; the mask counts too."
    help = "What the pixels are, in and out: the host's working space. OpenFX does not tell it."
    space = _choice("colorspace", list(COLORSPACES), "Colour space", help)
    name = {"name": "colorspace_name", "role": "colorspace_name", "type": "string", "default": "", "group": ""}
    name |= {"label": "Other space", "hint": "A name that flowabs colorspaces lists, for the choice 'Other, by name'."}
    taken = {each["name"] for each in (*own, mix, space, name)}
    turned = [_knob(graph, each, taken) for each in knobs]
    return [*own, *_grouped(turned, taken), mix, space, name]


def _choice(role: str, labels: list[str], label: str, hint: str) -> dict[str, Any]:
    """Return a parameter of the effect's own that chooses one of several, by place."""
    return {
        "name": role,
        "role": role,
        "type": "choice",
        "default": 0,
        "group": "",
        "labels": labels,
        "words": labels,
        "label": label,
        "hint": hint,
    }


def _knob(graph: Graph, knob: Mapping[str, Any], taken: set[str]) -> dict[str, Any]:
    """Return a parameter for a knob; ``taken`` are names of others."""
    name, kind, default = knob["name"], _TYPES[knob["type"]], knob["default"]
    unit = f" ({knob['unit']})" if knob["unit"] else ""
    param = {
        "name": f"{name}_knob" if name in taken else name,
        "knob": name,
        "role": "knob",
        "type": kind,
        "label": f"{knob['label'] or readable(name)}{unit}",
        "hint": knob["help"],
        "group": knob["group"],
        "default": list(knob["choices"]).index(default) if kind == "choice" else default,
        "curve": knob["animated"],
    }
    if kind == "choice":
        param |= {"words": list(knob["choices"]), "labels": [readable(word) for word in knob["choices"]]}
    if kind in ("double", "int"):
        param |= _range(graph, knob)
    return param


def _range(graph: Graph, knob: Mapping[str, Any]) -> dict[str, Any]:
    """Return the hard range of a number, and that of its slider: without ends of its own, of what the knob drives."""
    driven = _driven(graph, knob["name"])
    soft = driven.soft if driven is not None and driven.soft else (None, None)
    found: dict[str, Any] = {}
    for end, usual, value in (("min", soft[0], knob["min"]), ("max", soft[1], knob["max"])):
        if value is not None:
            found[end] = value
        shown = value if value is not None else usual
        if shown is not None:
            found[f"display_{end}"] = shown
    if knob["type"] == "float" and {"display_min", "display_max"} <= found.keys():
        step = (found["display_max"] - found["display_min"]) / 100
        found["increment"] = 10.0 ** math.floor(math.log10(step)) if step > 0 else 0.01
    return found


def _driven(graph: Graph, name: str) -> Param | None:
    """Return the declaration of the first parameter that a knob drives as it is."""
    for node in graph.nodes.values():
        for param, value in node.params.items():
            if isinstance(value, FromKnob) and value.knob == name and not value.map:
                return node.declaration.all_params.get(param)
    return None


def _grouped(params: list[dict[str, Any]], taken: set[str]) -> list[dict[str, Any]]:
    """Return parameters with those of a group side by side, where its first one stands, under a legal name."""
    order = {group: place for place, group in reversed(list(enumerate(each["group"] for each in params)))}
    names = taken | {each["name"] for each in params}
    places = [(order[each["group"]] if each["group"] else place, place) for place, each in enumerate(params)]
    found = []
    for _, place in sorted(places):
        each = params[place]
        if each["group"]:
            legal = f"group_{re.sub(r'[^A-Za-z0-9_]', '_', each['group'])}"
            each = {**each, "group": f"{legal}_" if legal in names else legal, "group_label": each["group"]}
        found.append(each)
    return found
