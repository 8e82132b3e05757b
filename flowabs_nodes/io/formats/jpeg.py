"""JPEG: sRGB, read only, since saving one changes its pixels."""

from __future__ import annotations

from flowabs_nodes.io.formats.declare import Format

JPEG = Format(
    name="JPEG",
    oiio_name="jpeg",
    extensions=(".jpg", ".jpeg"),
    magic=(b"\xff\xd8\xff",),
    display_referred=True,
    storage=("jpeg:",),
)
