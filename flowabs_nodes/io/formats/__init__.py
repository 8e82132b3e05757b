"""Know the file formats: every module of this folder that declares a :class:`Format` adds one.

A format is found by a file name's extension, or by the file's first bytes.
"""

from __future__ import annotations

import importlib
import os
import pkgutil
import stat
from collections.abc import Iterable

from flowabs_nodes.errors import ReadError, WriteError
from flowabs_nodes.io.formats.declare import Declared, Encoder, Format, load

__all__ = [
    "ALL",
    "DISPLAY_REFERRED",
    "WRITABLE",
    "Declared",
    "Encoder",
    "Format",
    "by_content",
    "by_extension",
    "check_extension",
    "check_kind",
    "found_in",
    "listed",
    "load",
    "to_read",
    "to_write",
]


def _declared_here() -> tuple[Format, ...]:
    """Import every module of this folder and return the formats that they declare, by name."""
    modules = [importlib.import_module(f"{__name__}.{module.name}") for module in pkgutil.iter_modules(__path__)]
    found = {value for module in modules for value in vars(module).values() if isinstance(value, Format)}
    return tuple(sorted(found, key=lambda format: format.name))


#: Every format, by name.
ALL: tuple[Format, ...] = _declared_here()
WRITABLE = tuple(format for format in ALL if format.writable)
DISPLAY_REFERRED = tuple(format for format in ALL if format.display_referred)


def by_extension(path: str | os.PathLike[str]) -> Format | None:
    """Return the format that the extension of a file name stands for, in capitals too; None where none does."""
    extension = os.path.splitext(os.fspath(path))[1].lower()
    return next((format for format in ALL if extension in format.extensions), None)


def by_content(start: bytes) -> Format | None:
    """Return the format of a file that starts with these bytes; None where no format's files do."""
    return next((format for format in ALL if start.startswith(format.magic)), None)


def found_in(path: str | os.PathLike[str]) -> Format | None:
    """Return the format that a file's first bytes are of; None where there are none, or of no known format."""
    try:
        with open(path, "rb") as file:
            return by_content(file.read(16))
    except (OSError, ValueError):
        return None


def to_read(path: str | os.PathLike[str], place: str = "") -> Format:
    """Return the format of an existing file, whose first bytes must be what its name says. Raises ReadError.

    ``place`` is another path by which it is opened.
    """
    name = os.fspath(path)
    place = place or name
    check_kind(place)
    expected = check_extension(name)
    try:
        with open(place, "rb") as file:
            start = file.read(16)
    except FileNotFoundError:
        raise ReadError("no such file", code="missing-file", file=name) from None
    except (OSError, ValueError) as error:
        raise ReadError(f"cannot be read: {getattr(error, 'strerror', None) or error}", file=name) from error
    if not start:
        raise ReadError("the file is empty (zero bytes)", file=name)
    found = by_content(start)
    if found is not expected:
        what = f"it is {found.article} {found.name} file" if found else "it does not begin as one does"
        raise ReadError(f"not {expected.article} {expected.name} file: {what}", code="bad-format", file=name)
    expected.look(place)
    return expected


def check_extension(path: str | os.PathLike[str]) -> Format:
    """Return the format that the name of a file to read says. Raises ReadError where it says none."""
    found = by_extension(path)
    if found is None:
        raise ReadError(
            f"not a picture format that is read here; these are {_extensions(ALL)}",
            code="bad-format",
            file=os.fspath(path),
        )
    return found


def check_kind(path: str | os.PathLike[str]) -> None:
    """Raise ReadError for what is there but is no file: a folder, a device, a pipe, which might never end."""
    name = os.fspath(path)
    try:
        mode = os.stat(name).st_mode
    except (OSError, ValueError):
        return  # opening it tells why
    if not stat.S_ISREG(mode):
        kinds = ((stat.S_ISDIR, "a folder"), (stat.S_ISFIFO, "a pipe"), (stat.S_ISSOCK, "a socket"))
        what = next((what for is_kind, what in kinds if is_kind(mode)), "a device")
        raise ReadError(f"cannot be read: it is {what}, not a file", code="not-a-file", file=name)


def to_write(path: str | os.PathLike[str]) -> Format:
    """Return the format that a picture of this name is written in. Raises WriteError where there is none."""
    found = by_extension(path)
    if found is None or not found.writable:
        what = f"{found.name} is read only" if found else "not a picture format that is written here"
        raise WriteError(f"{what}; use {_extensions(WRITABLE)}", code="bad-format", file=os.fspath(path))
    return found


def listed(formats: Iterable[Format], last: str = " or ") -> str:
    """Return the names of formats as a list for people, ``last`` before the last one: "EXR, PNG or TIFF"."""
    return _joined([format.name for format in formats], last)


def _extensions(formats: Iterable[Format]) -> str:
    """Return the extensions of formats as a list for people: "exr, png, tif or tiff"."""
    return _joined([extension[1:] for format in formats for extension in format.extensions])


def _joined(names: list[str], last: str = " or ") -> str:
    """Join names with commas, and ``last`` before the last one."""
    return last.join([*([", ".join(names[:-1])] if names[:-1] else []), *names[-1:]])
