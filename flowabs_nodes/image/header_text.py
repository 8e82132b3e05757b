"""Make the texts of a header readable that are no UTF-8, such as an object's name in a Cryptomatte's manifest.

OpenImageIO, from 3.1 on, hands them out with surrogates, which neither it nor a log takes back: each such text is taken
for Latin-1, as programs for Windows wrote it.
"""

from __future__ import annotations

import re
from typing import Any

import OpenImageIO as oiio


def readable(data: bytes) -> str:
    """Return a text; one that is no UTF-8 is taken for Latin-1."""
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def with_readable_texts(spec: oiio.ImageSpec) -> oiio.ImageSpec:
    """Return a copy of a header whose attributes' names and values are readable; names of channels stay."""
    clean = oiio.ImageSpec(spec)
    for attribute in spec.extra_attribs:
        try:
            name, value = attribute.name, attribute.value
        except UnicodeDecodeError:  # OpenImageIO 3.0, where such a text cannot be asked for
            continue
        made = _made_readable(name), _with_readable(value)
        if made == (name, value):
            continue
        if made[0] != name:  # only a pattern finds a name with surrogates
            clean.erase_attribute(re.sub(r"\W", ".", name, flags=re.ASCII))
        clean.attribute(made[0], attribute.type, made[1])
    return clean


def _with_readable(value: Any) -> Any:
    """Return the value of an attribute, its texts readable; any other as it is."""
    if isinstance(value, tuple):
        return tuple(_with_readable(each) for each in value)
    return _made_readable(value) if isinstance(value, str) else value


def _made_readable(text: str) -> str:
    """Return a text of OpenImageIO's, the bytes that stand in it as surrogates taken for Latin-1."""
    if text.isascii() or not any("\udc80" <= each <= "\udcff" for each in text):
        return text
    return readable(text.encode("utf-8", "surrogateescape"))
