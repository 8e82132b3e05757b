"""What OpenImageIO complains of becomes one line that is safe on a terminal."""

from __future__ import annotations

import pytest

from flowabs_nodes.io.oiio_error import printable, reason


class Complaining:
    """Has a message, as an ImageInput has."""

    def __init__(self, message: str | UnicodeDecodeError) -> None:
        self.message = message

    def geterror(self) -> str:
        if isinstance(self.message, UnicodeDecodeError):
            raise self.message
        return self.message


@pytest.mark.parametrize(
    ("message", "expected"),
    [
        ("", ""),
        ("no such thing\nand more", "no such thing"),
        ("EXR Error (a.exr): EXR_ERR_CORRUPT_CHUNK bad", "damaged: bad"),
        ("OpenEXR exception: bad", "damaged: bad"),
        ("a\x1b[2Jb", "a?[2Jb"),
        ("x" * 1000, "x" * 300),
        (UnicodeDecodeError("utf-8", b"\xff", 0, 1, "no"), "damaged header"),
    ],
)
def test_reason(message: str | UnicodeDecodeError, expected: str) -> None:
    assert reason(Complaining(message)) == expected


def test_printable() -> None:
    assert printable("é #\r\0\u202e") == "é #???"
