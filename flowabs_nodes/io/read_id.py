"""Read which object each pixel of a render shows, from a Cryptomatte or a pass of whole numbers."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from flowabs_nodes.errors import ReadError
from flowabs_nodes.image import Image
from flowabs_nodes.io import cryptomatte, passes
from flowabs_nodes.io.image_file import PictureFile
from flowabs_nodes.io.layer_groups import Layer, inside_of, of_default_view, within
from flowabs_nodes.io.layers import Selection
from flowabs_nodes.io.pass_names import ANY_CRYPTOMATTE, ANY_MATERIAL, CRYPTOMATTE, ID, MATERIAL, Names, plain_name
from flowabs_nodes.io.read import Say, quiet
from flowabs_nodes.io.read_passes import grey, image_of, opened, say_which
from flowabs_nodes.io.settings import Settings
from flowabs_nodes.io.views import split_view, views_in
from flowabs_nodes.port_types import TYPES


def read_id(
    path: str | os.PathLike[str],
    *,
    layer: str = "",
    part: str | int = "",
    settings: Settings | None = None,
    note: Say = quiet,
    warn: Say = quiet,
) -> tuple[Image, Image]:
    """Read an id pass: an id image, uint32, and as a mono the part of each pixel that its id covers, 0 to 1.

    ``layer`` "" takes the Cryptomatte of objects, else a channel of whole numbers, by the usual names
    (:data:`flowabs_nodes.io.pass_names.CRYPTOMATTE` and ``ID``), else the file's only Cryptomatte; "cryptomatte",
    "Fg.cryptomatte" take no id pass, "material", "Fg.material" take materials, from either. Of a Cryptomatte the id
    that covers most of a pixel is taken, 0 where the background does; its manifest goes along as metadata. Whole
    numbers may be stored as uint, float or half; their coverage is 1, and -1 becomes 4294967295. Raises ReadError as
    :func:`read_depth`, and where a channel's numbers are not whole.
    """
    with opened(path, settings, part) as (file, layers):
        known = cryptomatte.declared(file.specs)
        chosen = _id_layer(file, layers, layer, known)
        if len(chosen.channels) == 4:
            ids, coverage = cryptomatte.majority(file, layers, chosen)
        else:
            planes = file.read_native(chosen.part, chosen.channels)
            names = MATERIAL if plain_name(layer).endswith(ANY_MATERIAL) else ID
            numbers = grey(np.stack([planes[name] for name in chosen.channels], axis=2), chosen, names)
            ids = _whole(numbers, chosen, names)[..., 0]
            coverage = np.ones(ids.shape, np.float32)
        say_which(chosen, layer, note)
        name = cryptomatte.base_name(split_view(chosen.layer, views_in(file.specs))[0])
        manifest = known.get(name, {}) if len(chosen.channels) == 4 else {}
        return image_of(file, chosen, "id", ids, manifest), image_of(file, chosen, "mono", coverage, manifest)


def _id_layer(file: PictureFile, layers: Sequence[Layer], layer: str, known: dict[str, dict[str, Any]]) -> Selection:
    """Return four channels of a Cryptomatte's first level, or the channel of whole numbers, to read ids from."""
    bases = set(known) | {
        cryptomatte.base_name(each.base)
        for each in layers
        if plain_name(each.base).startswith("crypto") and cryptomatte.first_level(each)
    }
    levels = [each for each in layers if cryptomatte.base_name(each.base) in bases and cryptomatte.first_level(each)]
    if layer:
        base, view = split_view(layer, views_in(file.specs))
        wanted = cryptomatte.base_name(base)
        if any(wanted in (base, base.rpartition(".")[2]) for base in bases):
            first = f"{wanted}00" + (f".{view}" if view else "")
            return passes.find_named(file.specs, levels, first, CRYPTOMATTE, cryptomatte.first_level)
        where = ".".join(filter(None, (base.rpartition(".")[0], view)))
        if plain_name(base) == ANY_CRYPTOMATTE:
            if found := _cryptomatte(file, within(file.specs, levels, where) if where else levels):
                return found
        elif plain_name(base) == ANY_MATERIAL:
            return _material(file, within(file.specs, layers, where) if where else layers, levels)
        inside = inside_of(file.specs, layers, layer, Layer.single)
        found = _usual(file, inside, [each for each in levels if each in inside])
        return found or passes.find_named(file.specs, layers, layer, ID, Layer.single)
    found = _usual(file, layers, levels) or passes.find_only(layers, Layer.single)
    if found is None:
        usual = (*CRYPTOMATTE.usual, *ID.usual)
        raise passes.missing(file.specs, layers, ID._replace(usual=usual))
    return found


def _material(file: PictureFile, layers: Sequence[Layer], levels: Sequence[Layer]) -> Selection:
    """Return the Cryptomatte of materials, else a pass of whole numbers. Raises ReadError where there is neither."""
    inside = [each for each in levels if each in layers]
    found = (
        passes.find_usual(file.specs, inside, MATERIAL, cryptomatte.first_level)
        or passes.find_usual(file.specs, layers, MATERIAL, Layer.single)
        or passes.find_only(layers, Layer.single)
    )
    if found is None:
        raise passes.missing(file.specs, layers, MATERIAL)
    return found


def _usual(file: PictureFile, layers: Sequence[Layer], levels: Sequence[Layer]) -> Selection | None:
    """Return the Cryptomatte of objects, else an id pass, else the only Cryptomatte; None where there is none."""
    found = passes.find_usual(file.specs, levels, CRYPTOMATTE, cryptomatte.first_level)
    return found or passes.find_usual(file.specs, layers, ID, Layer.single) or _cryptomatte(file, levels)


def _cryptomatte(file: PictureFile, levels: Sequence[Layer]) -> Selection | None:
    """Return the Cryptomatte of objects, else the only one; None where there is none, or several."""
    found = passes.find_usual(file.specs, levels, CRYPTOMATTE, cryptomatte.first_level)
    if found:
        return found
    here, said = of_default_view(file.specs, levels)
    return (
        Selection(here[0].part, here[0].name, cryptomatte.first_level(here[0]) or (), said) if len(here) == 1 else None
    )


def _whole(numbers: npt.NDArray[Any], chosen: Selection, names: Names) -> npt.NDArray[Any]:
    """Return ids, uint32, of numbers of any type, which are whole; -1 becomes 4294967295. Raises ReadError."""
    if numbers.dtype.kind == "f":
        numbers = numbers.astype(np.float64)
    with np.errstate(invalid="ignore"):
        wrong = int((numbers != np.floor(numbers)).sum()) + int(((numbers > 2**32 - 1) | (numbers < -(2**31))).sum())
        if wrong and chosen.guessed:
            raise passes.guessed_wrong(chosen, names, f"{wrong} numbers are not whole, or too large", meant=False)
        if wrong:
            message = f"{wrong} of the numbers are no ids: whole, and at most 4294967295"
            raise ReadError(message, code="wrong-layer", hint="read_aov reads any numbers", parameter="layer")
    if numbers.dtype.kind == "f" and (numbers < 0).any():
        numbers = numbers.astype(np.int64) & 0xFFFFFFFF
    return TYPES["id"].cast(numbers, whole_floats=True)
