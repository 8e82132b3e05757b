"""Nodes that read other frames: which of them they get, at the ends of a sequence, at holes, and of given images."""

from dataclasses import replace

import numpy as np
import pytest

from flowabs_nodes import engine
from flowabs_nodes.errors import ArgumentError, CommandError, FlowabsError, ReadError
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Node, Port
from tests.engine.sequences import codes, pixels, statuses
from tests.engine.windows import MEAN, asking, chain, frames_in, grey, greys, load, node


@pytest.fixture
def seen():
    """Return the frames that the node ``mean`` has got, by its own frame."""
    return {}


@pytest.fixture
def watching(seen):
    """Return a mean that notes which frames it gets."""

    def run(context, image, *, radius):
        seen[context.frame] = [context.frame + offset for offset in image]
        return MEAN.run(context, image, radius=radius)

    return asking(MEAN.frames, run)


def frames_read(graph, frame, count, **options):
    """Return the frames whose greys the mean at ``frame`` was taken of."""
    out = graph.run(frame, outputs=["mean"], **options)["mean"]
    return frames_in(float(out.pixels.max()), count)


def test_a_window_of_frames(tmp_path):
    graph = load(chain("mean", plate={"file": greys(tmp_path, *range(1, 11))}), MEAN)
    assert frames_read(graph, 5, 5) == [3, 4, 5, 6, 7]


@pytest.mark.parametrize(
    ("frame", "expected"), [(1, [1, 2, 3]), (2, [1, 2, 3, 4]), (9, [7, 8, 9, 10]), (10, [8, 9, 10])]
)
def test_a_window_ends_where_the_sequence_does(tmp_path, watching, seen, frame, expected):
    load(chain("mean", plate={"file": greys(tmp_path, *range(1, 11))}), watching).run(frame)
    assert seen == {frame: expected}


def test_the_ends_are_those_on_disk_and_not_of_the_frames_rendered(tmp_path, watching, seen):
    graph = load(chain("mean", plate={"file": greys(tmp_path / "in", *range(1, 11))}), watching)
    engine.run(graph, output=tmp_path / "out.####.exr", frames="5-6")
    assert seen == {5: [3, 4, 5, 6, 7], 6: [4, 5, 6, 7, 8]}


def test_offsets_add_up_along_a_chain(tmp_path, watching, seen):
    graph = load(
        chain("mean_1", "mean_2", mean_2={"radius": 1}, plate={"file": greys(tmp_path, *range(1, 11))}), watching
    )
    graph.run(5)
    assert seen == {4: [2, 3, 4, 5, 6], 5: [4, 5, 6], 6: [4, 5, 6, 7, 8]}


def test_each_end_of_a_chain_is_the_sequences(tmp_path):
    graph = load(chain("mean_1", "mean_2", plate={"file": greys(tmp_path, *range(1, 5))}), MEAN)
    by_hand = [np.mean([2.0**each for each in range(max(1, f - 2), min(4, f + 2) + 1)]) for f in (1, 2, 3)]
    found = graph.run(1, outputs=["mean_2"])["mean_2"].pixels
    assert found.max() == pytest.approx(np.mean(by_hand), rel=1e-6)


def test_a_window_of_lines_of_other_frames(tmp_path):
    """The mean of a filter's results, and a filter on the mean."""
    shot = greys(tmp_path, *range(1, 4))
    nodes = chain("mean", plate={"file": shot}, mean={"radius": 1})
    nodes |= {"flow": node("etf", "mean"), "blur": node("blur", "plate"), "after": node("mean", "blur", radius=1)}
    out = load(nodes, MEAN).run(2, outputs=["mean", "flow", "after"])
    assert out["mean"].pixels.max() == pytest.approx(14 / 3, rel=1e-6)
    assert out["after"].pixels.max() == pytest.approx(14 / 3, rel=1e-4)
    assert out["flow"].type == "flow"


def test_parameters_are_those_of_each_frame(tmp_path):
    nodes = chain("mean", plate={"file": greys(tmp_path, 1, 2, 3)})
    nodes["bright"] = node("exposure", "plate", stops={"curve": {"1": 0, "3": 2}})
    nodes["mean"] = node("mean", "bright", radius={"curve": {"1": 0, "2": 1}})
    graph = load(nodes, MEAN)
    assert graph.run(1, outputs=["mean"])["mean"].pixels.max() == 2
    assert graph.run(2, outputs=["mean"])["mean"].pixels.max() == pytest.approx((2 + 8 + 32) / 3, rel=1e-6)


def test_a_single_picture_is_on_no_frame_but_the_nodes_own(tmp_path, watching, seen):
    greys(tmp_path, 1)
    load(chain("mean", plate={"file": str(tmp_path / "plate.0001.exr")}), watching).run(5)
    assert seen == {5: [5]}


def test_what_comes_from_no_file_is_on_every_frame(watching, seen):
    noise = Node("noise", 1, ".", (), (Port("image", "color", "."),), (), lambda context: grey(context.frame))
    graph = load({"noise": node("noise"), "mean": node("mean", "noise")}, watching, noise)
    assert graph.run(-1, outputs=["mean"])["mean"].pixels.max() == -1
    assert seen == {-1: [-3, -2, -1, 0, 1]}


def test_scale(tmp_path):
    graph = load(chain("mean", plate={"file": greys(tmp_path, 1, 2, 3)}), MEAN)
    out = graph.run(2, outputs=["mean"], scale=0.5)["mean"]
    assert out.pixels.shape == (2, 3, 3)
    assert out.pixels.max() == pytest.approx(14 / 3, rel=1e-6)


# ---------------------------------------------------------------------- holes


@pytest.mark.parametrize(
    ("policy", "frames", "value"),
    [
        ("skip", [1, 2, 4, 5], (2 + 4 + 16 + 32) / 4),
        ("hold", [1, 2, 3, 4, 5], (2 + 4 + 4 + 16 + 32) / 5),
        ("nearest", [1, 2, 3, 4, 5], (2 + 4 + 4 + 16 + 32) / 5),
        ("black", [1, 2, 3, 4, 5], (2 + 4 + 0 + 16 + 32) / 5),
    ],
)
def test_a_hole_in_the_window_follows_the_reads_policy(tmp_path, watching, seen, policy, frames, value):
    shot = greys(tmp_path / "in", 1, 2, 4, 5, 6)
    graph = load(chain("mean", plate={"file": shot, "missing": policy}, mean={"radius": 3}), watching)
    (tmp_path / "in/plate.0006.exr").unlink()
    by_option = load(chain("mean", plate={"file": shot}, mean={"radius": 3}), watching)
    for each, options in ((graph, {}), (by_option, {"missing": policy})):
        report = engine.run(each, output=tmp_path / "out.####.exr", frames=4, existing="overwrite", **options)
        assert statuses(report) == [(4, "done")]
        assert seen == {4: frames}
        assert pixels(tmp_path / "out.0004.exr").max() == pytest.approx(value, rel=1e-6)


def test_a_hole_that_is_an_error_names_its_frame_and_node(tmp_path):
    graph = load(chain("mean", plate={"file": greys(tmp_path / "in", 1, 2, 4, 5, 6, 7)}), MEAN)
    report = engine.run(graph, output=tmp_path / "out.####.exr", frames="1-7")
    assert codes(report) == dict.fromkeys((1, 2, 3, 4, 5), "missing-file")
    assert statuses(report)[5:] == [(6, "done"), (7, "done")]
    for failed in report.frames[:5]:
        assert (failed.error.frame, failed.error.node) == (3, "plate")
        said = "plate.0003.exr: frame 3: node plate: no such file (frames 1-2,4-7 are there; --missing says"
        assert said in str(failed.error)


@pytest.mark.parametrize(
    ("file", "hint"),
    [("plaet.####.exr", "did you mean 'plate.####.exr'?"), ("plate.001.exr", "did you mean 'plate.0001.exr'?")],
)
def test_a_file_that_is_missing_gets_the_nearest_name(tmp_path, file, hint):
    greys(tmp_path / "in", 1, 2)
    graph = load(chain("mean", plate={"file": str(tmp_path / "in" / file)}), MEAN)
    report = engine.run(graph, output=tmp_path / "out.####.exr", frames="1")
    assert (report.frames[0].error.code, report.frames[0].error.hint) == ("missing-file", hint)


def test_a_neighbour_that_cannot_be_read_names_its_frame_and_node(tmp_path):
    graph = load(chain("mean", plate={"file": greys(tmp_path / "in", *range(1, 7))}), MEAN)
    (tmp_path / "in/plate.0006.exr").write_bytes(b"no picture")
    report = engine.run(graph, output=tmp_path / "out.####.exr")
    assert list(codes(report)) == [4, 5, 6]
    assert {(each.error.frame, each.error.node) for each in report.frames[3:]} == {(6, "plate")}


def test_a_node_that_fails_on_another_frame_names_that_frame(tmp_path):
    def run(context, image, *, radius):
        if context.frame == 6:
            raise ZeroDivisionError("oh")
        return image[0]

    nodes = chain("mean", "window", plate={"file": greys(tmp_path, *range(1, 9))}, mean={"radius": 0})
    window = replace(MEAN, type="window")
    with pytest.raises(FlowabsError) as failure:
        load(nodes, asking(MEAN.frames, run), window).run(5)
    assert (failure.value.node, failure.value.frame) == ("mean", 6)


def test_the_own_frame_follows_the_policy_beyond_the_ends_too(tmp_path, watching, seen):
    graph = load(chain("mean", plate={"file": greys(tmp_path, 1, 2, 3), "missing": "hold"}), watching)
    graph.run(4)
    graph.run(9)
    assert seen == {4: [2, 3, 4], 9: [9]}
    skipping = load(chain("mean", plate={"file": greys(tmp_path, 1, 2, 3), "missing": "skip"}), watching)
    with pytest.raises(CommandError, match="skipped"):
        skipping.run(4)


def test_a_frame_whose_own_plate_is_skipped_is_left_out(tmp_path):
    graph = load(chain("mean", plate={"file": greys(tmp_path / "in", 1, 2, 4)}), MEAN)
    report = engine.run(graph, output=tmp_path / "out.####.exr", frames="1-4", missing="skip")
    assert statuses(report) == [(1, "done"), (2, "done"), (3, "skipped"), (4, "done")]
    assert not (tmp_path / "out.0003.exr").exists()


# ---------------------------------------------------------------------- several plates


def two_plates(tmp_path, first, second, policy="error"):
    """Return the mean of a composite of two sequences."""
    inputs = {"image": "plate", "mask": "matte"}
    return {
        "plate": node("read", file=greys(tmp_path / "a", *first)),
        "other": node("read", file=greys(tmp_path / "b", *second), missing=policy),
        "matte": node("matte", "other"),
        "comp": {"type": "exposure@1", "inputs": inputs, "params": {"stops": 0}},
        "mean": node("mean", "comp"),
        "out": node("write", "mean"),
    }


@pytest.mark.parametrize(
    ("policy", "frame", "expected"),
    [
        ("error", 4, [3, 4, 5, 6]),  # frame 2 is beyond the end of the second plate
        ("hold", 4, [3, 4, 5, 6]),  # there is no earlier frame to hold
        ("skip", 4, [3, 4, 5, 6]),
        ("nearest", 4, [2, 3, 4, 5, 6]),
        ("black", 4, [2, 3, 4, 5, 6]),
        ("hold", 7, [5, 6, 7, 8]),
        ("nearest", 1, [1, 2, 3]),
        ("skip", 6, [4, 5, 6]),
        ("hold", 6, [4, 5, 6, 7, 8]),
    ],
)
def test_plates_of_different_lengths(tmp_path, watching, seen, policy, frame, expected):
    load(two_plates(tmp_path, range(1, 9), range(3, 7), policy), watching).run(frame)
    assert seen == {frame: expected}


def test_a_hole_in_either_plate_is_an_error(tmp_path):
    graph = load(two_plates(tmp_path, [1, 2, 4, 5], [1, 2, 3, 5], "skip"), MEAN)
    with pytest.raises(ReadError) as failure:
        graph.run(2)
    assert (failure.value.node, failure.value.frame) == ("plate", 3)


def test_a_single_picture_beside_a_sequence_is_on_all_of_its_frames(tmp_path, watching, seen):
    nodes = two_plates(tmp_path, [1, 2, 3], [7])
    nodes["other"]["params"]["file"] = str(tmp_path / "b/plate.0007.exr")
    load(nodes, watching).run(3)
    assert seen == {3: [1, 2, 3]}


# ---------------------------------------------------------------------- given images


@pytest.fixture
def graph(watching):
    return load(chain("mean"), watching)


def test_a_given_image_is_that_of_its_frame_alone(graph, seen):
    image = grey(3)
    assert graph.run(5, given={"plate": image})["mean"].pixels.max() == 3
    assert seen == {5: [5]}


def test_images_may_be_given_by_frame(graph, seen):
    images = {frame: grey(2.0**frame) for frame in (9, 3, 4, 5, 8, 6)}
    assert frames_read(graph, 5, 4, given={"plate": images}) == [3, 4, 5, 6]
    assert frames_read(graph, 8, 3, given={"plate.image": images}) == [6, 8, 9]


def test_images_given_by_frame_stand_in_for_any_output(tmp_path, watching, seen):
    nodes = two_plates(tmp_path, range(1, 9), range(1, 9))
    matte = Image.from_array(np.ones((4, 6)), type="matte")
    load(nodes, watching).run(4, given={"matte": {4: matte, 5: matte}})
    assert seen == {4: [4, 5]}


def test_given_frames_are_made_smaller_too(graph):
    images = {frame: grey(2.0**frame) for frame in (1, 2)}
    assert graph.run(1, given={"plate": images}, scale=0.5)["mean"].pixels.shape == (2, 3, 3)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({4: "image"}, r"given\['plate'\]: expected an Image of frame 5, the one to run, .*found 4"),
        ({}, "found none"),
        ({5: "image", "6": "image"}, "expected frame numbers, found '6'"),
        ({5: "image", True: "image"}, "found True"),
        ({5: "image", 6: "list"}, r"given\['plate'\]\[6\]: expected an Image or an array, found list"),
        ({5: "image", 6: "flow"}, r"given\['plate'\]\[6\]: expected color, found flow"),
    ],
)
def test_frames_that_cannot_be_given(graph, given, words):
    things = {"image": grey(1), "list": [[0.5, 0.5]], "flow": Image.from_array(np.ones((4, 6, 2)))}
    with pytest.raises(ArgumentError, match=words):
        graph.run(5, given={"plate": {frame: things[name] for frame, name in given.items()}})


# ---------------------------------------------------------------------- frames() that breaks a rule


@pytest.mark.parametrize(
    ("frames", "words"),
    [
        ({"image": range(-1000, 1001)}, "node mean: .*mean@1 asks for 2001 frames.*at most 64"),
        ({"image": (-1, 1)}, "node mean: .*0 must be among"),
        ({"imag": (0,)}, "node mean: .*did you mean 'image'"),
    ],
)
def test_a_wrong_frames_is_an_error_of_its_node(tmp_path, frames, words):
    graph = load(chain("mean", plate={"file": greys(tmp_path, 1, 2)}), asking(frames))
    with pytest.raises(FlowabsError, match=words) as failure:
        graph.run(2)
    assert (failure.value.code, failure.value.node, failure.value.frame) == ("wrong-frames", "mean", 2)
    report = engine.run(graph, output=tmp_path / "out.####.exr")
    assert codes(report) == {1: "wrong-frames", 2: "wrong-frames"}


def test_a_mean_of_one_frame_needs_no_others(tmp_path, watching, seen):
    load(chain("mean", plate={"file": greys(tmp_path, 1, 2, 3)}, mean={"radius": 0}), watching).run(2)
    assert seen == {2: [2]}
