"""Switches on the passes of a scene's view layers that a graph reads."""

from __future__ import annotations

from collections.abc import Iterator

import bpy

from flowabs_nodes.graph.model import Graph
from flowabs_nodes.io.pass_names import ALBEDO, ANY_CRYPTOMATTE, ANY_MATERIAL, plain_name, same_pass
from flowabs_nodes.io.views import split_view

#: The pass that a node reads where its layer names none.
_OF_NODE = {"read_depth": "Depth", "read_normal": "Normal", "read_motion": "Vector", "read_id": "CryptoObject"}
#: Blender's switch of each pass.
_SWITCHES = {
    "Depth": "use_pass_z",
    "Mist": "use_pass_mist",
    "Position": "use_pass_position",
    "Normal": "use_pass_normal",
    "Vector": "use_pass_vector",
    "UV": "use_pass_uv",
    "Object Index": "use_pass_object_index",
    "Material Index": "use_pass_material_index",
    "CryptoObject": "use_pass_cryptomatte_object",
    "CryptoMaterial": "use_pass_cryptomatte_material",
    "CryptoAsset": "use_pass_cryptomatte_asset",
    "Diffuse Color": "use_pass_diffuse_color",
    "Diffuse Direct": "use_pass_diffuse_direct",
    "Diffuse Indirect": "use_pass_diffuse_indirect",
    "Glossy Color": "use_pass_glossy_color",
    "Glossy Direct": "use_pass_glossy_direct",
    "Glossy Indirect": "use_pass_glossy_indirect",
    "Transmission Color": "use_pass_transmission_color",
    "Transmission Direct": "use_pass_transmission_direct",
    "Transmission Indirect": "use_pass_transmission_indirect",
    "Emission": "use_pass_emit",
    "Environment": "use_pass_environment",
    "Ambient Occlusion": "use_pass_ambient_occlusion",
    "Shadow": "use_pass_shadow",
}


def switch_on(scene: bpy.types.Scene, graph: Graph, passes: str) -> dict[str, list[str]]:
    """Switch on what a graph reads of the files ``passes``, in every view layer that is rendered.

    Returns the switches that were off, by the name of the view layer.
    """
    wanted = [_SWITCHES[name] for name in _passes(graph, passes)]
    were_off: dict[str, list[str]] = {}
    for layer in scene.view_layers:
        off = [switch for switch in wanted if layer.use and not getattr(layer, switch)]
        for switch in off:
            setattr(layer, switch, True)
        if off:
            were_off[layer.name] = off
    return were_off


def _passes(graph: Graph, passes: str) -> Iterator[str]:
    """Yield the passes that a graph reads of these files, as Blender calls them; what is none of them is left alone."""
    for name, values in graph.values(1).items():
        if values.get("file") != passes:
            continue
        layer, _ = split_view(str(values.get("layer", "")), ("left", "right"))
        usual = _OF_NODE.get(graph.nodes[name].declaration.type)
        named = _named(layer)
        if named or usual:
            yield named or usual


def _named(layer: str) -> str | None:
    """Return the pass that a layer names: "Diffuse Color" of "Fg.DiffCol" and of "albedo"; None of a view layer."""
    if plain_name(layer) == ALBEDO.usual[0]:
        return "Diffuse Color"
    if plain_name(layer) == ANY_CRYPTOMATTE:
        return "CryptoObject"
    if plain_name(layer) == ANY_MATERIAL:
        return "CryptoMaterial"
    level = layer.rstrip("0123456789") if plain_name(layer).startswith("crypto") else layer
    return next((name for name in _SWITCHES if same_pass(level, name)), None)
