"""Which file formats there are: by a name's extension, and by a file's first bytes."""

from __future__ import annotations

import os

from flowabs_nodes.errors import ReadError, WriteError

#: Extension -> format, in OpenImageIO's words.
EXTENSIONS = {
    ".exr": "openexr",
    ".png": "png",
    ".jpg": "jpeg",
    ".jpeg": "jpeg",
    ".tif": "tiff",
    ".tiff": "tiff",
}
WRITABLE = ("openexr", "png", "tiff")
#: Format -> how people call it.
NAMES = {"openexr": "EXR", "png": "PNG", "jpeg": "JPEG", "tiff": "TIFF"}

_MAGIC = {
    b"\x76\x2f\x31\x01": "openexr",
    b"\x89PNG": "png",
    b"\xff\xd8\xff": "jpeg",
    b"II*\x00": "tiff",
    b"MM\x00*": "tiff",
    b"II+\x00": "tiff",
    b"MM\x00+": "tiff",
}


def by_name(path: str | os.PathLike[str]) -> str | None:
    """The format that the extension stands for, or None."""
    return EXTENSIONS.get(os.path.splitext(os.fspath(path))[1].lower())


def to_read(path: str | os.PathLike[str]) -> str:
    """The format of an existing file; its first bytes must be what its name says. Raises ReadError."""
    name = os.fspath(path)
    expected = by_name(name)
    if os.path.isdir(name):
        raise ReadError("is a folder, not a picture", file=name)
    if expected is None:
        raise ReadError(
            f"not a picture format that is read here; these are {_known(EXTENSIONS)}", code="bad-format", file=name
        )
    try:
        with open(name, "rb") as file:
            start = file.read(16)
    except FileNotFoundError:
        raise ReadError("no such file", code="missing-file", file=name) from None
    except (OSError, ValueError) as error:
        raise ReadError(f"cannot be read: {getattr(error, 'strerror', None) or error}", file=name) from error
    if not start:
        raise ReadError("the file is empty (zero bytes)", file=name)
    found = next((kind for magic, kind in _MAGIC.items() if start.startswith(magic)), None)
    if found != expected:
        what = f"it is {_a(found)} file" if found else "it does not begin as one does"
        raise ReadError(f"not {_a(expected)} file: {what}", code="bad-format", file=name)
    return expected


def to_write(path: str | os.PathLike[str]) -> str:
    """The format that a picture of this name is written in. Raises WriteError where there is none."""
    found = by_name(path)
    if found not in WRITABLE:
        names = {extension: kind for extension, kind in EXTENSIONS.items() if kind in WRITABLE}
        what = f"{NAMES[found]} is read only" if found else "not a picture format that is written here"
        raise WriteError(f"{what}; use {_known(names)}", code="bad-format", file=os.fspath(path))
    return found


def _a(kind: str) -> str:
    return f"{'an' if kind == 'openexr' else 'a'} {NAMES[kind]}"


def _known(extensions: dict[str, str]) -> str:
    *most, last = (extension[1:] for extension in extensions)
    return f"{', '.join(most)} or {last}"
