"""Read which files an OCIO config refers to, and hash what they hold with the config: its content.

OpenColorIO keeps every look-up table that it has read, by path, as long as the process lives, and whether a path was
there. A config whose tables were edited meanwhile is therefore handed to it under another path, as a copy that finds
the same folders through links.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import tempfile
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, lru_cache

from flowabs_nodes import forks
from flowabs_nodes.errors import ColorError
from flowabs_nodes.file_hash import file_hash, file_version

#: A text: quoted, or plain up to the end of its line.
_SCALAR = r"""(?:"([^"\n]*)"|'([^'\n]*)'|([^\s"'\[{#][^\n]*))"""
_SOURCE = re.compile(r"\bsrc:[ \t]*" + _SCALAR)
_SEARCH = re.compile(r"^search_path:[ \t]*(\[[^\]]*\]|[^\n]*)\n?((?:[ \t]*-[^\n]*\n?)*)", re.MULTILINE)
_ENVIRONMENT = re.compile(r"^environment:(.*\n(?:[ \t]+.*\n|\n)*)", re.MULTILINE)
_VARIABLE = re.compile(r"\$\{?([A-Za-z_]\w*)\}?|%([A-Za-z_]\w*)%")

#: A cache: where a table may lie -> the hash of what was there when this process first asked; "" for nothing.
_first_seen: dict[str, str] = {}
_lock = threading.Lock()
forks.take_before(_lock)


@dataclass(frozen=True)
class _Text:
    """What a config's text says of other files."""

    text: str
    folders: tuple[str, ...]  # of the search path, as they are written
    sources: tuple[tuple[str, ...], ...]  # of each "src": the ways in which it can be read, the likeliest first
    variables: frozenset[str]  # that are used for other things than files
    defaults: tuple[tuple[str, str], ...]  # of variables that the environment does not set


def edition(path: str) -> tuple[str, str]:
    """Return the content of a config file and the path under which OpenColorIO reads it as it stands now.

    The content is a hash of the bytes of the config and of every file that it names by ``src`` and finds in its search
    path, and of the environment's variables that it uses; where all these lie does not matter. Raises OSError where the
    config cannot be read, ColorError where OpenColorIO would go on using what a file held before.
    """
    digest = file_hash(path)
    if not _is_text(path):  # an .ocioz holds its tables itself
        return digest, path
    parsed = _read(path, *file_version(path))
    values = dict(parsed.defaults) | dict(os.environ)
    here = os.path.dirname(os.path.abspath(path))
    folders = [os.path.join(here, _expanded(folder, values)) for folder in parsed.folders] or [here]
    found: list[str] = []
    seen: dict[str, str] = {}
    for readings in parsed.sources:
        names = [_expanded(name, values) for name in readings]
        places = {os.path.join(folder, name): name for name in names for folder in folders}
        held = {place: _hash_of(place) for place in places}
        seen |= held
        found.append(next(filter(None, held.values()), names[0]))
    variables = {name: values.get(name, "") for name in sorted(parsed.variables)}
    whole = json.dumps([digest, found, variables], sort_keys=True).encode()
    content = hashlib.blake2b(whole, digest_size=20).hexdigest()
    with _lock:
        changed = [place for place, held in seen.items() if _first_seen.setdefault(place, held) != held]
        if not changed:
            return content, path
        absolute = [names[0] for names in parsed.sources if os.path.isabs(_expanded(names[0], values))]
        return content, _copy(path, parsed, folders, content, changed[0], absolute)


def display_names(path: str) -> frozenset[str]:
    """Return the names of the display-referred colour spaces of a config file."""
    section = re.search(r"^display_colorspaces:.*\n((?:[ \t-].*\n?|\n|#.*\n)*)", _read_text(path), re.MULTILINE)
    names = re.findall(r"\bname:[ \t]*" + _SCALAR, section[1]) if section else []
    return frozenset(reading for each in names for reading in _readings(each))


def said_of_spaces(path: str, key: str) -> dict[str, str]:
    """Return what a config file says of its colour spaces by a key, such as "encoding" or "isdata", by their names."""
    found: dict[str, str] = {}
    for space in _read_text(path).split("!<ColorSpace>")[1:]:
        name, said = (re.search(rf"\b{each}:[ \t]*" + _SCALAR, space) for each in ("name", key))
        if name and said:
            found |= dict.fromkeys(_readings(name.groups("")), _readings(said.groups(""))[0])
    return found


def is_archive(path: str) -> bool:
    """Return whether a config is an archive, .ocioz, that holds its tables itself."""
    return os.path.isfile(path) and not _is_text(path)


def _is_text(path: str) -> bool:
    """Return whether a file is a config as text; an .ocioz is a ZIP archive."""
    with open(path, "rb") as file:
        return file.read(4) != b"PK\x03\x04"


def _read_text(path: str) -> str:
    """Return the text of a config; none of an archive."""
    if not os.path.isfile(path) or not _is_text(path):
        return ""
    with open(path, encoding="utf-8", errors="replace") as file:
        return file.read()


@lru_cache(maxsize=32)
def _read(path: str, real_path: str, size: int, time: int) -> _Text:
    """Parse a config; the arguments after ``path`` are its version."""
    text = _read_text(path)
    search = _SEARCH.search(text)
    folders = _folders(search[1], search[2]) if search else ()
    section = _ENVIRONMENT.search(text)
    pairs = re.findall(r"([A-Za-z_]\w*):[ \t]*" + _SCALAR, section[1]) if section else []
    elsewhere = _SEARCH.sub("", _SOURCE.sub("", text))
    return _Text(
        text,
        folders,
        tuple(_readings(each) for each in _SOURCE.findall(text)),
        frozenset(a or b for a, b in _VARIABLE.findall(elsewhere)),
        tuple((name, _readings(each)[-1]) for name, *each in pairs),
    )


def _readings(scalar: tuple[str, ...] | list[str]) -> tuple[str, ...]:
    """Return the ways to read a match of ``_SCALAR``: a plain text ends at "," or "}" if it stands in braces."""
    double, single, plain = scalar
    if not plain:
        return (double or single,)
    line = re.split(r"\s#", plain)[0].strip()
    short = re.split(r"[,}\]]", line)[0].strip()
    return (short,) if short == line else (short, line)


def _folders(value: str, items: str) -> tuple[str, ...]:
    """Return the folders of a search path: a text with colons, a list in brackets, or a list of lines."""
    if value.startswith("["):
        entries = value.strip("[]").split(",")
    else:
        entries = [value, *(line.strip().removeprefix("-") for line in items.splitlines())]
    texts = [re.split(r"\s#", entry)[0].strip().strip("\"'") for entry in entries]
    return tuple(folder for text in texts for folder in text.split(":") if folder)


def _expanded(text: str, values: dict[str, str]) -> str:
    """Return a text with the variables in it replaced; those without a value stay."""
    return _VARIABLE.sub(lambda match: values.get(match[1] or match[2], match[0]), text)


def _hash_of(place: str) -> str:
    """Return the hash of a file, "" where there is none."""
    try:
        return file_hash(place) if os.path.isfile(place) else ""
    except (OSError, ValueError):
        return ""


@cache
def _copies() -> tempfile.TemporaryDirectory[str]:
    """Make the folder that copies of configs are kept in as long as the process lives."""
    return tempfile.TemporaryDirectory(prefix="flowabs-ocio-")


def _copy(path: str, parsed: _Text, folders: list[str], content: str, changed: str, absolute: list[str]) -> str:
    """Make a copy of a config, in a folder called as its content, that finds its tables through links beside it."""
    copy = os.path.join(_copies().name, content, os.path.basename(path))
    if os.path.exists(copy):
        return copy
    try:
        if changed in absolute:
            raise OSError("its path is absolute")
        for link, folder in _links(folders):
            os.makedirs(os.path.dirname(copy), exist_ok=True)
            os.symlink(folder, os.path.join(os.path.dirname(copy), link), target_is_directory=True)
        with open(copy, "w", encoding="utf-8") as file:
            search = ":".join(link for link, _ in _links(folders))
            file.write(f"{_SEARCH.sub('', parsed.text).rstrip()}\nsearch_path: {search}\n")
    except OSError as error:
        raise ColorError(
            f"{changed}, of the OCIO config {path!r}, has changed since this process first read it, "
            "and OpenColorIO keeps what it has read",
            code="bad-ocio-config",
            hint="begin a new process",
        ) from error
    return copy


def _links(folders: list[str]) -> Iterator[tuple[str, str]]:
    """Yield the name of a link for each folder, and the folder."""
    for index, folder in enumerate(folders):
        yield f"folder{index}", folder
