"""``flowabs run --view``: to a file, to a terminal, and what goes wrong."""

import json
import sys

import pytest

from tests.cli.test_run import run, shot  # noqa: F401 - fixtures

KITTY = {"TERM": "xterm-kitty"}


@pytest.fixture
def terminal(monkeypatch):
    """Return a function that says which terminal stdout is."""

    def on(**environment):
        monkeypatch.setattr(type(sys.stdout), "isatty", lambda stream: True, raising=False)
        for name in ("TMUX", "TERM_PROGRAM", "KITTY_WINDOW_ID", "LC_TERMINAL"):
            monkeypatch.delenv(name, raising=False)
        for name, value in environment.items():
            monkeypatch.setenv(name, value)

    return on


def test_a_picture_of_a_node_and_nothing_else_is_written(run, shot):  # noqa: F811
    before = {path.name for path in shot.iterdir()}
    code, out, err = run("-i", "in.####.exr", "--view", "brighter", "-o", "look.png")
    assert (code, err) == (0, "")
    assert "frame 1001  brighter: colour through the view 'ACES 1.0 - SDR Video'" in out
    assert out.splitlines()[-1].startswith("frame 1001  brighter.image")
    assert out.splitlines()[-1].endswith("look.png")
    assert {path.name for path in shot.iterdir()} - before == {"look.png"}


def test_json_has_an_event_a_line(run, shot):  # noqa: F811
    code, out, _ = run("-i", "in.1002.exr", "--view", "plate", "-o", "look.png", "--json")
    events = [json.loads(line) for line in out.splitlines()]
    assert code == 0
    assert {event["event"] for event in events[:-1]} == {"note"}
    assert events[-1].items() >= {"event": "view", "output": "plate.image", "file": "look.png"}.items()
    code, out, err = run("-i", "in.1002.exr", "--view", "plat", "-o", "look.png", "--json")
    assert code == 2
    assert json.loads(out)["error"]["hint"] == "did you mean 'plate'?"
    assert "did you mean 'plate'?" in err


def test_a_terminal_that_can_shows_it(run, shot, terminal):  # noqa: F811
    terminal(**KITTY)
    code, out, _ = run("-i", "in.1001.exr", "--view", "plate")
    assert code == 0
    assert "\033_Ga=T,f=100," in out
    assert not list(shot.glob("*.png"))


@pytest.mark.parametrize("extra", [(), ("--json",)])
def test_where_nothing_can_show_it_a_file_is_asked_for(run, extra):  # noqa: F811
    code, _, err = run("-i", "in.1001.exr", "--view", "plate", *extra)
    assert code == 2
    assert "-o view.png names a file for it" in err


def test_a_terminal_that_cannot(run, terminal):  # noqa: F811
    terminal(TERM="xterm")
    assert run("-i", "in.1001.exr", "--view", "plate")[0] == 2


def test_a_profile_is_of_a_whole_run(run):  # noqa: F811
    code, _, err = run("-i", "in.1001.exr", "--view", "plate", "-o", "look.png", "--profile")
    assert code == 2
    assert "are of a whole run" in err


def test_one_picture_goes_to_no_scheduler(run):  # noqa: F811
    code, _, err = run("-i", "in.1001.exr", "--view", "plate", "-o", "look.png", "--scheduler", "local")
    assert code == 2
    assert "does not go with --scheduler" in err
