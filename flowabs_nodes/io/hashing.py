"""Hash the content of files: a part of every key, so that a plate that changed is filtered again."""

from __future__ import annotations

import os

from flowabs_nodes.errors import ReadError
from flowabs_nodes.file_hash import file_hash
from flowabs_nodes.io import formats


def content_hash(path: str | os.PathLike[str]) -> str:
    """Return the hash of a file's bytes (:func:`~flowabs_nodes.file_hash.file_hash`).

    Raises ReadError where the file cannot be read. What is no file (a folder, a pipe, a device) is refused at once.
    """
    formats.check_kind(path)
    try:
        return file_hash(path)
    except FileNotFoundError:
        raise ReadError("no such file", code="missing-file", file=os.fspath(path)) from None
    except (OSError, ValueError) as error:
        raise ReadError(f"cannot be read: {error}", file=os.fspath(path)) from error
