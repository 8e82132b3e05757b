"""A switch: of its branches one is computed, read, and part of the key."""

import shutil

import numpy as np
import pytest

from flowabs_nodes import engine, graph
from flowabs_nodes.engine import load_graph
from flowabs_nodes.engine.call_node import call_node
from flowabs_nodes.errors import ArgumentError, CommandError, FlowabsError
from flowabs_nodes.graph.problems import GraphError
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Context
from flowabs_nodes.nodes.switch import NAMES, SWITCH
from flowabs_nodes.port_types import TYPES
from flowabs_nodes.testing.pictures import make_input
from tests.comp.pictures import noise
from tests.engine.sequences import plate, plates, statuses
from tests.engine.windows import MEAN, asking, load


def document(which, **more):
    """Return a graph of two plates, a bright and a dark one, that a switch chooses from."""
    return {
        "format": "flowabs.graph/1",
        "interface": {"take": {"type": "int", "default": 0, "min": 0, "max": 9, "help": "Which."}},
        "nodes": {
            "one": {"type": "read@1"},
            "two": {"type": "read@1"},
            "bright": {"type": "exposure@1", "inputs": {"image": "two"}, "params": {"stops": 1}},
            "pick": {"type": "switch@1", "inputs": {"a": "one", "b": "bright"}, "params": {"which": which}},
            "out": {"type": "write@1", "inputs": {"image": "pick"}},
            **more,
        },
    }


KNOB = {"from": "take"}
IMAGES = {"one": Image.from_array(noise(5, 7, 3, seed=1)), "two": Image.from_array(noise(5, 7, 3, seed=2))}


def test_a_knob_chooses():
    loaded = load_graph(document(KNOB))
    first = loaded.run(given=IMAGES, outputs="pick")["pick"]
    second = loaded.run(given=IMAGES, outputs="pick", set={"take": 1})["pick"]
    np.testing.assert_array_equal(first.pixels, IMAGES["one"].pixels)
    np.testing.assert_array_equal(second.pixels, IMAGES["two"].pixels * 2)


def test_a_curve_chooses():
    loaded = load_graph(document({"curve": {"1": 0, "2": 1}}))
    for frame, factor, name in ((1, 1, "one"), (2, 2, "two"), (9, 2, "two")):
        pixels = loaded.run(frame, given=IMAGES, outputs="pick")["pick"].pixels
        np.testing.assert_array_equal(pixels, IMAGES[name].pixels * factor)


def test_the_other_branch_is_neither_computed_nor_asked_for():
    loaded = load_graph(document(KNOB))
    loaded.run(given={"one": IMAGES["one"]}, outputs="pick")  # there is no file for the other one
    with pytest.raises(CommandError, match="node two: parameter file: no file to read is set"):
        loaded.run(given={"one": IMAGES["one"]}, outputs="pick", set={"take": 1})


def test_a_run_reads_the_chosen_branch_alone_and_resumes_by_it(tmp_path):
    """The other file need not be there, its frames do not count, and it may change."""
    shot, other = plates(tmp_path / "shot", 1, 2), tmp_path / "other.####.exr"
    out = tmp_path / "out.####.exr"
    files = {"one.file": shot, "two.file": str(other)}
    assert statuses(engine.run(document(KNOB), output=out, set=files)) == [(1, "done"), (2, "done")]
    for frame in (1, 2, 3):
        shutil.copy(plate(tmp_path / "x.exr", seed=40 + frame), tmp_path / f"other.{frame:04d}.exr")
    assert statuses(engine.run(document(KNOB), output=out, set=files)) == [(1, "skipped"), (2, "skipped")]
    assert statuses(engine.run(document(KNOB), output=out, set=files | {"take": 1})) == [
        (frame, "done") for frame in (1, 2, 3)
    ]


def test_a_curve_needs_both_files(tmp_path):
    files = {"one.file": plates(tmp_path / "shot", 1, 2)}
    with pytest.raises(CommandError, match="node two: parameter file: no file to read is set"):
        engine.run(document({"curve": {"1": 0, "2": 1}}), output=tmp_path / "out.####.exr", set=files)


@pytest.mark.parametrize("kind", TYPES)
def test_every_type_comes_through(kind):
    images = {name: make_input(kind, scene, 6, 8) for name, scene in (("a", "shapes"), ("c", "noise"))}
    result = call_node(SWITCH, Context(), images, {"which": 2})["image"]
    assert result.type == kind
    np.testing.assert_array_equal(result.pixels, images["c"].pixels)


def test_inputs_need_not_be_of_one_size():
    images = {"a": Image.from_array(noise(5, 7, 3)), "b": Image.from_array(noise(9, 4, 4))}
    assert call_node(SWITCH, Context(), images, {"which": 1})["image"].data_window == (0, 0, 4, 9)


# ---------------------------------------------------------------------- before a node that reads other frames


def test_a_window_of_frames_reads_the_branch_that_is_chosen_on_each(tmp_path):
    """On frame 2 the switch is at a, from 3 on at b: neither a's missing frame 3 nor b's missing frame 2 matters."""
    for frame in (1, 2, 4):
        plate(tmp_path / f"one.{frame:04d}.exr", seed=frame)
    for frame in (1, 3, 4):
        plate(tmp_path / f"two.{frame:04d}.exr", seed=10 + frame)
    seen = {}

    def run(context, image, *, radius):
        seen[context.frame] = [context.frame + offset for offset in image]
        return MEAN.run(context, image, radius=radius)

    nodes = {
        "one": {"type": "read@1", "params": {"file": str(tmp_path / "one.####.exr")}},
        "two": {"type": "read@1", "params": {"file": str(tmp_path / "two.####.exr")}},
        "pick": {
            "type": "switch@1",
            "inputs": {"a": "one", "b": "two"},
            "params": {"which": {"curve": {"2": 0, "3": 1}}},
        },
        "mean": {"type": "mean@1", "inputs": {"image": "pick"}, "params": {"radius": 1}},
        "out": {"type": "write@1", "inputs": {"image": "mean"}},
    }
    together = load(nodes, asking(MEAN.frames, run))
    report = engine.run(together, output=tmp_path / "out.####.exr", frames=[2, 3, 4])
    assert statuses(report) == [(2, "done"), (3, "done"), (4, "done")]
    assert seen == {2: [1, 2, 3], 3: [2, 3, 4], 4: [3, 4]}
    alone = together.run(3, outputs="mean")["mean"].pixels
    taken = [together.run(frame, outputs="pick")["pick"].pixels for frame in (2, 3, 4)]
    np.testing.assert_allclose(alone, np.mean(taken, axis=0), rtol=1e-5)


# ---------------------------------------------------------------------- what is wrong


def test_what_is_chosen_must_be_linked():
    (problem,) = graph.check(document(2))
    assert (problem.code, problem.pointer) == ("missing-input", "/nodes/pick/inputs/c")
    assert problem.expected == "a link, which which 2 asks for"
    assert problem.hint == "linked: a, b"
    assert [each.pointer for each in graph.check(document({"curve": {"1": 0, "9": 3}}))] == ["/nodes/pick/inputs/d"]
    with pytest.raises(GraphError):
        load_graph(document(KNOB)).with_set({"take": 5})


def test_a_curve_that_passes_what_is_not_linked_fails_on_that_frame():
    nodes = {
        "pick": {
            "type": "switch@1",
            "inputs": {"a": "one", "c": "two"},
            "params": {"which": {"curve": {"1": 0, "3": 2}}},
        }
    }
    loaded = load_graph(document(0, **nodes))
    loaded.run(3, given=IMAGES, outputs="pick")
    with pytest.raises(
        FlowabsError, match=r"frame 2: node pick: .*input 'b', which these parameters choose"
    ) as failure:
        loaded.run(2, given=IMAGES, outputs="pick")
    assert failure.value.code == "missing-input"


def test_a_call_without_the_chosen_input():
    with pytest.raises(ArgumentError, match="input 'b'"):
        call_node(SWITCH, Context(), {"a": IMAGES["one"]}, {"which": 1})


def test_inputs_that_are_of_no_one_type():
    nodes = {
        "flow": {"type": "etf@1", "inputs": {"image": "one"}},
        "pick": {"type": "switch@1", "inputs": {"a": "one", "b": "flow"}},
    }
    (problem,) = (each for each in graph.check(document(0, **nodes)) if not each.warning)
    assert (problem.code, problem.pointer) == ("wrong-type", "/nodes/pick/inputs/b")
    assert problem.found == "flow.flow, which is flow"
    assert "input a, color" in problem.expected


def test_a_matte_goes_where_a_color_goes():
    nodes = {
        "dog": {"type": "dog@1", "inputs": {"image": "one"}},
        "pick": {"type": "switch@1", "inputs": {"a": "dog", "b": "one"}, "params": {"which": KNOB}},
        "soft": {"type": "exposure@1", "inputs": {"image": "pick"}},
    }
    loaded = load_graph(document(0, **nodes))
    for take in (0, 1):
        assert loaded.run(given=IMAGES, outputs="soft", set={"take": take})["soft"].type == "color"


def test_its_inputs_have_the_names_that_which_counts():
    assert NAMES[:3] == ("a", "b", "c")
    assert [port.name for port in SWITCH.inputs] == list(NAMES)
    assert SWITCH.params[0].max == len(NAMES) - 1
