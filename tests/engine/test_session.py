"""Session: what changed is computed, the rest is there; a run can be cancelled whatever is at work."""

import threading
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import flowabs_nodes as fa
from flowabs_nodes import graph as graphs
from flowabs_nodes.engine.session import Session
from flowabs_nodes.errors import ArgumentError, Cancelled, CommandError, FlowabsError, InternalError
from flowabs_nodes.graph import GraphError
from flowabs_nodes.nodes import catalogue
from flowabs_nodes.nodes.declare import Context, Node, Param, Port
from flowabs_nodes.simd import bands
from tests.engine.fakes import IMAGE, picture
from tests.engine.sequences import plate


def tally(ran):
    """Return a node that adds, and notes in ``ran`` that it ran."""

    def add(context: Context, image, *, amount: float):
        ran.append((context.node, context.frame))
        return image.with_pixels(image.pixels + np.float32(amount))

    return node_of(add)


def node_of(run):
    """Return the node ``tally``, which does what ``run(context, image, amount=...)`` says."""
    params = (Param.float("amount", 1.0, min=-100, max=100, help="How much."),)
    return Node("tally", 1, "Adds.", (IMAGE,), (Port("image", "=image", "The sum."),), params, run)


def chain(node, **interface):
    """Return a graph: plate, three nodes of this type one after the other; a knob ``last`` moves the third."""
    document = {
        "format": "flowabs.graph/1",
        "interface": {"last": {"type": "float", "default": 1, "min": 0, "max": 50, **interface}},
        "nodes": {
            "plate": {"type": "read@1"},
            "one": {"type": "tally@1", "inputs": {"image": "plate"}},
            "two": {"type": "tally@1", "inputs": {"image": "one"}},
            "three": {"type": "tally@1", "inputs": {"image": "two"}, "params": {"amount": {"from": "last"}}},
            "out": {"type": "write@1", "inputs": {"image": "three"}},
        },
    }
    return graphs.load(document, catalogue() | {"tally": node})


@pytest.fixture
def ran():
    return []


@pytest.fixture
def session(ran):
    with Session(chain(tally(ran))) as session:
        session.given(plate=picture())
        yield session


def test_a_run_is_that_of_the_graph(session):
    session.set({"last": 3, "one.amount": -1})
    out = session.run(["two", "three"], frame=4)
    expected = session.graph.run(4, {"plate": picture()}, outputs=["two", "three"])
    assert list(out) == ["two", "three"]
    for name in out:
        np.testing.assert_array_equal(out[name].pixels, expected[name].pixels)
    assert session.run()["three"].pixels is not None


def test_only_what_a_change_touches_runs_again(session, ran):
    session.run()
    assert ran == [("one", 1), ("two", 1), ("three", 1)]
    ran.clear()
    session.set(last=2)
    session.run()
    assert ran == [("three", 1)]
    ran.clear()
    session.set({"two.amount": 5})
    session.run()
    assert ran == [("two", 1), ("three", 1)]
    ran.clear()
    session.set({"two.amount": 1, "last": 1})
    session.run()
    assert ran == []  # both results are still there
    session.run("two")
    assert ran == []


def test_another_scale_frame_or_picture_runs_again_and_the_same_picture_does_not(session, ran):
    session.run()
    ran.clear()
    session.run(scale=0.5)
    assert len(ran) == 3
    ran.clear()
    session.run(scale=0.5)
    session.given(plate=picture())
    session.run()
    session.given({"plate": {1: picture()}})
    session.given({"plate": {1: picture(), 2: picture(seed=3)}})
    assert ran == []
    session.run(frame=2)
    assert [frame for _, frame in ran] == [2, 2, 2]
    ran.clear()
    session.given(plate=picture(seed=2))
    out = session.run()["three"]
    assert len(ran) == 3
    np.testing.assert_allclose(out.pixels, picture(seed=2).pixels + 3, rtol=1e-6)


def test_one_pixel_that_differs_is_another_picture(session):
    session.run()
    image = picture()
    pixels = image.pixels.copy()
    pixels[-1, -1, -1] = np.nan
    session.given(plate=image.with_pixels(pixels))
    first = session.run()["three"].pixels
    session.given(plate=image.with_pixels(pixels.copy()))  # NaN is itself, bit for bit
    assert np.isnan(first[-1, -1, -1])
    session.given(plate=image)
    assert np.isfinite(session.run()["three"].pixels).all()


def test_the_plate_is_scaled_once(session, monkeypatch):
    from flowabs_nodes.engine import session_cache

    scaled, scale_image = [], session_cache.scale_image
    monkeypatch.setattr(session_cache, "scale_image", lambda *given: scaled.append(given) or scale_image(*given))
    for last in (1, 2, 3):
        session.set(last=last)
        session.run(scale=0.5)
    assert len(scaled) == 1


@pytest.mark.parametrize("reference", [None, {"shorter": 40}], ids=["lengths as written", "lengths of a size"])
def test_a_picture_that_is_small_already_gives_the_bits_of_the_large_one_at_that_scale(reference):
    from flowabs_nodes.engine.resize import scale_image

    document = {
        "format": "flowabs.graph/1",
        "nodes": {
            "plate": {"type": "read@1"},
            "soft": {"type": "blur@1", "inputs": {"image": "plate"}, "params": {"sigma": 3}},
            "out": {"type": "write@1", "inputs": {"image": "soft"}},
        },
    } | ({"reference_size": reference} if reference else {})
    image = fa.Image.from_array(np.random.default_rng(5).random((48, 64, 3)).astype(np.float32))
    with Session(document) as proxy:
        proxy.given(plate=scale_image(image, 0.5))
        small = proxy.run(scale=0.5, scaled=True)["soft"].pixels
        other = proxy.run(scale=1.0)["soft"].pixels
    expected = fa.load_graph(document).run(given={"plate": image}, outputs=["soft"], scale=0.5)["soft"].pixels
    assert np.array_equal(small, expected)
    assert np.array_equal(other, expected) is (reference is not None)  # else only the scale says how long lengths are


def test_a_file_that_changes_is_read_again(ran, tmp_path):
    file = plate(tmp_path / "plate.exr")
    session = Session(chain(tally(ran)))
    session.set({"plate.file": str(file)})
    before = session.run()["three"].pixels
    ran.clear()
    session.run()
    assert ran == []
    plate(file, height=20)
    after = session.run()["three"].pixels
    assert len(ran) == 3
    assert after.shape != before.shape


def test_no_more_bytes_are_held_than_may_be(ran):
    one = picture().pixels.nbytes
    session = Session(chain(tally(ran)), cache_bytes=2 * one)
    session.given(plate=picture())
    for last in range(5):
        session.set(last=last)
        session.run()
        assert session.cached_bytes <= 2 * one
    ran.clear()
    nothing = Session(chain(tally(ran)), cache_bytes=0)
    nothing.given(plate=picture())
    nothing.run()
    nothing.run()
    assert len(ran) == 6


def test_wrong_values_set_nothing_and_all_are_named(session):
    session.set(last=7)
    with pytest.raises(GraphError) as caught:
        session.set({"last": 99, "one.amont": 1})
    assert {problem.code for problem in caught.value.problems} == {"out-of-range", "unknown-param"}
    assert session.knobs()[0].value == 7
    session.reset("last")
    assert session.knobs()[0].value == 1
    session.set({"last": 2, "one.amount": 4})
    session.reset()
    assert session.graph.values(1)["one"]["amount"] == 1


def test_an_edited_graph_keeps_what_it_has_in_common(ran):
    nodes = catalogue() | {"tally": tally(ran)}
    events = []
    session = Session(chain(nodes["tally"]), on_event=events.append)
    session.given(plate=picture())
    session.set({"one.amount": 5})
    session.run()
    ran.clear()
    events.clear()
    edited = chain(nodes["tally"]).document
    edited["nodes"]["four"] = {"type": "tally@1", "inputs": {"image": "three"}}
    session.exchange(graphs.load(edited, nodes))
    four = session.run("four")["four"]
    assert [name for name, _ in ran] == ["one", "two", "three", "four"]  # what was set is forgotten
    assert [(event["node"], event["type"]) for event in events if event["event"] == "node"][-1] == ("four", "tally")
    ran.clear()
    edited["nodes"]["four"]["params"] = {"amount": 2}
    session.exchange(graphs.load(edited, nodes))
    np.testing.assert_array_equal(session.run("four")["four"].pixels, four.pixels + np.float32(1))
    assert [name for name, _ in ran] == ["four"]


def test_pictures_stay_where_an_edited_graph_has_their_names(session, ran):
    session.given(two=picture())
    session.exchange({"format": "flowabs.graph/1", "nodes": {"plate": {"type": "read@1"}}})
    assert list(session._given) == ["plate"]
    with pytest.raises(GraphError):
        session.exchange({"format": "flowabs.graph/1", "nodes": {"plate": {"type": "nothing@1"}}})
    assert session.run("plate")["plate"].pixels.shape == picture().pixels.shape


def test_wrong_pictures_and_names(session):
    with pytest.raises(CommandError, match="plate"):
        session.given(plat=picture())
    with pytest.raises(CommandError):
        session.given(plat=None)
    with pytest.raises(ArgumentError, match="given\\['plate'\\]"):
        session.given(plate="plate.exr")
    with pytest.raises(CommandError, match="three"):
        session.run("threee")
    with pytest.raises(ArgumentError, match="scale"):
        session.run(scale=2)
    with pytest.raises(ArgumentError, match="frame"):
        session.run(frame=1.5)
    session.given(plate=None)
    with pytest.raises(CommandError, match="no file to read"):
        session.run()


def test_a_failure_names_its_node_and_the_next_run_works():
    def fail(context: Context, image, *, amount: float):
        if amount < 0:
            raise ZeroDivisionError("by nothing")
        if amount > 9:
            raise FlowabsError("refused")
        return image

    session = Session(chain(node_of(fail)))
    session.given(plate=picture())
    session.set({"two.amount": 10})
    with pytest.raises(FlowabsError, match="refused") as caught:
        session.run(frame=3)
    assert (caught.value.node, caught.value.frame) == ("two", 3)
    session.set({"two.amount": -1})
    with pytest.raises(InternalError) as caught:
        session.run()
    assert isinstance(caught.value.__cause__, ZeroDivisionError)
    session.reset()
    session.run()


def test_events_come_in_the_thread_that_runs_and_tell_of_what_is_at_work(ran):
    events, threads = [], set()

    def hear(event):
        events.append(event)
        threads.add(threading.get_ident())

    session = Session(chain(tally(ran)), on_event=hear)
    session.given(plate=picture())
    session.run()
    nodes = [event for event in events if event["event"] == "node"]
    assert [(event["node"], event["status"]) for event in nodes] == [
        (node, status) for node in ("one", "two", "three") for status in ("started", "done")
    ]
    progress = [event["progress"] for event in nodes]
    assert progress == sorted(progress)
    assert progress[-1] == 1
    assert threads == {threading.get_ident()}
    events.clear()
    session.set(last=2)
    session.run()
    assert [event["node"] for event in events if event["status"] == "done"] == ["three"]


def test_an_error_of_the_listener_comes_out_and_ends_the_run(ran):
    def hear(event):
        raise LookupError("no such panel")

    session = Session(chain(tally(ran)), on_event=hear)
    session.given(plate=picture())
    with pytest.raises(LookupError):
        session.run()
    assert Session(chain(tally([]))).knobs()[0].name == "last"


# ---------------------------------------------------------------------- cancelling


@pytest.fixture
def held():
    """Return a session whose node ``two`` waits inside of a call that nobody can stop, and the events to steer it."""
    inside, go_on, ran = threading.Event(), threading.Event(), []

    def wait(context: Context, image, *, amount: float):
        ran.append(context.node)
        if context.node == "two" and amount > 0:
            inside.set()
            assert go_on.wait(60)
        return image

    session = Session(chain(node_of(wait)))
    session.given(plate=picture())
    yield session, inside, go_on, ran
    go_on.set()


def cancel_when(session, inside):
    """Cancel as soon as ``inside``; return the thread, whose ``when`` is the time."""

    def cancel():
        assert inside.wait(60)
        thread.when = time.perf_counter()
        session.cancel()

    thread = threading.Thread(target=cancel)
    thread.start()
    return thread


def test_a_run_ends_when_it_is_cancelled_though_its_work_goes_on(held):
    session, inside, go_on, ran = held
    thread = cancel_when(session, inside)
    with pytest.raises(Cancelled) as caught:
        session.run()
    assert time.perf_counter() - thread.when < 5  # the bench holds it to 50 ms
    assert caught.value.code == "cancelled"
    assert isinstance(caught.value, FlowabsError)
    go_on.set()
    session.set({"two.amount": -1})
    session.run()
    assert ran == [
        "one",
        "two",
        "two",
        "three",
    ]  # what was finished before is there; "three" of the first run never ran


def test_a_run_that_waits_for_its_turn_is_cancelled_too(held):
    session, inside, _go_on, ran = held
    thread = cancel_when(session, inside)
    with pytest.raises(Cancelled):
        session.run()
    thread.join()
    inside.clear()
    waiting = threading.Timer(0.1, session.cancel)
    waiting.start()
    with pytest.raises(Cancelled):  # the call of the first one still goes on
        session.run()
    waiting.join()
    assert ran == ["one", "two"]


def test_cancelling_nothing_is_no_harm(session):
    session.cancel()
    session.run()
    session.cancel()
    session.run()


def test_a_listener_may_cancel(ran):
    session = Session(chain(tally(ran)), on_event=lambda event: session.cancel())
    session.given(plate=picture())
    with pytest.raises(Cancelled):
        session.run()


def test_a_kernel_stops_between_two_bands():
    begun, first, before = [], threading.Event(), threading.active_count()

    def slow(context: Context, image, *, amount: float):
        def band(first_row, last_row):
            begun.append(first_row)
            first.set()
            time.sleep(0.02)

        bands.over_rows(band, 4000)
        return image

    for threads in (1, 2):
        begun.clear()
        first.clear()
        session = Session(chain(node_of(slow)), threads=threads)
        session.given(plate=picture())
        cancel_when(session, first)
        with pytest.raises(Cancelled):
            session.run()
        with session._cache._turn():  # until the work has ended
            assert len(begun) < 60 < 4000 / 32
    assert threading.active_count() - before < 10


def test_a_closed_session_holds_nothing_and_runs_nothing(held):
    session, inside, _go_on, _ran = held
    thread = threading.Thread(target=lambda: inside.wait(60) and session.close())
    thread.start()
    with pytest.raises(Cancelled):
        session.run()
    thread.join()
    with pytest.raises(CommandError, match="closed"):
        session.run()
    assert session.cached_bytes == 0


def test_runs_of_one_session_take_turns_and_sessions_do_not_mix(ran):
    at_once, most = [], []

    def count(context: Context, image, *, amount: float):
        at_once.append(1)
        most.append(len(at_once))
        time.sleep(0.002)
        at_once.pop()
        return image.with_pixels(image.pixels + np.float32(amount))

    session = Session(chain(node_of(count)), cache_bytes=0)
    session.given(plate=picture())
    with ThreadPoolExecutor(4) as pool:
        drawn = list(pool.map(lambda _: session.run()["three"].pixels, range(12)))
    assert max(most) == 1
    assert all(np.array_equal(each, drawn[0]) for each in drawn)

    def of(seed):
        with Session(chain(tally(ran))) as session:
            session.given(plate=picture(seed=seed))
            return session.run()["three"].pixels

    with ThreadPoolExecutor(4) as pool:
        for seed, pixels in enumerate(pool.map(of, range(12))):
            np.testing.assert_array_equal(pixels, of(seed))


def test_ctrl_c_ends_the_run(held):
    import _thread

    session, inside, _go_on, _ran = held
    threading.Thread(target=lambda: inside.wait(60) and _thread.interrupt_main()).start()
    with pytest.raises(KeyboardInterrupt):
        session.run()


# ---------------------------------------------------------------------- with the graphs that artists use


def test_knobs_turned_in_a_session_give_the_pixels_of_single_runs():
    rng = np.random.default_rng(5)
    rgb = np.repeat(np.repeat(rng.random((9, 12, 3), np.float32), 8, 0), 8, 1)
    session = fa.Session("abstraction", threads=2)
    session.given(plate=rgb)
    for changes in ({}, {"ink_opacity": 0.5}, {"line_width": 1.5}, {"levels": 6}, {"coherence": 2, "ink_opacity": 1}):
        session.set(changes)
        for scale in (1, 0.5):
            found = session.run(["comp", "lines"], scale=scale)
            expected = session.graph.run(given={"plate": rgb}, outputs=["comp", "lines"], scale=scale)
            for name in found:
                np.testing.assert_array_equal(found[name].pixels, expected[name].pixels)
