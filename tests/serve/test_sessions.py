"""Sessions of clients: in turn, of a graph whose file may change, and let go when there are too many."""

import gc
import threading
import weakref

import pytest

from flowabs_nodes.errors import Cancelled, FlowabsError
from flowabs_nodes.image import Image
from flowabs_nodes.io.settings import Settings
from flowabs_nodes.serve.sessions import Sessions
from flowabs_nodes.stopping import StopFlag, Stopped, stopped_by
from tests.serve.wire import PATIENCE, graph_file, plate, slow_plate


def held_by(sessions):
    return list(sessions._held)


def use(sessions, name, graph, values=None, image=None):
    """Render with a session, and return the picture."""
    image = Image.from_array(plate()) if image is None else image
    with sessions.using(name) as held, held.turn(StopFlag(), lambda event: None), sessions.at_work():
        session = held.ready(graph, values or {})
        held.give(session, {"plate": image})
        return session.run("bright")["bright"].pixels[0, 0, 0] / image.pixels[0, 0, 0]


@pytest.fixture
def sessions():
    return Sessions(3, 10**9, None, Settings())


def test_each_render_stands_at_its_own_values_alone(sessions, graph):
    assert use(sessions, (1, "a"), graph, {"stops": 3}) == 8
    assert use(sessions, (1, "a"), graph) == 2
    with pytest.raises(FlowabsError):
        use(sessions, (1, "a"), graph, {"stops": 99})
    assert use(sessions, (1, "a"), graph) == 2
    assert use(sessions, (1, "a"), graph, {"stops": 3}) == 8


def test_a_graph_is_loaded_anew_when_its_file_changes_and_is_missed_when_it_is_gone(sessions, tmp_path):
    inputs = {"image": "plate"}
    graph = graph_file(tmp_path)
    assert use(sessions, (1, "a"), graph) == 2
    graph_file(tmp_path, type="exposure@1", inputs=inputs, params={"stops": 2})
    assert use(sessions, (1, "a"), graph) == 4
    (tmp_path / "bright.json").write_text("{")
    with pytest.raises(FlowabsError, match=r"bright.json"):
        use(sessions, (1, "a"), graph)
    (tmp_path / "bright.json").unlink()
    with pytest.raises(FlowabsError, match="cannot read the graph: No such file"):
        use(sessions, (1, "a"), graph)
    graph_file(tmp_path, type="exposure@1", inputs=inputs, params={"stops": 3})
    assert use(sessions, (1, "a"), graph) == 8


def test_the_session_unused_longest_is_let_go(sessions, graph):
    for name in ("a", "b", "c", "a", "d"):
        use(sessions, (1, name), graph)
    assert held_by(sessions) == [(1, "c"), (1, "a"), (1, "d")]


def test_results_and_pictures_of_all_stay_within_their_bytes(graph):
    one = 2 * 12 * 20 * 4 * 4
    sessions = Sessions(99, int(2.5 * one), None, Settings())
    for number in range(5):
        use(sessions, (1, str(number)), graph)
        assert sum(held.bytes for held in sessions._held.values()) <= 2.5 * one
    assert held_by(sessions) == [(1, "3"), (1, "4")]


def test_a_client_that_leaves_takes_its_sessions_with_it(sessions, graph):
    for name in ((1, "a"), (2, "a"), (1, "b")):
        use(sessions, name, graph)
    sessions.forget(1, "b")
    assert held_by(sessions) == [(1, "a"), (2, "a")]
    sessions.forget(1)
    assert held_by(sessions) == [(2, "a")]


def test_sessions_in_use_are_not_let_go(sessions, graph):
    with sessions.using((1, "a")), sessions.using((1, "b")), sessions.using((1, "c")):
        for name in ("d", "e"):
            use(sessions, (1, name), graph)
        assert {(1, "a"), (1, "b"), (1, "c")} <= set(held_by(sessions))
    assert len(held_by(sessions)) == 3


@pytest.fixture
def no_collector():
    """Switch the collector of garbage off: what is still there then is held by somebody, or by itself."""
    gc.collect()
    gc.disable()
    yield
    gc.enable()


@pytest.mark.parametrize("values", [{}, {"stops": 3}])
def test_what_is_let_go_is_freed_at_once(sessions, graph, no_collector, values):
    images = [Image.from_array(plate(seed=seed)) for seed in range(3)]
    refs = [weakref.ref(image) for image in images]
    while images:
        use(sessions, (1, "a"), graph, values, images.pop())
    assert [ref() is not None for ref in refs] == [True, False, False]  # the one given last
    sessions.forget(1)
    assert refs[0]() is None


def test_a_render_that_was_stopped_holds_nothing(sessions, slow, no_collector):
    image, flag = Image.from_array(slow_plate()), StopFlag()
    ref = weakref.ref(image)
    timer = threading.Timer(1, flag.set)
    timer.start()
    with stopped_by(flag), pytest.raises(Stopped):
        use(sessions, (1, "a"), slow, {}, image)
    timer.join(PATIENCE)
    del image
    sessions.forget(1)
    assert ref() is None


def test_who_waits_for_a_turn_can_be_stopped(sessions):
    flag = StopFlag()
    with sessions.using((1, "a")) as held, held.turn(StopFlag(), lambda event: None):
        timer = threading.Timer(0.1, flag.set)
        timer.start()
        with stopped_by(flag), pytest.raises(Stopped), held.turn(flag, lambda event: None):
            pass
        timer.join(PATIENCE)


def test_a_session_that_was_forgotten_while_somebody_waited_renders_no_more(sessions, graph):
    with sessions.using((1, "a")) as held, held.turn(StopFlag(), lambda event: None):
        sessions.forget(1, "a")
        with pytest.raises(Cancelled):
            held.ready(graph, {})


def test_pictures_that_are_no_longer_given_are_taken_away(sessions, graph):
    image = Image.from_array(plate())
    with sessions.using((1, "a")) as held, held.turn(StopFlag(), lambda event: None):
        session = held.ready(graph, {})
        held.give(session, {"plate": image, "bright": image})
        assert session.run("bright")["bright"].pixels is image.pixels
        held.give(session, {"plate": image})
        assert session.run("bright")["bright"].pixels[0, 0, 0] == image.pixels[0, 0, 0] * 2
