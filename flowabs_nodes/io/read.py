"""Read plates and AOVs: from a file to the Image that travels through a graph."""

from __future__ import annotations

import os
from collections.abc import Callable

import numpy as np
import OpenImageIO as oiio

from flowabs_nodes import color
from flowabs_nodes.array_types import Array
from flowabs_nodes.color import ocio
from flowabs_nodes.color.detection import forget
from flowabs_nodes.errors import ColorError, FlowabsError
from flowabs_nodes.image import Image, Origin
from flowabs_nodes.io import alpha as alphas
from flowabs_nodes.io import nonfinite as nonfinites
from flowabs_nodes.io.choose import choose_color, choose_data
from flowabs_nodes.io.formats import Format
from flowabs_nodes.io.image_file import open_picture
from flowabs_nodes.io.layers import Selection
from flowabs_nodes.io.orientation import upright
from flowabs_nodes.io.provenance import without_stamps
from flowabs_nodes.io.settings import Settings, checked

Say = Callable[[str], None]


def quiet(text: str) -> None:
    """Drop a message: the default where nobody listens."""


def read_image(
    path: str | os.PathLike[str],
    *,
    layer: str = "",
    part: str | int = "",
    colorspace: str = "auto",
    alpha: str = "auto",
    nonfinite: str = "repair",
    settings: Settings | None = None,
    note: Say = quiet,
    warn: Say = quiet,
) -> Image:
    """Read a plate as a color image: scene-linear, premultiplied, finite.

    Parameters
    ----------
    layer
        "" is the plain R, G, B[, A] (or grey Y) of the part whose name is most like a picture's, else the only layer
        that is named as a picture. Else a layer's name ("Fg.Combined"), a pass by its last name ("Diffuse Color",
        "albedo"), or a view layer or view whose picture is meant ("Fg", "right", "Fg.right").
    part
        The part of a multi-part file, by index or name, or the view whose parts are meant; "" looks through all.
    colorspace
        "auto" asks the file (:func:`flowabs_nodes.color.detect`); else any OCIO name, or "cineon".
    alpha
        "auto": premultiplied (straight in PNG), and opaque where A is 0 in every pixel; "ignore": opaque;
        "premultiplied" and "straight": as said.
    nonfinite
        "repair" NaN and Inf from their neighbours, or "error".
    settings, note, warn
        The run's limits; functions that are told what was found, and what is wrong with it.

    Raises
    ------
    ReadError
        If the file is missing, damaged, too large, not what its name says, or has no such layer, part or colour.
    ColorError
        If ``colorspace`` is no colour space, or pixels become NaN or Inf by it: no repair helps there.
    CommandError
        If the path lies outside ``settings.root``.
    """
    settings = settings or Settings()
    name = os.fspath(checked(path, settings))
    try:
        with open_picture(name, settings) as file:
            chosen = choose_color(file.specs, layer, part)
            source = file.specs[chosen.part]
            pixels = file.read(chosen.part, chosen.channels)
            format = file.format
        detected = _colorspace(source, format, colorspace, settings)
        _keep_only_true_tags(source, format, colorspace, detected, settings)
        for text in (chosen.note, f"colour space {detected.how}"):
            if text:
                note(text)

        pixels, repairs = nonfinites.repaired(pixels, nonfinite)
        if repairs:
            note(repairs)
        if format.oriented:
            pixels = upright(pixels, source)

        coverage, left_out = _coverage(pixels, chosen, alpha, note)
        rgb = np.repeat(pixels[..., :1], 3, axis=2) if chosen.grey else pixels[..., :3]
        straight = alpha == "straight" or (alpha == "auto" and format.stores_straight(source))
        space = detected.space
        if detected.encoding is not None:
            if coverage is not None and not straight:
                rgb, straight = nonfinites.finite(alphas.straight(rgb, coverage), "over its alpha"), True
            rgb, space = ocio.linearize(rgb, detected.encoding, settings.ocio)
        if coverage is not None:
            if straight:
                rgb = nonfinites.finite(alphas.premultiplied(rgb, coverage), "times its alpha")
            rgb = np.concatenate([rgb, coverage[..., None]], axis=2)
    except FlowabsError as error:
        error.at(file=name)
        raise
    spec = selected_spec(source, chosen, ("R", "G", "B", "A") if coverage is not None else ("R", "G", "B"))
    origin = Origin(os.path.abspath(name), chosen.part, chosen.layer, chosen.channels, left_out)
    return Image(rgb, spec, "color", colorspace=space, origin=origin)


def read_data(
    path: str | os.PathLike[str],
    *,
    layer: str = "",
    part: str | int = "",
    settings: Settings | None = None,
    note: Say = quiet,
    warn: Say = quiet,
) -> Image:
    """Read AOVs as a data image: the numbers as they are in the file, under their own channel names.

    ``layer`` is a layer ("crypto00"), one channel ("Z", "N.X") or a part's name; "" is every channel of the part, by
    default the first. Whole numbers of an EXR keep their value up to 2**24, which is what float32 holds exactly;
    ``warn`` says where there are larger ones. NaN and Inf stay. Raises ReadError as :func:`read_image`.
    """
    settings = settings or Settings()
    name = os.fspath(checked(path, settings))
    try:
        with open_picture(name, settings) as file:
            chosen = choose_data(file.specs, layer, part)
            if chosen.note:
                note(chosen.note)
            source = file.specs[chosen.part]
            pixels = file.read(chosen.part, chosen.channels)
    except FlowabsError as error:
        error.at(file=name)
        raise
    spec = selected_spec(source, chosen, chosen.channels)
    if spec.format == oiio.TypeUInt32 and (pixels >= 2**24).any():
        warn("ids above 16777216 are rounded: 32-bit whole numbers do not fit float32 (read_id keeps them)")
    nans, infs = nonfinites.count(pixels)
    if nans or infs:
        note(f"{nonfinites.said(nans, infs)} in {layer or 'the data'}, left as they are")
    return Image(pixels, spec, "data", origin=Origin(os.path.abspath(name), chosen.part, chosen.layer, chosen.channels))


def _colorspace(source: oiio.ImageSpec, format: Format, given: str, settings: Settings) -> color.Detected:
    """Find the colour space: the one given, else what the format's own fields declare, else OpenImageIO's tags."""
    if given in ("", "auto") and format.declared is not None:
        declared = format.declared(source)
        return color.detect(source, declared.name, settings.ocio, said_by=declared.source)
    photographed = format.display_referred and source.format.basetype not in (oiio.HALF, oiio.FLOAT, oiio.DOUBLE)
    return color.detect(source, given, settings.ocio, display_referred=photographed)


def _keep_only_true_tags(
    source: oiio.ImageSpec, format: Format, given: str, detected: color.Detected, settings: Settings
) -> None:
    """Remove a header's words on its colours where the user says that they are other colours."""
    if given not in ("", "auto"):
        try:
            said = _colorspace(source, format, "auto", settings)
        except ColorError:  # a tag of the config's that the config cannot convert
            forget(source)
            return
        if (said.space, said.encoding) != (detected.space, detected.encoding):
            forget(source)


def _coverage(pixels: Array, chosen: Selection, policy: str, note: Say) -> tuple[Array | None, str]:
    """Return the (H, W) alpha to work with and ""; or None and the name of the alpha channel that is left out."""
    if not chosen.has_alpha:
        return None, ""
    coverage = np.ascontiguousarray(pixels[..., -1])
    if policy == "ignore":
        return None, chosen.channels[-1]
    if policy == "auto" and not coverage.any():
        note("alpha is 0 in every pixel: the plate counts as opaque")
        return None, chosen.channels[-1]
    return coverage, ""


def selected_spec(source: oiio.ImageSpec, chosen: Selection, names: tuple[str, ...]) -> oiio.ImageSpec:
    """Return the file's header for the channels that were read, under their new names and without stamps."""
    stored = {str(source.channelformat(source.channelnames.index(name))) for name in chosen.channels}
    spec = oiio.ImageSpec(source)
    spec.set_format(oiio.TypeDesc(stored.pop() if len(stored) == 1 else "float"))
    spec.nchannels = len(names)
    spec.channelnames = names
    spec.channelformats = ()
    spec.alpha_channel = names.index("A") if "A" in names else -1
    spec.z_channel = -1
    spec.tile_width = spec.tile_height = spec.tile_depth = 0
    spec.erase_attribute("oiio:UnassociatedAlpha")
    spec.erase_attribute("tiff:UnassociatedAlpha")
    without_stamps(spec)
    return spec
