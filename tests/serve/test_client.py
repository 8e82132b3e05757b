"""Renders of a real server: the bits of a run here; cancelled at once; a server that dies is replaced."""

import os
import signal
import sys
import threading
import time

import numpy as np
import pytest

import flowabs_nodes as fa
from flowabs_nodes.errors import ArgumentError, Cancelled, FlowabsError
from flowabs_nodes.image import Image
from flowabs_nodes.serve.client import Client, Pixels, ServerDied
from tests.serve.wire import PATIENCE, graph_file, plate, slow_plate


def drawn(graph, pixels, output="bright", **run):
    """Return what a run in this process makes of pixels, an image."""
    said = {"colorspace": pixels.colorspace, "rows": pixels.rows}
    if pixels.alpha == "opaque":
        said["channels"] = "RGBX"
    else:
        said["alpha"] = pixels.alpha
    height, width = pixels.array.shape[:2]
    windows = {"data_window": (*pixels.window, width, height), "display_window": pixels.display}
    image = Image.from_array(pixels.array, type="color", **said, **windows)
    return fa.load_graph(graph).run(given={"plate": image}, outputs=[output], **run)[output]


def strided(array, gap=24):
    """Return the pixels in memory with a gap behind each row."""
    height, row = array.shape[0], array.shape[1] * array.shape[2] * array.itemsize
    memory = np.zeros((height, row + gap), np.uint8)
    view = np.ndarray(array.shape, array.dtype, memory, 0, (row + gap, array.shape[2] * array.itemsize, array.itemsize))
    view[...] = array
    return view


LAYOUTS = {
    "float": Pixels(plate()),
    "half": Pixels(plate().astype(np.float16)),
    "rgb": Pixels(plate(channels=3)),
    "bottom-up": Pixels(plate(), rows="bottom-up"),
    "last row first in memory": Pixels(plate()[::-1]),
    "gaps": Pixels(strided(plate())),
    "gaps and last row first": Pixels(strided(plate())[::-1]),
    "straight": Pixels(plate(), alpha="straight"),
    "opaque": Pixels(plate(), alpha="opaque"),
    "window": Pixels(plate(), window=(-3, 5), display=(0, 0, 40, 30)),
    "acescg": Pixels(plate(), colorspace="ACEScg"),
    "srgb": Pixels(plate().clip(0, 1), colorspace="sRGB", alpha="straight"),
    "8 bits": Pixels((plate() * 160).astype(np.uint8), colorspace="sRGB", alpha="straight"),
    "16 bits": Pixels((plate() * 40000).astype(np.uint16), colorspace="sRGB", alpha="straight", rows="bottom-up"),
    "one pixel": Pixels(plate(1, 1)),
}


def expected(pixels, image):
    """Return what an image is in the layout of ``pixels``."""
    said = {"colorspace": pixels.colorspace, "rows": pixels.rows, "dtype": pixels.array.dtype}
    names = {3: "RGB", 4: "RGBX" if pixels.alpha == "opaque" else "RGBA"}[pixels.array.shape[2]]
    alpha = "premultiplied" if pixels.alpha == "opaque" else pixels.alpha
    return image.to_array(**said, alpha=alpha, channels=names)


def shared_as(client, pixels):
    """Return the same pixels in memory of the client, with the same strides."""
    array = pixels.array
    step = array.strides[0]
    memory = client.array((array.shape[0] * abs(step) + 40,), np.uint8)
    first = 40 + (abs(step) * (array.shape[0] - 1) if step < 0 else 0)
    there = np.ndarray(array.shape, array.dtype, memory, first, array.strides)
    there[...] = array
    return Pixels(**{**vars(pixels), "array": there})


@pytest.mark.parametrize("where", ["shared", "elsewhere"])
@pytest.mark.parametrize("layout", LAYOUTS)
def test_the_bits_are_those_of_a_run_here(client, graph, layout, where):
    pixels = LAYOUTS[layout]
    image = drawn(graph, pixels, set={"stops": 0.5})
    source, target = pixels, Pixels(**{**vars(pixels), "array": np.zeros_like(pixels.array)})
    if where == "shared":
        source, target = shared_as(client, source), shared_as(client, target)
    target.array[...] = 7
    out = client.render(graph, {"plate": source}, {"bright": target}, set={"stops": 0.5}, session=layout)
    assert out["bright"] is target.array
    np.testing.assert_array_equal(target.array, expected(pixels, image))
    assert not np.array_equal(target.array, pixels.array)
    assert out.said["bright"]["memory"] is not None


@pytest.mark.parametrize("name", ["lines", "abstraction"])
def test_the_bits_of_a_shipped_graph_are_those_of_a_run_here(client, name):
    pixels = Pixels(plate(40, 60))
    output = client.describe(name)["outputs"][0]["name"]
    image = drawn(name, pixels, output, scale=0.5, frame=3)
    out = client.render(name, {"plate": pixels}, [output], frame=3, scale=0.5)
    np.testing.assert_array_equal(out[output], image.to_array(channels="RGBA"))
    assert out[output].shape == (20, 30, 4)


def test_a_part_of_the_picture_is_that_part_of_the_whole(client, graph):
    pixels = Pixels(plate(), window=(10, 4), display=(0, 0, 64, 48))
    whole = drawn(graph, pixels).pixels
    part = client.array((6, 9, 4))
    said = client.render(graph, {"plate": pixels}, {"bright": Pixels(part, window=(14, 7))}).said["bright"]
    np.testing.assert_array_equal(part, whole[3:9, 4:13])
    assert (said["window"], said["display"]) == ([14, 7], [0, 0, 64, 48])


def test_only_what_was_asked_for_is_computed_and_only_what_changed(client):
    nodes = []

    def ran(into, **knobs):
        nodes.clear()
        client.render("abstraction", {"plate": plate(24, 32)}, into, session="tuned", set=knobs, on_event=note)
        return set(nodes)

    def note(event):
        if event["event"] == "node" and event["status"] == "started" and event["type"]:
            nodes.append(event["node"])

    assert ran(["lines"]) == {"broad", "flow_shoulder", "flow", "pre", "ink_shoulder", "lines"}
    assert ran(["comp"]) == {"smooth", "flat", "comp"}
    assert ran(["comp"], ink_opacity=0.5) == {"comp"}
    assert ran(["comp"]) == set()
    client.forget("tuned")
    assert ran(["lines"]) == {"broad", "flow_shoulder", "flow", "pre", "ink_shoulder", "lines"}


def test_one_channel_goes_where_a_color_does_and_is_grey(client, graph):
    mask = plate(12, 20, 1)[..., 0]
    out = client.render(graph, {"plate": mask}, ["bright"])["bright"]
    np.testing.assert_array_equal(out[..., :3], np.repeat(mask[..., None] * 2, 3, axis=2))
    np.testing.assert_array_equal(out[..., 3], 1)


def test_notes_are_told_with_the_answer(client):
    out = client.render("lines", {"plate": plate(24, 32)}, ["lines"])
    assert any("too short at this size" in note["text"] for note in out.notes)
    assert out.seconds > 0


@pytest.mark.parametrize(
    ("changes", "code", "said"),
    [
        ({"graph": "abstracton"}, "unknown-graph", "did you mean 'abstraction'"),
        ({"graph": "/none/there.json"}, "unreadable-graph", "No such file"),
        ({"into": ["brigt"]}, "unknown-node", "did you mean 'bright'"),
        ({"into": []}, "bad-request", "expected at least one output"),
        ({"given": {"plat": plate()}}, "unknown-node", "did you mean 'plate'"),
        ({"given": {}}, "missing-file", "plate"),
        ({"given": {"plate": Pixels(plate(), colorspace="sRBG")}}, "bad-colorspace", "given.plate: "),
        ({"given": {"plate": (plate() * 90).astype(np.uint8)}}, "bad-value", "given.plate: "),
        ({"set": {"stopps": 3}}, "bad-graph", "did you mean 'stops'"),
        ({"set": {"stops": 30}}, "bad-graph", "found 30"),
        ({"scale": 0}, "bad-value", "scale"),
        ({"frame": 1.5}, "bad-request", "frame: expected a whole number"),
    ],
)
def test_what_is_wrong_is_told_and_the_next_render_is_right(client, graph, changes, code, said):
    asked = {"graph": graph, "given": {"plate": plate()}, "into": ["bright"]} | changes
    with pytest.raises(FlowabsError) as raised:
        client.render(asked.pop("graph"), asked.pop("given"), asked.pop("into"), **asked)
    assert raised.value.code == code or code == "missing-file"
    assert said in str(raised.value)
    assert "Traceback" not in str(raised.value)
    client.render(graph, {"plate": plate()}, ["bright"])


@pytest.mark.parametrize("array", [None, np.zeros(3), np.zeros((2, 2, 5)), np.zeros((0, 2, 3))])
def test_what_is_no_picture_is_refused_here(client, graph, array):
    with pytest.raises(ArgumentError, match="picture: expected"):
        client.render(graph, {"plate": array}, ["bright"])


def test_renders_of_several_threads_and_sessions_are_each_their_own(client, graph):
    found = {}

    def work(number):
        for turn in range(5):
            pixels = plate(30, 40, seed=10 * number + turn)
            stops = number + turn / 8 - 2
            out = client.render(graph, {"plate": pixels}, ["bright"], set={"stops": stops}, session=str(number // 2))
            right = np.array_equal(out["bright"][..., :3], pixels[..., :3] * np.float32(2**stops))
            found[number, turn] = right

    threads = [threading.Thread(target=work, args=(number,)) for number in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(PATIENCE)
    assert len(found) == 20
    assert all(found.values())


def at_work(event):
    return event["event"] == "node" and event["status"] == "started" and event["node"] == "bright"


def test_a_render_is_cancelled_at_once_and_so_is_one_that_waits_for_its_turn(client, slow):
    begun, times = threading.Event(), []

    def render():
        with pytest.raises(Cancelled):
            client.render(
                slow, {"plate": slow_plate()}, ["bright"], session="slow", on_event=lambda e: at_work(e) and begun.set()
            )
        times.append(time.monotonic())

    threads = [threading.Thread(target=render) for _ in range(2)]
    for thread in threads:
        thread.start()
    assert begun.wait(PATIENCE)
    time.sleep(0.2)
    cancelled = time.monotonic()
    client.cancel("another session")
    client.cancel("slow")
    for thread in threads:
        thread.join(PATIENCE)
    assert len(times) == 2
    assert max(times) - cancelled < 2


def test_what_was_cancelled_can_be_asked_for_again(client, slow, tmp_path):
    with pytest.raises(Cancelled):
        client.render(
            slow,
            {"plate": slow_plate()},
            ["bright"],
            session="again",
            on_event=lambda e: at_work(e) and client.cancel(),
        )
    graph = graph_file(tmp_path, "slow.json")  # under the same name a quick one
    client.render(graph, {"plate": slow_plate()}, ["bright"], session="again")


def kill(pid):
    os.kill(pid, signal.SIGKILL if sys.platform != "win32" else signal.SIGTERM)


def test_a_server_that_is_killed_in_the_middle_of_a_frame_is_replaced_and_the_frame_made(tmp_path):
    slower = {"type": "bilateral@1", "inputs": {"image": "plate"}, "params": {"sigma_d": 10, "iterations": 2}}
    graph = graph_file(tmp_path, **slower)
    pids = []
    with Client() as client:
        source, target = client.array((100, 100, 4)), client.array((100, 100, 4))
        source[...] = plate(100, 100)

        def killer():
            pids.append(client.hello()["pid"])
            kill(pids[0])

        def on_event(event):
            if at_work(event) and not pids:
                threading.Thread(target=killer).start()

        client.render(graph, {"plate": source}, {"bright": target}, on_event=on_event)
        assert client.hello()["pid"] != pids[0]
        again = client.array((100, 100, 4))
        client.render(graph, {"plate": source}, {"bright": again})
    np.testing.assert_array_equal(target, again)
    np.testing.assert_array_equal(target, drawn(graph, Pixels(plate(100, 100))).pixels)


def test_a_server_that_dies_twice_is_an_error_and_not_for_ever(slow):
    with Client() as client:

        def kill_it(event):
            if at_work(event):
                threading.Thread(target=lambda: kill(client.hello()["pid"])).start()

        with pytest.raises(ServerDied, match="the server has ended"):
            client.render(slow, {"plate": slow_plate()}, ["bright"], on_event=kill_it)
        assert client.hello()["protocol"] == 1


def test_a_server_that_does_not_start_is_an_error(capfd):
    with pytest.raises(ServerDied, match="before it said a word"):
        Client(["--cache", "much"])
    assert "cache: expected a size" in capfd.readouterr().err


def test_a_client_that_is_closed_starts_nothing(graph):
    client = Client()
    client.close()
    with pytest.raises(ServerDied):
        client.render(graph, {"plate": plate()}, ["bright"])


def mapped(pid):
    """Return how many memories of clients a process has mapped."""
    with open(f"/proc/{pid}/maps") as maps:
        return sum("/flowabs-" in line for line in maps)


@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="nobody tells what is mapped")
def test_memory_is_let_go_with_the_arrays_in_it_on_both_sides(graph):
    before = mapped("self")
    with Client() as client:
        pid = client.hello()["pid"]
        kept = client.array((10, 10, 4))
        for size in range(1, 40):
            pixels = client.array((size, 7, 4))
            client.render(graph, {"plate": pixels}, {"bright": np.zeros((size * size, 3, 4), np.float32)})
        del pixels
        client.render(graph, {"plate": kept}, {"bright": kept})
        assert client.hello()
        assert mapped(pid) == mapped("self") - before <= 8


@pytest.mark.skipif(not os.path.isdir("/dev/shm"), reason="memory is elsewhere")
def test_no_name_is_left_in_memory(client, graph):
    client.render(graph, {"plate": plate()}, {"bright": client.array((12, 20, 4))})
    assert not [name for name in os.listdir("/dev/shm") if name.startswith("flowabs-")]
