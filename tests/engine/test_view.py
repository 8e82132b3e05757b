"""Looking at a node: which frame, into which file, and what is in the way; from Python, a picture."""

import numpy as np
import OpenImageIO as oiio
import pytest

import flowabs_nodes as fa
from flowabs_nodes.color import srgb
from flowabs_nodes.engine import RunOptions, load_graph
from flowabs_nodes.engine.view import as_png, build_view
from flowabs_nodes.errors import ColorError, CommandError
from flowabs_nodes.image import Image
from flowabs_nodes.looking.picture import picture_of
from tests.color.configs import with_displays
from tests.engine.sequences import document, plates

GRAPH = document(
    plate={"type": "read@1"},
    bright={"type": "exposure@1", "inputs": {"image": "plate"}},
    ink={"type": "matte@1", "inputs": {"image": "bright"}, "params": {"channel": "luminance"}},
)


def view(node, **options):
    return build_view(GRAPH, node, RunOptions(**options))


def png(path):
    return oiio.ImageBuf(str(path)).get_pixels(oiio.UINT8)


def test_a_picture_of_a_node_of_a_graph_that_writes_nothing(shot, tmp_path):
    events = []
    found = view("bright", input=shot, output=tmp_path / "look.png", set={"bright.stops": 1})
    picture = found.picture(events.append)
    found.save(picture)
    expected, said = picture_of(found.graph.run(1, outputs="bright")["bright"])
    np.testing.assert_allclose(png(tmp_path / "look.png"), srgb.encoded(expected.pixels) * 255, atol=0.6)
    assert (events[-1]["node"], events[-1]["text"]) == ("bright", said)
    assert found.output == "bright.image"


def test_it_is_the_first_frame_that_is_asked_for_or_there(shot, tmp_path):
    assert view("plate", input=shot).frame == 1
    assert view("plate", input=shot, frames="3,2").frame == 3
    assert view("plate", input=plates(tmp_path / "late", 12, 13)).frame == 12
    assert view("plate", input=shot, output="a.####.png", frames=2).file == "a.0002.png"


def test_frames_that_are_missing_go_by_the_rule_of_the_run(shot):
    assert view("plate", input=shot, frames=9, missing="hold").picture().pixels.any()
    assert view("plate", input=shot, frames=9, missing="black").picture().pixels.max() < 1e-6
    with pytest.raises(CommandError, match="missing frames are skipped"):
        view("plate", input=shot, frames=9, missing="skip").picture()


def test_scale_makes_a_smaller_picture(shot):
    assert view("plate", input=shot, scale=0.5).picture().pixels.shape == (24, 32, 3)


def test_only_what_the_output_needs_is_read(shot):
    more = GRAPH | {"nodes": GRAPH["nodes"] | {"other": {"type": "read_depth@1", "params": {"file": "nowhere.exr"}}}}
    assert build_view(more, "plate", RunOptions(input=shot)).picture().type == "color"


def test_what_a_view_wrote_is_made_again_and_nothing_else_is(shot, tmp_path):
    path = tmp_path / "look.png"
    for _ in range(2):
        found = view("plate", input=shot, output=path)
        found.save(found.picture())
    with pytest.raises(CommandError, match="exists already"):
        view("plate", input=shot, output=path, existing="error")
    fa.run(
        document(plate={"type": "read@1"}, out={"type": "write@1", "inputs": {"image": "plate"}}),
        input=shot,
        output=tmp_path / "run.png",
        frames=1,
    )
    (tmp_path / "foreign.png").write_bytes(b"mine")
    for name in ("run.png", "foreign.png"):
        with pytest.raises(CommandError, match="no view that flowabs wrote") as failure:
            view("plate", input=shot, output=tmp_path / name)
        assert failure.value.hint == "--existing overwrite replaces it"
        assert view("plate", input=shot, output=tmp_path / name, existing="overwrite").file


@pytest.mark.parametrize(
    ("node", "options", "code", "hint"),
    [
        ("brigt", {}, "unknown-node", "did you mean 'bright'?"),
        ("ink.mate", {}, "unknown-output", "did you mean 'matte'? known: matte"),
        ("plate", {"output": ["a.png", "b.png"]}, "several-outputs", ""),
        ("plate", {"output": "a.exr"}, "bad-format", "an EXR holds the numbers themselves"),
        ("plate", {"output": "a.jpg"}, "bad-format", ""),
        ("plate", {"output": "nowhere/../a.png", "root": "elsewhere"}, "outside-root", ""),
        ("plate", {"frames": "1-"}, "bad-frames", ""),
    ],
)
def test_wrong_commands(shot, node, options, code, hint):
    with pytest.raises(CommandError) as failure:
        view(node, input=shot, **options)
    assert failure.value.code == code
    assert hint in failure.value.hint


def test_an_input_is_never_written_over(tmp_path):
    photo = tmp_path / "photo.png"
    oiio.ImageBuf(np.zeros((4, 4, 3), np.uint8)).write(str(photo))
    with pytest.raises(CommandError, match="over an input"):
        view("plate", input=photo, output=photo, existing="overwrite")


def test_a_file_that_is_not_set():
    with pytest.raises(CommandError, match="no file to read is set"):
        view("plate")


def test_a_node_that_only_writes_says_what_goes_into_it(shot):
    writing = GRAPH | {"nodes": GRAPH["nodes"] | {"out": {"type": "write@1", "inputs": {"image": "bright"}}}}
    with pytest.raises(CommandError) as failure:
        build_view(writing, "out", RunOptions(input=shot))
    assert failure.value.hint == "ask for what goes into it: bright.image"


def test_colour_is_seen_by_the_config_of_the_run(shot, tmp_path):
    events = []
    view("plate", input=shot, ocio=with_displays(tmp_path / "studio.ocio")).picture(events.append)
    assert "'film' of the display 'wall'" in events[-1]["text"]
    with pytest.raises(ColorError):
        view("plate", input=shot, ocio="no such config")


def test_from_python_with_pictures_in_memory():
    plate = Image.from_array(np.random.default_rng(1).random((6, 8, 3)))
    picture = load_graph("flow").view("flow", given={"plate": plate}, set={"flow.radius": 2})
    assert picture.type == "color"
    assert np.ptp(picture.pixels) > 0.1


def test_a_png_for_a_terminal_is_no_larger_than_asked_for(tmp_path):
    picture = Image.from_array(np.full((40, 100, 3), 0.5))
    (tmp_path / "a.png").write_bytes(as_png(picture, 50))
    assert png(tmp_path / "a.png").shape == (20, 50, 3)
    (tmp_path / "b.png").write_bytes(as_png(picture, 1000))
    assert png(tmp_path / "b.png").shape == (40, 100, 3)
