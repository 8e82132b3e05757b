"""Make OpenImageIO's complaints fit for a message to people."""

from __future__ import annotations

import re
from typing import Any


def reason(source: Any) -> str:
    """Return what OpenImageIO says went wrong, in one line; empty where nothing did. Clears the error.

    ``source`` is whatever has a ``geterror``: an ImageInput, an ImageOutput, or the module itself.
    """
    try:
        text = str(source.geterror())
    except UnicodeDecodeError:  # the message quotes a damaged header
        return "damaged header"
    first = printable(text.strip().split("\n")[0])[:300]
    return re.sub(r"^(EXR Error \(.*?\): (EXR_ERR_\w+ )?|OpenEXR exception: )", "damaged: ", first)


def printable(text: str) -> str:
    """Replace what is no printable character by "?": a hostile header must not move a terminal's cursor."""
    return "".join(sign if sign.isprintable() else "?" for sign in text)
