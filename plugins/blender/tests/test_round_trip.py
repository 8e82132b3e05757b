"""Export, import, export gives identical JSON: of all graphs that come with flowabs, and of hand-made edge cases."""

import json
from typing import Any

import bpy
import pytest
from flowabs_blender import import_export, tree_json

from graphs import WIDTH, small, with_knobs, with_params

CASES: dict[str, dict[str, Any]] = {
    # names
    "name of 128 letters": small(**{"n" * 128: {"type": "blur@1", "inputs": {"image": "plate"}}}),
    "two names alike for 100 letters": small(
        **{"n" * 100 + end: {"type": "blur@1", "inputs": {"image": "plate"}} for end in "ab"},
        z={"type": "merge@1", "inputs": {"B": "n" * 100 + "b", "A": "n" * 100 + "a"}},
    ),
    "names that Blender makes": small(**{"lines.001": {"type": "etf@1", "inputs": {"image": "plate"}}}),
    "a graph's name of 300 letters": {**small(), "name": "g" * 300},
    "a graph without a name": {key: said for key, said in small().items() if key != "name"},
    "a graph's name with signs": {**small(), "name": 'a/b "c" é\n'},
    "an empty graph": {"format": "flowabs.graph/1", "nodes": {}},
    # numbers
    "0.1 and a third": with_params("etf@1", fill=0.1, pre_blur=1 / 3),
    "the default, said": with_params("etf@1", radius=5.0, iterations=3, color=False),
    "an int for a float": with_params("etf@1", radius=5, fill=0),
    "digits beyond float32": with_params("etf@1", radius=5.000000123456789),
    "null": with_params("etf@1", fill=None),
    "null that is the default": with_params("dog@1", contrast=None),
    "a number where null is the default": with_params("dog@1", contrast=0.0),
    "just above an excluded minimum": with_params("bilateral@1", sigma_r=1e-300),
    "an excluded minimum": with_params("bilateral@1", sigma_r=0),
    "out of range": with_params("etf@1", radius=-5.5, iterations=10**6),
    "an int over 2**31": small(x={"type": "lic@1", "inputs": {"flow": "flow"}, "params": {"seed": 2**40}}),
    "the largest seed": small(x={"type": "lic@1", "inputs": {"flow": "flow"}, "params": {"seed": 2**31 - 1}}),
    "an int of 200 digits": with_params("etf@1", iterations=10**200, radius=10**200),
    "a float beyond float32": with_params("etf@1", radius=1e300),
    # other values
    "a colour": small(x={"type": "constant@1", "params": {"color": [0.1, 0.5, 2], "size": [64, 48]}}),
    "a colour that is none": small(x={"type": "constant@1", "params": {"color": [0.1, 0.5], "size": "big"}}),
    "custom values": small(
        a={"type": "read@1", "params": {"part": "12"}},
        b={"type": "read@1", "params": {"part": 12}},
        c={"type": "write@1", "inputs": {"image": "a"}, "params": {"metadata": {"owner": "me", "take": 3}}},
        d={"type": "crop@1", "inputs": {"image": "b"}, "params": {"box": [0, 0, 10, 10]}},
        e={"type": "etf@1", "inputs": {"image": "a"}, "params": {"gradient_reference": "p99.5"}},
        f={"type": "etf@1", "inputs": {"image": "a"}, "params": {"gradient_reference": 16.25}},
    ),
    "wrong types": with_params("etf@1", radius="5", iterations=2.5, color=1, kernel=3, gradient_reference=[1]),
    "null where it does not belong": with_params("etf@1", space=None, radius=None, color=None, gradient_reference=None),
    "a word of a later version": with_params("etf@1", kernel="hexagon"),
    "a parameter of a later version": with_params("etf@1", sparkle={"a": [1, None, "x"]}),
    "texts": small(a={"type": "read@1", "params": {"file": "//host/é \n'\"\\.####.exr", "layer": "x" * 2000}}),
    # knobs
    "knobs of all types": with_knobs(
        width=WIDTH,
        passes={"type": "int", "default": 3, "min": 1},
        on={"type": "bool", "default": True},
        form={"type": "enum", "default": "xdog", "choices": ["paper", "xdog"], "label": "Form"},
        text={"type": "string", "default": "é"},
        ink={"type": "color", "default": [0.1, 0, 2.5]},
        drives={
            "sigma_c": {"from": "width"},
            "rho": {"from": "width", "map": [[0.3, 0.9], [4, 1]]},
            "form": {"from": "form"},
            "color_sign": {"from": "on"},
        },
    ),
    "odd knobs": with_knobs(
        **{"k" * 128: WIDTH, "k" * 127 + "2": WIDTH},
        thirds={"type": "float", "default": 1 / 3, "min": 0.1, "max": 0.7},
        whole={"type": "float", "default": 2, "min": -(10**30), "max": 1e300},
        large={"type": "int", "default": 2**40},
        no_type={"default": 1},
        no_default={"type": "float"},
        no_object=3,
        wrong={"type": "enum", "default": "c", "choices": ["a", "b"]},
        turned={"type": "int", "default": 5, "min": 10, "max": 1},
        drives={"sigma_c": {"from": "nobody"}, "rho": {"from": 3}, "tau": {"from": "whole", "map": "no"}},
    ),
    "a knob on a curve": with_knobs(width={**WIDTH, "default": {"curve": {"1001": 1, "1010": 2.1}}}),
    "no interface at all": {**small(), "interface": {}},
    "an interface that is none": {**small(), "interface": [1]},
    # curves
    "curves": with_params(
        "etf@1",
        radius={"curve": {"1001": 2, "1010": 0.1, "1100": 7.3}},
        iterations={"curve": {"1": 1, "5": 4}},
        pre_blur={"curve": {"10": 1, "-3": 2.5}},
    ),
    "curves that no F-curve holds": with_params(
        "etf@1",
        radius={"curve": {"999999999": 2}},
        pre_blur={"curve": {}},
        fill={"curve": {"1": "a"}},
        iterations={"curve": {"1.5": 1}},
        color={"curve": {"1": True}},
        kernel={"curve": [1]},
    ),
    # links
    "outputs in full": small(out={"type": "write@1", "inputs": {"image": "lines.lines", "r": "lines.response"}}),
    "layers with long names": small(
        out={"type": "write@1", "inputs": {"flow": "flow", "image": "lines", "l" * 128: "plate.image"}}
    ),
    "links to nowhere": small(
        x={"type": "fdog@1", "inputs": {"image": "nobody", "flow": "flow.nothing", "mask": 3, "extra": "plate"}},
        y={"type": "blur@1", "inputs": {"image": "out"}},
    ),
    "ports that do not fit": small(x={"type": "lic@1", "inputs": {"flow": "plate"}}),
    "circles": small(
        a={"type": "blur@1", "inputs": {"image": "b"}},
        b={"type": "blur@1", "inputs": {"image": "a"}},
        c={"type": "blur@1", "inputs": {"image": "c"}},
    ),
    "a switch": small(s={"type": "switch@1", "inputs": {"a": "plate", "j": "lines"}, "params": {"which": 9}}),
    # what this flowabs does not know
    "a package that is not installed": small(
        dots={"type": "halftone@3", "inputs": {"picture": "plate", "by": "flow"}, "params": {"dots": [1, 2], "r": 1.0}},
        after={"type": "merge@1", "inputs": {"B": "dots", "A": "dots.ink"}},
        last={"type": "halftone@3", "inputs": {"picture": "dots.halftone"}},
    ),
    "a newer node": small(x={"type": "etf@99", "inputs": {"image": "plate"}, "params": {"radius": 3}}),
    "bodies that are none": small(a=3, b={}, c={"type": 7}, d={"type": "etf", "inputs": [1], "params": "x"}),
    "empty bodies": small(x={"type": "blur@1", "params": {}, "inputs": {}}, y={"params": {}, "type": "etf@1"}),
    "unknown keys": {**small(x={"type": "blur@1", "extra": [1]}), "later": {"a": 1}},
    "another format": {**small(), "format": "nuke"},
    "no format": {"nodes": {}},
    # the rest of the file
    "what is for people and editors": {
        "$schema": "https://example.org/graph.schema.json",
        **small(),
        "description": "é" * 300,
        "reference_height": 1080,
        "ui": {
            "zoom": 2,
            "flow": {"pos": [10.5, -3.25], "color": "red", "collapsed": True, "width": 333.3, "label": "The flow"},
            "plate": {"pos": "left", "note": [1]},
            "nobody": {"pos": [1, 2]},
            "out": 3,
        },
    },
    "reference_size": {**small(), "reference_size": {"shorter": 540}},
}  # fmt: skip


@pytest.mark.parametrize("name", import_export.presets())
def test_graphs_that_come_with_flowabs(name: str, after_round_trip: Any) -> None:
    graph = json.loads(import_export.presets()[name].read_text(encoding="utf-8"))
    assert after_round_trip(graph) == json.dumps(graph)


@pytest.mark.parametrize("name", CASES)
def test_edge_cases(name: str, after_round_trip: Any) -> None:
    assert after_round_trip(CASES[name]) == json.dumps(CASES[name])


@pytest.mark.parametrize("name", CASES)
def test_edge_cases_through_a_blend_file(name: str, tree_of: Any, tmp_path: Any) -> None:
    tree_name = tree_of(CASES[name]).name
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "a.blend"))
    assert json.dumps(tree_json.graph_of(bpy.data.node_groups[tree_name])) == json.dumps(CASES[name])


@pytest.mark.parametrize("name", ["abstraction", "fig01"])
def test_files(name: str, tmp_path: Any) -> None:
    """Export, import, export through files: identical bytes."""
    first, second = tmp_path / "first.json", tmp_path / "second.json"
    bpy.ops.flowabs.new_from_preset(preset=name)
    bpy.ops.flowabs.export_graph(filepath=str(first), tree=name)
    bpy.data.node_groups.remove(bpy.data.node_groups[name])
    bpy.ops.flowabs.import_graph(filepath=str(first))
    bpy.ops.flowabs.export_graph(filepath=str(second), tree=name)
    assert first.read_bytes() == second.read_bytes()
    assert json.loads(second.read_text()) == json.loads(import_export.presets()[name].read_text(encoding="utf-8"))
