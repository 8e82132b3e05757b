"""Make the texts of a header readable that are no UTF-8, such as an object's name in a Cryptomatte's manifest.

OpenImageIO 3.1 hands them out with surrogates, which neither it nor a log takes back: each such text is taken for
Latin-1, as programs for Windows wrote it.
"""

from __future__ import annotations

import re

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
        texts = [each for each in (value if isinstance(value, tuple) else (value,)) if isinstance(each, str)]
        if all(_is_readable(text) for text in (name, *texts)):
            continue
        # Only a pattern finds a name with surrogates.
        clean.erase_attribute(name if _is_readable(name) else re.sub(r"\W", ".", name, flags=re.ASCII))
        if isinstance(value, tuple) and texts:
            clean.attribute(_made_readable(name), attribute.type, tuple(_made_readable(text) for text in texts))
        else:
            clean.attribute(_made_readable(name), attribute.type, _made_readable(value) if texts else value)
    return clean


def _is_readable(text: str) -> bool:
    return text.isascii() or not any("\udc80" <= each <= "\udcff" for each in text)


def _made_readable(text: str) -> str:
    return text if _is_readable(text) else readable(text.encode("utf-8", "surrogateescape"))
