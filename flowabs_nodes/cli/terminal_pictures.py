"""Shows pictures on terminals that can: by kitty's graphics protocol, or iTerm2's inline images.

Both take a PNG as base64 in an escape sequence: https://sw.kovidgoyal.net/kitty/graphics-protocol/ and
https://iterm2.com/documentation-images.html. Which of them a terminal knows is seen by the environment: asking the
terminal itself would have to wait for an answer that most never give.
"""

from __future__ import annotations

from base64 import standard_b64encode
from collections.abc import Callable, Mapping

#: Kitty's payload comes in pieces of at most so many bytes.
_PIECE = 4096

_KITTY_TERMS = ("xterm-kitty", "xterm-ghostty")
_KITTY_PROGRAMS = ("ghostty",)
_ITERM_PROGRAMS = ("iTerm.app", "WezTerm", "mintty", "rio")


def protocol(environment: Mapping[str, str]) -> Callable[[bytes], str] | None:
    """Return the function that makes an escape sequence of a PNG's bytes; None where the terminal shows no pictures.

    Inside tmux and screen, which keep such sequences to themselves, it is None too.
    """
    term, program = environment.get("TERM", ""), environment.get("TERM_PROGRAM", "")
    if "TMUX" in environment or term.startswith(("screen", "tmux", "dumb")):
        return None
    if "KITTY_WINDOW_ID" in environment or term in _KITTY_TERMS or program in _KITTY_PROGRAMS:
        return kitty
    if program in _ITERM_PROGRAMS or environment.get("LC_TERMINAL") == "iTerm2":
        return iterm2
    return None


def kitty(png: bytes) -> str:
    """Return the sequences that transmit a PNG and show it (a=T, f=100) at the cursor, and keep the terminal quiet."""
    data = standard_b64encode(png).decode("ascii")
    pieces = [data[i : i + _PIECE] for i in range(0, len(data), _PIECE)] or [""]
    heads = ["a=T,f=100,q=2,", *[""] * (len(pieces) - 1)]
    more = [*[1] * (len(pieces) - 1), 0]
    sequences = (f"\033_G{head}m={m};{piece}\033\\" for head, m, piece in zip(heads, more, pieces, strict=True))
    return "".join(sequences) + "\n"


def iterm2(png: bytes) -> str:
    """Return the sequence that shows a PNG at the cursor, in its own size."""
    data = standard_b64encode(png).decode("ascii")
    return f"\033]1337;File=inline=1;size={len(png)};preserveAspectRatio=1:{data}\a\n"
