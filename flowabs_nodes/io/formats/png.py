"""PNG: sRGB unless it says otherwise, straight alpha, 8 or 16 bits."""

from __future__ import annotations

from flowabs_nodes.io.formats.declare import Format

PNG = Format(
    name="PNG",
    oiio_name="png",
    extensions=(".png",),
    magic=(b"\x89PNG",),
    display_referred=True,
    alpha="straight",
    encoder="flowabs_nodes.io.encode_flat:encode_flat",
    data_types=("uint8", "uint16"),
    storage=("png:",),
)
