"""TIFF: sRGB in whole numbers, scene-linear in float; the header says whether alpha is straight."""

from __future__ import annotations

from flowabs_nodes.io.formats.declare import Format

TIFF = Format(
    name="TIFF",
    oiio_name="tiff",
    extensions=(".tif", ".tiff"),
    magic=(b"II*\x00", b"MM\x00*", b"II+\x00", b"MM\x00+"),  # little and big endian; the last two are BigTIFF
    display_referred=True,
    alpha="tagged",
    encoder="flowabs_nodes.io.encode_flat:encode_flat",
    data_types=("uint16", "uint8", "float"),
    compression="zip",
    stamps="description",
    storage=("tiff:",),
)
