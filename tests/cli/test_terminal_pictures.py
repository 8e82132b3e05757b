from base64 import standard_b64decode

import pytest

from flowabs_nodes.cli.terminal_pictures import iterm2, kitty, protocol

PNG = bytes(range(256)) * 40


@pytest.mark.parametrize(
    ("environment", "expected"),
    [
        ({"TERM": "xterm-kitty"}, kitty),
        ({"TERM": "xterm-256color", "KITTY_WINDOW_ID": "1"}, kitty),
        ({"TERM": "xterm-ghostty"}, kitty),
        ({"TERM": "xterm-256color", "TERM_PROGRAM": "iTerm.app"}, iterm2),
        ({"TERM": "xterm-256color", "TERM_PROGRAM": "WezTerm"}, iterm2),
        ({"TERM": "xterm-256color", "LC_TERMINAL": "iTerm2"}, iterm2),  # over ssh
        ({"TERM": "xterm-256color"}, None),
        ({"TERM": "dumb", "KITTY_WINDOW_ID": "1"}, None),
        ({"TERM": "tmux-256color", "KITTY_WINDOW_ID": "1"}, None),
        ({"TERM": "xterm-kitty", "TMUX": "/tmp/tmux-0/default,1,0"}, None),
        ({}, None),
    ],
)
def test_which_terminals_can(environment, expected):
    assert protocol(environment) is expected


def test_kitty_takes_pieces_all_but_the_last_of_which_say_that_more_comes():
    *pieces, end = kitty(PNG).split("\033\\")
    assert end == "\n"
    heads, payloads = zip(*(piece.removeprefix("\033_G").split(";") for piece in pieces), strict=True)
    assert heads[0] == "a=T,f=100,q=2,m=1"
    assert set(heads[1:-1]) == {"m=1"}
    assert heads[-1] == "m=0"
    assert max(map(len, payloads)) <= 4096
    assert standard_b64decode("".join(payloads)) == PNG


def test_a_picture_of_one_piece():
    assert kitty(b"abc") == "\033_Ga=T,f=100,q=2,m=0;YWJj\033\\\n"


def test_iterm2_takes_it_in_one():
    head, _, data = iterm2(PNG).partition(":")
    assert head == f"\033]1337;File=inline=1;size={len(PNG)};preserveAspectRatio=1"
    assert data.endswith("\a\n")
    assert standard_b64decode(data[:-2]) == PNG
