import dataclasses
import subprocess
import sys

import numpy as np
import pytest

from flowabs_nodes.engine import keys as keys_module
from flowabs_nodes.engine import load_graph
from flowabs_nodes.engine.keys import image_key, node_key, unit_keys
from flowabs_nodes.engine.plan import Result, Step, Unit, file_role, make_plan, sinks
from flowabs_nodes.graph.reference_size import ReferenceSize
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Node, Param, Port
from tests.engine.fakes import ADD, SPLIT, graph, node, picture
from tests.engine.windows import MEAN

READ = Node(
    type="read",
    version=1,
    help=".",
    inputs=(),
    outputs=(Port("image", "color", "."),),
    params=(
        Param.file("file", role="input", help="."),
        Param.string("layer", "", help="."),
        Param.enum("missing", "error", ("error", "black"), help=".", in_key=False),
    ),
    run=ADD.run,
)


def test_every_parameter_and_input_changes_the_key():
    defaults = SPLIT.defaults()
    keys = {
        node_key(SPLIT, defaults, {"image": "x"}),
        node_key(SPLIT, defaults | {"length": 2.0000000000000004}, {"image": "x"}),
        node_key(SPLIT, defaults | {"slope": None}, {"image": "x"}),
        node_key(SPLIT, defaults | {"slope": 0.0}, {"image": "x"}),
        node_key(SPLIT, defaults, {"image": "y"}),
        node_key(dataclasses.replace(SPLIT, version=2), defaults, {"image": "x"}),
        node_key(dataclasses.replace(SPLIT, type="splits"), defaults, {"image": "x"}),
        node_key(SPLIT, defaults, {"image": "x"}, reference_size=ReferenceSize("height", 1080)),
        node_key(SPLIT, defaults, {"image": "x"}, reference_size=ReferenceSize("shorter", 1080)),
        node_key(SPLIT, defaults, {"image": "x"}, scale=0.5),
    }
    assert len(keys) == 10


def test_the_same_value_has_one_key_however_it_is_written():
    key = node_key(SPLIT, {"length": 2.0, "slope": 4.0}, {"a": "1", "b": "2"})
    assert key == node_key(SPLIT, {"slope": np.float64(4), "length": 2}, {"b": "2", "a": "1"})


def test_a_number_is_not_the_text_that_looks_like_it():
    custom = Param.custom("value", "max", schema={}, parse=lambda value: None, help=".")
    declaration = dataclasses.replace(SPLIT, params=(custom,))
    assert node_key(declaration, {"value": 16}, {}) == node_key(declaration, {"value": 16.0}, {})
    keys = {node_key(declaration, {"value": value}, {}) for value in (1.0, True, "1", (1.0).hex(), None, [1], {"a": 1})}
    assert len(keys) == 7


def test_a_file_counts_by_its_content_and_not_its_name():
    def key(**changes):
        fields = {"content": "abc", "file": "a.exr", "layer": "", "missing": "error"} | changes
        content = fields.pop("content")
        extra = {name: fields.pop(name) for name in ("ocio", "scale") if name in fields}
        return node_key(READ, fields, {}, content=content, **extra)

    assert key() == key(file="elsewhere/b.exr") == key(missing="black")
    assert len({key(), key(content="abd"), key(layer="diffuse"), key(ocio="my config"), key(scale=0.5)}) == 5


def test_lengths_matter_only_to_nodes_that_have_some():
    size = ReferenceSize("height", 1080)
    assert node_key(ADD, ADD.defaults(), {}) == node_key(ADD, ADD.defaults(), {}, reference_size=size, scale=0.5)


MODED = dataclasses.replace(
    ADD,
    params=(
        *ADD.params,
        Param.enum("mode", "flat", ("flat", "bent"), help="."),
        Param.float("bend", 1.0, enabled_when={"mode": ("bent",)}, help="."),
    ),
)


def test_a_disabled_parameter_counts_as_its_default():
    defaults = MODED.defaults()
    key = node_key(MODED, defaults, {})
    assert key == node_key(MODED, defaults | {"bend": 2.0}, {})
    bent = [node_key(MODED, defaults | {"mode": "bent", "bend": bend}, {}) for bend in (1.0, 2.0)]
    assert len({key, *bent}) == 3
    free = tuple(dataclasses.replace(param, enabled_when={}) for param in MODED.params)
    assert key == node_key(dataclasses.replace(MODED, params=free), defaults, {})  # as before it was conditional


def keys_of(a_graph, **params):
    steps = make_plan(a_graph, 1, results=[Result("end", "image", 1)])
    values = {Unit(name, 1): each for name, each in a_graph.values(1).items()}
    return unit_keys(a_graph, steps, values, contents={}, given={}, scale=1.0, ocio="")


def test_a_change_upstream_changes_every_key_downstream_and_no_other():
    def build(amount, output):
        return graph(
            node("start", SPLIT),
            node("side", ADD, amount=2.0),
            node("middle", ADD, {"image": f"start.{output}"}, amount=amount),
            node("end", ADD, {"image": "middle", "mask": "side"}),
        )

    before, after = keys_of(build(1.0, "mono")), keys_of(build(1.5, "mono"))
    assert {unit.node for unit in before if before[unit] != after[unit]} == {"middle", "end"}
    other = keys_of(build(1.0, "matte"))
    assert {unit.node for unit in before if before[unit] != other[unit]} == {"middle", "end"}


def test_the_frame_counts_as_far_as_a_node_says():
    twos = dataclasses.replace(ADD, moment=lambda params, frame: None if params["amount"] == 0 else (frame - 1) // 2)

    def keys(declaration, **params):
        return [node_key(declaration, params, {"image": "x"}, frame=frame) for frame in (1, 2, 3)]

    first, second, third = keys(twos)
    assert first == second != third
    assert keys(twos, amount=0.0) == keys(ADD, amount=0.0)
    assert len(set(keys(ADD))) == 1


def window_key(keys):
    """Return the key of a mean over a window of results with ``keys``, by frame."""
    a_graph = graph(node("start", ADD), node("mean", MEAN, {"image": "start"}, radius=1))
    steps = [
        Step(
            Unit("mean", 5),
            {"image": {frame - 5: Result("start", "image", frame) for frame in keys}},
            frozenset(),
            frozenset(),
        )
    ]
    given = {Result("start", "image", frame): key for frame, key in keys.items()}
    params = {Unit("mean", 5): {"radius": 1}}
    return unit_keys(a_graph, steps, params, contents={}, given=given, scale=1.0, ocio="")[Unit("mean", 5)]


def test_a_key_holds_those_of_all_frames_that_are_read():
    keys = {4: "a", 5: "b", 6: "c"}
    found = {
        window_key(keys),
        *(window_key(keys | {frame: "x"}) for frame in keys),
        window_key({4: "c", 5: "b", 6: "a"}),
        window_key({4: "a", 5: "b"}),
        window_key({5: "b", 6: "a"}),
        window_key({5: "a", 6: "b"}),
    }
    assert len(found) == 8


@pytest.mark.parametrize(
    ("name", "keys"),
    [
        ("lines", {"flow": "ccd6b03f821e", "lines": "84ddc5dc341b", "out": "34abe9c611bb"}),
        ("abstraction_hdr", {"flow": "d9e6bfce8e27", "comp": "6c88f7a88558", "out": "469bc57b10e4"}),
        ("flat", {"flow": "bb967e6188b0", "out": "cf7524b68be1"}),
    ],
)
def test_keys_of_released_graphs_stay(name, keys, monkeypatch):
    """A key that changes makes every frame again that a release has written: only a new release may do that."""
    monkeypatch.setattr(keys_module, "package_version", lambda package: "1")
    released = load_graph(name)
    steps = make_plan(released, 1, sinks=sinks(released))
    values = {Unit(each, 1): params for each, params in released.values(1).items()}
    contents = {step.unit: "content" for step in steps if file_role(released, step.unit.node) == "input"}
    found = unit_keys(released, steps, values, contents=contents, given={}, scale=1.0, ocio="")
    assert {each: found[Unit(each, 1)][:12] for each in keys} == keys


def test_given_images_are_known_by_what_they_hold():
    image = picture()
    spec = image.spec
    spec.attribute("owner", "else")
    moved = image.spec
    moved.x += 1
    keys = {
        image_key(image),
        image_key(image.with_pixels(image.pixels + np.float32(1e-6))),
        image_key(Image(image.pixels, spec, "color")),
        image_key(Image(image.pixels, moved, "color")),
        image_key(Image(image.pixels, image.spec, "color", colorspace="lin_ap1_scene")),
    }
    assert len(keys) == 5
    assert image_key(image) == image_key(picture())


@pytest.mark.parametrize("seed", ["1", "2"])
def test_another_process_makes_the_same_key(seed):
    code = "from tests.engine.fakes import *; from flowabs_nodes.engine.keys import node_key, image_key;"
    code += "print(node_key(SPLIT, SPLIT.defaults(), {'image': 'x', 'mask': 'y'}), image_key(picture()))"
    environment = {"PYTHONHASHSEED": seed, "PYTHONPATH": ".", "PATH": ""}
    found = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert found.stdout.split() == [
        node_key(SPLIT, SPLIT.defaults(), {"mask": "y", "image": "x"}),
        image_key(picture()),
    ]


def test_a_parameter_that_came_later_is_in_the_key_only_where_it_is_set():
    later = Param.string("view", "", later=True, help=".")
    declaration = dataclasses.replace(SPLIT, params=(*SPLIT.params, later))
    before = node_key(SPLIT, SPLIT.defaults(), {})
    assert node_key(declaration, declaration.defaults(), {}) == before
    assert node_key(declaration, declaration.defaults() | {"view": "Raw"}, {}) != before
