"""``flowabs serve``: its options; tests/serve starts it."""

import sys

import pytest


def test_help_says_who_talks_to_it(flowabs):
    code, out, _ = flowabs("serve", "--help")
    assert code == 0
    for words in (
        "--socket PATH",
        "--port N",
        "--cache SIZE",
        "--sessions N",
        "--threads N",
        "--max-pixels N",
        "--ocio",
    ):
        assert words in out
    assert "--frames" not in out


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--socket", "s", "--port", "0"], "give one of them"),
        (["--port", "70000"], "70000"),
        (["--port", "0", "--cache", "much"], "cache: expected a size"),
        (["--port", "0", "--sessions", "0"], "sessions"),
        (["--port", "0", "--threads", "0"], "threads"),
        (["--port", "0", "--ocio", "none.ocio"], "none.ocio"),
        (["--port", "0", "--port", "1"], "is given 2 times"),
        (["abstraction"], "unexpected extra argument"),
    ],
)
def test_wrong_options_are_told_before_anything_is_served(flowabs, arguments, said):
    code, out, errors = flowabs("serve", *arguments)
    assert (code, out) == (2, "")
    assert said in errors


def test_on_a_terminal_it_says_how_to_be_used(flowabs, monkeypatch):
    monkeypatch.setattr(sys.stdin, "isatty", lambda: True, raising=False)
    code, _, errors = flowabs("serve")
    assert code == 2
    assert "a host talks to it over pipes" in errors
