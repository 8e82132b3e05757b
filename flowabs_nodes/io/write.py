"""Write frames safely: at the final name there is a whole frame or nothing.

A frame is claimed, encoded in memory, written to the temporary byte by byte, synced, read back pixel by pixel, renamed.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import nullcontext

from flowabs_nodes.errors import FlowabsError, WriteError
from flowabs_nodes.io import formats
from flowabs_nodes.io.claim import Claim, claim
from flowabs_nodes.io.formats import Encoder, Format
from flowabs_nodes.io.output_image import Picture, build_picture
from flowabs_nodes.io.provenance import GRAPH, KEY, SCALE, stored_key
from flowabs_nodes.io.settings import Settings, checked
from flowabs_nodes.io.verify import is_whole
from flowabs_nodes.io.write_failure import failure

__all__ = ["Picture", "build_picture", "is_whole", "save", "stored_key"]


def save(
    picture: Picture,
    path: str | os.PathLike[str],
    *,
    key: str = "",
    graph: str = "",
    scale: float | None = None,
    settings: Settings | None = None,
    claimed: Claim | None = None,
    warn: Callable[[str], None] = lambda text: None,
) -> None:
    """Write a picture in the format of the file's extension (:func:`flowabs_nodes.io.formats.to_write`).

    ``key``, ``graph`` (a document as JSON) and ``scale`` are stored in the file, and with a key a hash of its pixels
    (:mod:`flowabs_nodes.io.provenance`). An existing file is replaced in one step.
    ``claimed`` is a claim on the path that the caller already holds, and will release; without one, a claim is made for
    the time of writing. ``warn`` is told what the format cannot hold.

    Raises ClaimedError where somebody else is writing the file, CommandError for a path outside ``settings.root``,
    WriteError for all else. After an error no temporary is left, and ``path`` is as it was before.
    """
    settings = settings or picture.settings
    name = checked(path, settings)
    try:
        format = formats.to_write(name)
        with nullcontext(claimed) if claimed else claim(name, root=settings.root) as held:
            known = {KEY: key, GRAPH: graph, SCALE: "" if scale is None else repr(float(scale))}
            _write(picture, format, held, {stamp: text for stamp, text in known.items() if text}, warn)
    except FlowabsError as error:
        error.at(file=os.fspath(name))
        raise


def _write(
    picture: Picture, format: Format, claimed: Claim, stamps: dict[str, str], warn: Callable[[str], None]
) -> None:
    """Encode, write to the claimed temporary, verify and publish. Raises WriteError."""
    try:
        encode: Encoder = formats.load(format.encoder)
        data = encode(picture, format, stamps, warn)
        claimed.write(data)
        if not claimed.holds(data) or not is_whole(claimed.temporary, picture.settings, format):
            raise WriteError("what was written cannot be read back", code="not-whole")
        claimed.publish()
    except OSError as error:
        raise failure(error, claimed.final) from error
    except MemoryError as error:
        raise WriteError("not enough memory to encode the frame", code="no-memory") from error
