"""OpenEXR: scene-linear, premultiplied, any number of layers and parts. Written by the OpenEXR module."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from flowabs_nodes.io.formats.declare import Format

if TYPE_CHECKING:
    import OpenImageIO as oiio


def _reader(specs: Sequence[oiio.ImageSpec], problem: str) -> str:
    """Return who reads luminance and chroma: subsampled, OpenImageIO refuses it, or (3.0) opens but cannot read it."""
    chroma = len(specs) == 1 and {"Y", "RY", "BY"} <= set(specs[0].channelnames)
    return "flowabs_nodes.io.luminance_chroma:LuminanceChromaFile" if chroma or "ubsampled" in problem else ""


EXR = Format(
    name="EXR",
    article="an",
    oiio_name="openexr",
    extensions=(".exr",),
    magic=(b"\x76\x2f\x31\x01",),
    oriented=False,  # an "Orientation" there is only somebody's attribute
    integers="exact",
    reader=_reader,
    encoder="flowabs_nodes.io.encode_exr:encode_exr",
    data_types=("half", "float"),
    layers=True,
    hashed="stored",
    storage=("openexr:",),
)
