"""graph.run: images in, images out."""

import dataclasses
import logging

import numpy as np
import pytest

from flowabs_nodes import graph as graphs
from flowabs_nodes.engine import load_graph
from flowabs_nodes.engine.runnable import RunnableGraph
from flowabs_nodes.errors import ArgumentError, CommandError, FlowabsError, ReadError
from flowabs_nodes.graph import GraphError
from flowabs_nodes.graph.reference_size import ReferenceSize
from flowabs_nodes.image import Image
from flowabs_nodes.nodes import catalogue
from flowabs_nodes.nodes.declare import Node, Param, Port
from tests.engine.fakes import SPLIT, picture
from tests.engine.sequences import document, graph_around, plate


@pytest.fixture
def graph():
    nodes = {"tones": {"type": "split@1", "inputs": {"image": "bright"}}}
    return load_graph(graphs.load(document(**nodes), catalogue() | {"split": SPLIT}))


def test_images_in_images_out(graph):
    image = picture()
    out = graph.run(given={"plate": image}, set={"stops": 2}, outputs=["bright", "tones.mono", "tones"])
    assert list(out) == ["bright", "tones.mono", "tones"]
    np.testing.assert_allclose(out["bright"].pixels, 4 * image.pixels, rtol=1e-6)
    assert (out["tones.mono"].type, out["tones"].type) == ("mono", "matte")
    assert out["tones"].data_window == image.data_window


def test_without_outputs_what_would_be_written_comes_back_and_nothing_is_written(graph, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    layered = document(
        out={"type": "write@1", "inputs": {"image": "bright", "plain": "plate"}, "params": {"file": "x.exr"}}
    )
    assert list(load_graph(layered).run(given={"plate": picture()})) == ["bright", "plate"]
    assert list(tmp_path.iterdir()) == []


def test_a_file_is_read_where_no_image_is_given(graph, tmp_path):
    file = plate(tmp_path / "plate.0007.exr")
    out = graph.run(7, set={"plate.file": str(tmp_path / "plate.####.exr")}, outputs=["plate"])
    assert out["plate"].origin.file == str(file)


def test_what_is_given_stands_in_for_any_output(graph):
    image = picture()
    response = image.with_pixels(image.pixels[..., 0], "mono")
    out = graph.run(given={"tones.mono": response}, outputs=["tones.mono"])
    assert out["tones.mono"] is response
    assert graph.run(given={"bright": image}, outputs=["bright"])["bright"] is image


def test_a_given_image_is_widened_to_what_the_output_is(graph):
    image = picture()
    out = graph.run(given={"plate": image.with_pixels(image.pixels[..., 0], "mono")}, outputs=["plate"])
    assert out["plate"].type == "color"


def test_scale_makes_given_pictures_smaller_and_lengths_follow():
    seen = {}

    def run(context, image, *, length):
        seen.update(length=length, size=image.pixels.shape[:2])
        return image

    probe = graph_around(run, Param.float("length", 8.0, min=0.1, unit="px", help="A length."))
    graph = load_graph(dataclasses.replace(probe, reference_size=ReferenceSize("height", 96)))
    plain = Image.from_array(np.ones((48, 64, 3)))
    graph.run(given={"plate": plain})
    assert seen == {"length": 4.0, "size": (48, 64)}
    graph.run(given={"plate": plain}, scale=0.5)
    assert seen == {"length": 2.0, "size": (24, 32)}


def a_flow():
    return Image.from_array(np.ones((4, 4, 2)))


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"outputs": ["brigth"]}, CommandError, "did you mean 'bright'"),
        ({"outputs": ["tones.mno"]}, CommandError, "did you mean 'mono'"),
        ({"outputs": ["out"]}, CommandError, "only writes"),
        ({"given": lambda: {"plat": picture()}}, CommandError, "did you mean 'plate'"),
        (
            {"given": lambda: {"plate": [[0.5, 0.5], [1, 1]]}},
            ArgumentError,
            "expected an Image or an array, found list.*from_array",
        ),
        (
            {"given": lambda: {"plate": Image.from_array(np.ones((4, 4, 2)))}},
            ArgumentError,
            "expected color, found flow",
        ),
        ({"given": lambda: {"plate": picture(), "plate.image": picture()}}, ArgumentError, "given twice"),
        ({"outputs": ["bright"]}, CommandError, "node plate: parameter file: no file to read is set"),
        ({"set": {"plate.file": "no/such.exr"}, "outputs": ["bright"]}, ReadError, "no such file"),
        ({"set": {"stop": 1}}, GraphError, "stops"),
        ({"scale": 2}, ArgumentError, "above 0 up to 1"),
    ],
)
def test_what_cannot_be_done(graph, options, error, words):
    with pytest.raises(error, match=words):
        graph.run(**{name: value() if callable(value) else value for name, value in options.items()})


def test_a_missing_frame_that_would_be_skipped_is_an_error_here(graph):
    with pytest.raises(CommandError, match="skipped"):
        graph.run(set={"plate.file": "no.####.exr", "plate.missing": "skip"}, outputs=["plate"])


def test_errors_say_node_and_frame(graph):
    with pytest.raises(FlowabsError) as failure:
        graph.run(12, set={"plate.file": "no/such.exr"}, outputs=["plate"])
    assert (failure.value.node, failure.value.frame, failure.value.file) == ("plate", 12, "no/such.exr")


def test_notes_go_to_the_listener_or_to_the_log(graph, tmp_path, caplog):
    file = {"plate.file": str(plate(tmp_path / "a.exr"))}
    events = []
    graph.run(set=file, outputs=["plate"], on_event=events.append)
    assert events
    assert {(event["event"], event["node"], event["frame"]) for event in events} == {("note", "plate", 1)}
    with caplog.at_level(logging.INFO, "flowabs"):
        graph.run(set=file, outputs=["plate"])
    assert [events[0]["text"] in record.message for record in caplog.records]


def test_a_graph_with_values_set_can_still_be_run(graph):
    assert isinstance(graph.with_set({"stops": 0}), RunnableGraph)
    image = picture()
    assert graph.with_set({"stops": 0}).run(given={"plate": image})["bright"].pixels.tolist() == image.pixels.tolist()


def test_a_result_is_let_go_after_its_last_use(quick_collection):
    import gc
    import weakref

    held = []

    def watch(context, image):
        gc.collect()
        assert sum(each() is not None for each in held) <= 1, "only the input may still be held"
        result = image.with_pixels(image.pixels + 1)
        held.append(weakref.ref(result))
        return result

    port = Port("image", "color", "A picture.")
    node = Node("watch", 1, "Watches.", (port,), (Port("image", "=image", "Plus 1."),), (), watch)
    chain = {f"n{i}": {"type": "watch@1", "inputs": {"image": f"n{i - 1}" if i else "plate"}} for i in range(5)}
    graph = load_graph(graphs.load(document(**chain), catalogue() | {"watch": node}))
    out = graph.run(given={"plate": picture()}, outputs=["n4"])
    np.testing.assert_allclose(out["n4"].pixels, picture().pixels + 5, rtol=1e-5)


def test_code_values_of_a_given_image_are_made_once_and_go_with_the_run():
    seen = []

    def look(context, image):
        seen.append(image.encoded("lab"))
        return image.with_pixels(image.pixels + 1)

    port = Port("image", "color", "A picture.")
    node = Node("look", 1, "Looks.", (port,), (Port("image", "=image", "Plus 1."),), (), look)
    twice = {name: {"type": "look@1", "inputs": {"image": "plate"}} for name in ("a", "b")}
    graph = load_graph(graphs.load(document(**twice), catalogue() | {"look": node}))
    image = picture()
    graph.run(given={"plate": image}, outputs=["a", "b"])
    assert seen[0] is seen[1]
    assert image.encoded("lab") is not seen[0]


def test_an_array_is_searched_for_nan_once_in_a_run(monkeypatch):
    from flowabs_nodes.filters import validate
    from flowabs_nodes.simd import finite

    looks = []
    original = finite.over_pixels
    monkeypatch.setattr(finite, "over_pixels", lambda *args: looks.append(1) or original(*args))

    def look(context, image):
        validate.planes("rgb", image.pixels)
        return image

    port = Port("image", "color", "A picture.")
    node = Node("look", 1, "Looks.", (port,), (Port("image", "=image", "The same."),), (), look)
    chain = {f"n{i}": {"type": "look@1", "inputs": {"image": f"n{i - 1}" if i else "plate"}} for i in range(3)}
    graph = load_graph(graphs.load(document(**chain), catalogue() | {"look": node}))
    for runs in (1, 2):
        graph.run(given={"plate": picture()}, outputs=["n2"])
        assert len(looks) == runs


def test_code_values_that_nobody_else_wants_are_held_by_the_filter_alone(monkeypatch):
    import weakref

    from flowabs_nodes import filters

    def fbl(codes, flow, *others, **named):
        held, result = weakref.ref(codes.base), codes.copy()
        del codes
        assert held() is None
        return result

    monkeypatch.setattr(filters, "fbl", fbl)
    links = {"image": "plate", "flow": "flow"}
    nodes = {"flow": {"type": "etf@1", "inputs": {"image": "plate"}}, "smooth": {"type": "fbl@1", "inputs": links}}
    load_graph(graphs.load(document(**nodes))).run(given={"plate": picture()}, outputs=["smooth"])


def test_numbers_of_numpy_are_numbers(graph):
    image = picture()
    plain = graph.run(2, {"plate": image}, {"stops": 2}, ["bright"], 0.5)["bright"].pixels
    given = {"plate": {np.int64(2): image, np.int32(1): image}}
    out = graph.run(np.uint16(2), given, {"stops": np.float32(2)}, ["bright"], np.float32(0.5))
    np.testing.assert_array_equal(out["bright"].pixels, plain)
    brighter = {**graph.document["nodes"]["bright"], "params": {"stops": np.array(2)}}
    nodes = {**graph.document["nodes"], "bright": brighter}
    written = graphs.load({**graph.document, "nodes": nodes}, catalogue() | {"split": SPLIT})
    assert written.values(1)["bright"]["stops"] == 2


def test_one_output_may_stand_alone(graph):
    assert list(graph.run(given={"plate": picture()}, outputs="bright")) == ["bright"]
    assert list(graph.run(given={"plate": picture()}, outputs=np.array(["tones.mono", "bright"]))) == [
        "tones.mono",
        "bright",
    ]
    with pytest.raises(CommandError, match=r"no node 'brigth'.*did you mean 'bright'"):
        graph.run(given={"plate": picture()}, outputs="brigth")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"frame": 1.5}, "frame: expected a whole number, found 1.5"),
        ({"frame": None}, "frame: expected a whole number, found None"),
        ({"frame": True}, "frame: expected a whole number, found True"),
        ({"outputs": 3}, "outputs: expected names such as 'lines'.*found 3"),
        ({"outputs": [None]}, "outputs: expected names .*found None"),
        ({"given": [picture()]}, "given: expected a dict.*found list"),
        ({"given": {"plate": {1.0: picture()}}}, "expected frame numbers, found 1.0"),
        ({"set": ["stops=2"]}, "set: expected a dict.*found list"),
        ({"set": {2: 1}}, "set: expected a dict.*found the name 2"),
        ({"scale": np.float64("nan")}, "scale: expected a number above 0 up to 1"),
        ({"scale": "1"}, "scale: expected a number above 0 up to 1"),
    ],
)
def test_what_python_may_hand_over_by_mistake(graph, options, words):
    with pytest.raises(ArgumentError, match=words):
        graph.run(**{"given": {"plate": picture()}, **options})


@pytest.mark.parametrize("source", [None, 3, ["lines"], 1.5, object()])
def test_what_is_no_graph(source):
    with pytest.raises(ArgumentError, match=r"expected a path, the name of a graph .*, or a dict, found"):
        load_graph(source)
