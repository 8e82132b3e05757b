"""Decode some channels of an EXR of one part in one go, each as it is stored."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import OpenEXR
import OpenImageIO as oiio

from flowabs_nodes.io.formats.declare import Planes

_DTYPES = {"half": np.float16, "float": np.float32, "uint": np.uint32}


def decode_exr(place: str, spec: oiio.ImageSpec, names: Sequence[str]) -> Planes:
    """Return the planes of channels; none where that cannot be: of tiles, of a file that is damaged or changed.

    OpenEXR's own reader takes two fifths of OpenImageIO's time. It cannot say as well what is wrong with a file: who
    gets nothing asks OpenImageIO, which has also looked at the header before.
    """
    if spec.tile_width or spec.deep:
        return {}
    try:
        pixels = OpenEXR.InputFile(place).channels(list(names))
    except (OSError, TypeError, ValueError, RuntimeError):
        return {}
    planes = {}
    for name, plane in zip(names, pixels, strict=True):
        dtype = np.dtype(_DTYPES[str(spec.channelformat(spec.channelnames.index(name)))])
        if len(plane) != spec.height * spec.width * dtype.itemsize:
            return {}
        planes[name] = np.frombuffer(plane, dtype).reshape(spec.height, spec.width)
    return planes
