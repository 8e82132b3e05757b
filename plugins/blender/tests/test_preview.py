"""The preview shows what the sliders say, at its scale, the newest first; nothing of it stays behind."""

import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import bpy
import flowabs_blender
import numpy as np
import pytest
from flowabs_blender import preview, work_end
from flowabs_blender.preview_worker import PreviewWorker, Wish
from flowabs_blender.read_datablock import image_of, take
from pictures import held, made, picture

import flowabs_nodes as fa
from flowabs_nodes.errors import Cancelled


@pytest.fixture
def tree() -> Iterator[Any]:
    """Return the shipped graph "abstraction" with a plate of 80 x 60, opaque."""
    bpy.ops.flowabs.new_from_preset(preset="abstraction")
    tree = bpy.data.node_groups["abstraction"]
    pixels = picture(60, 80)
    pixels[..., 3] = 1
    tree.run_settings.image = made(pixels, name="plate")
    yield tree
    preview.close_all()


def until(done: Callable[[], bool], seconds: float = 60.0) -> None:
    """Call the timer by hand, as Blender does with a window, until something has happened."""
    end = time.monotonic() + seconds
    while not done():
        assert time.monotonic() < end, "nothing happened"
        preview.tick()
        time.sleep(0.005)


def settled(tree: Any) -> np.ndarray:
    """Return the pixels of the preview once it shows all changes."""
    preview.tick()
    until(lambda: preview.preview_of(tree).settled)
    return held(bpy.data.images["abstraction preview"])


def expected(tree: Any, scale: float = 0.5, output: str = "comp", **knobs: Any) -> np.ndarray:
    plate = image_of(tree.run_settings.image)
    return (
        fa.load_graph("abstraction").run(given={"plate": plate}, set=knobs, outputs=output, scale=scale)[output].pixels
    )


def test_it_follows_knobs_parameters_output_and_scale(tree: Any) -> None:
    assert bpy.ops.flowabs.preview() == {"FINISHED"}
    assert bpy.app.timers.is_registered(preview.tick)
    np.testing.assert_array_equal(settled(tree)[..., :3], expected(tree))
    tree["line_width"] = 2.0
    np.testing.assert_array_equal(settled(tree)[..., :3], expected(tree, line_width=2))
    tree.nodes["flat"].p_softness = 0.25
    np.testing.assert_array_equal(settled(tree)[..., :3], expected(tree, line_width=2, **{"flat.softness": 0.25}))
    tree.run_settings.output, tree.run_settings.scale = "lines", "0.25"
    np.testing.assert_array_equal(settled(tree)[..., :1], expected(tree, 0.25, "lines", line_width=2))
    assert preview.preview_of(tree).problem == ""
    bpy.ops.flowabs.preview()
    assert preview.preview_of(tree) is None
    assert preview.tick() is None


def test_another_picture_and_frame(tree: Any) -> None:
    preview.switch(tree, on=True)
    settled(tree)
    tree.keyframe_insert('["ink_opacity"]', frame=1)
    tree["ink_opacity"] = 0.0
    tree.keyframe_insert('["ink_opacity"]', frame=3)
    tree.update()
    bpy.context.scene.frame_set(2)
    shown = settled(tree)
    np.testing.assert_array_equal(shown[..., :3], expected(tree, ink_opacity=0.5))
    pixels = picture(30, 20)
    pixels[..., 3] = 1
    tree.run_settings.image = made(pixels, name="other")
    assert settled(tree).shape == (15, 10, 4)


def test_the_newest_wish_wins(tree: Any) -> None:
    preview.switch(tree, on=True)
    settled(tree)
    for step in range(40):
        tree["line_width"] = 0.5 + step / 20
        preview.tick()
    np.testing.assert_array_equal(settled(tree)[..., :3], expected(tree, line_width=0.5 + 39 / 20))


def test_a_slider_that_never_rests_shows_something(tree: Any) -> None:
    preview.switch(tree, on=True)
    first = settled(tree)
    begin = time.monotonic()

    def moved() -> bool:
        tree["coherence"] = 1 + 5 * ((time.monotonic() - begin) * 7 % 1)
        return not np.array_equal(held(bpy.data.images["abstraction preview"]), first)

    until(moved)


def test_a_graph_that_is_wrong_says_so_and_keeps_the_picture(tree: Any) -> None:
    preview.switch(tree, on=True)
    shown = settled(tree)
    link = next(link for link in tree.links if link.to_node.name == "lines" and link.to_socket.port == "flow")
    source = link.from_socket
    tree.links.remove(link)
    tree.update()
    np.testing.assert_array_equal(settled(tree), shown)
    assert preview.preview_of(tree).problem == "the graph cannot run: lines: Flow is not linked"
    tree.links.new(source, next(each for each in tree.nodes["lines"].inputs if each.port == "flow"))
    tree.update()
    settled(tree)
    assert preview.preview_of(tree).problem == ""


def test_no_picture(tree: Any) -> None:
    tree.run_settings.image = None
    with pytest.raises(RuntimeError, match="no picture is chosen"):
        bpy.ops.flowabs.preview()
    preview.switch(tree, on=True)
    preview.tick()
    assert preview.preview_of(tree).problem == "no picture is chosen"
    empty = bpy.data.images.new("empty", 4, 4)
    empty.source = "FILE"
    tree.run_settings.image = empty
    preview.tick()
    assert preview.preview_of(tree).problem == "image 'empty': there are no pixels"


@pytest.mark.parametrize("how", ["rename", "remove", "load", "unregister"])
def test_nothing_stays_behind(how: str, tree: Any) -> None:
    preview.switch(tree, on=True)
    settled(tree)
    assert [each for each in threading.enumerate() if each.name == "flowabs-preview"]
    if how == "rename":
        tree.name = "renamed"
        preview.tick()
    elif how == "remove":
        bpy.data.node_groups.remove(tree)
        preview.tick()
    elif how == "load":
        bpy.ops.wm.read_homefile(use_empty=True)
    else:
        flowabs_blender.unregister()
        assert work_end.end_work not in bpy.app.handlers.load_pre
        assert not bpy.app.timers.is_registered(preview.tick)
        flowabs_blender.register()
    assert not [each for each in threading.enumerate() if each.name == "flowabs-preview"]
    assert preview.tick() is None


def test_a_run_that_is_overtaken_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    begun, ended = threading.Event(), []
    fulfil = PreviewWorker._fulfil

    def watched(self: PreviewWorker, wish: Wish) -> Any:
        begun.set()
        try:
            shown = fulfil(self, wish)
        except BaseException as error:
            ended.append((wish.scale, type(error)))
            raise
        ended.append((wish.scale, None))
        return shown

    monkeypatch.setattr(PreviewWorker, "_fulfil", watched)
    taken = take(made(picture(600, 800), name="large"))
    graph = fa.load_graph("abstraction").document
    worker = PreviewWorker(taken.working)

    def shown() -> Any:
        end = time.monotonic() + 60
        while (found := worker.take()) is None:
            assert time.monotonic() < end
            time.sleep(0.002)
        return found

    worker.ask(Wish(graph, taken, "", 1, 0.1))
    assert shown().error is None
    begun.clear()
    worker.ask(Wish(graph, taken, "", 1, 1.0))
    assert begun.wait(10)
    while worker._session is None or not worker._session._calls:  # until its filters are at work
        time.sleep(0.001)
    worker.ask(Wish(graph, taken, "", 1, 0.2))
    assert shown().pixels.shape == (120, 160, 4)
    assert ended == [(0.1, None), (1.0, Cancelled), (0.2, None)]
    worker.close()
    assert not worker._thread.is_alive()
