"""Names results by keys: the same key means the same picture, on any machine, on any day.

A node's key is a hash of its type and version, the version of the package it comes from, the parameters that do
something beside each other, and the keys of its inputs, on all frames that it reads; where it reads a file, of the
file's content instead of its name. The number of the frame counts only as far as a node says so (``moment``). No filter
has to run to know it.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import json
from collections.abc import Iterable, Mapping
from functools import cache
from typing import TYPE_CHECKING, Any

from flowabs_nodes import __version__
from flowabs_nodes.engine.lengths import has_lengths
from flowabs_nodes.engine.plan import Result, Step, Unit
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Node

if TYPE_CHECKING:
    from flowabs_nodes.graph.model import Graph
    from flowabs_nodes.graph.reference_size import ReferenceSize

_BYTES = 20


def unit_keys(
    graph: Graph,
    steps: Iterable[Step],
    params: Mapping[Unit, Mapping[str, Any]],
    *,
    contents: Mapping[Unit, str],
    given: Mapping[Result, str],
    scale: float,
    ocio: str,
) -> dict[Unit, str]:
    """Compute the key of every step's unit.

    Parameters
    ----------
    params
        Each unit's parameters, checked, before lengths are scaled: the scaled ones follow from the pictures that come
        in, ``reference_size`` and ``scale``.
    contents
        For each unit that reads a file, what stands in it (:func:`flowabs_nodes.engine.sources.source_contents`).
    given
        The keys of results that come from outside (:func:`image_key`).
    ocio
        The content of the OCIO config (:attr:`flowabs_nodes.color.config.Config.content`); "" for the pinned one.
    """
    keys: dict[Unit, str] = {}

    def key_of(result: Result) -> Any:
        return given.get(result) or [keys[result.unit], result.output]

    for step in steps:
        declaration = graph.nodes[step.unit.node].declaration
        keys[step.unit] = node_key(
            declaration,
            params[step.unit],
            {
                name: key_of(needed)
                if isinstance(needed, Result)
                else [[offset, key_of(each)] for offset, each in needed.items()]
                for name, needed in step.inputs.items()
            },
            frame=step.unit.frame,
            content=contents.get(step.unit, ""),
            reference_size=graph.reference_size,
            scale=scale,
            ocio=ocio,
        )
    return keys


def node_key(
    declaration: Node,
    params: Mapping[str, Any],
    inputs: Mapping[str, Any],
    *,
    frame: int = 1,
    content: str = "",
    reference_size: ReferenceSize | None = None,
    scale: float = 1.0,
    ocio: str = "",
) -> str:
    """Compute the key of one node, in hexadecimal; the order of its parameters and inputs does not matter.

    ``params`` are checked, lengths not scaled; one that the others disable counts as its default. ``inputs`` are plain
    data that name each input's key and output; the others are as for :func:`unit_keys`.
    """
    moment = None if declaration.moment is None else declaration.moment(declaration.defaults() | dict(params), frame)
    touches_files = declaration.file_param is not None
    size = None if reference_size is None else [reference_size.measure, reference_size.pixels]
    return _digest(
        {
            "type": declaration.name,
            "package": package_version(str(declaration.run.__module__).partition(".")[0]),
            "params": {
                param.name: _exact(value)
                for param in declaration.all_params.values()
                if param.in_key and param.kind != "file" and param.name in params
                for value in [params[param.name] if declaration.is_enabled(param.name, params) else param.default]
                if not (param.later and value == param.default)
            },
            "inputs": dict(inputs),
            "content": content,
            "lengths": [_exact(size), _exact(scale)] if has_lengths(declaration) else None,
            "scale": _exact(scale) if touches_files else None,
            "ocio": ocio if declaration.uses_config else "",
            **({} if moment is None else {"moment": _exact(moment)}),
        }
    )


def image_key(image: Image) -> str:
    """Compute the key of an image that comes from outside: of its pixels, windows, metadata, type and colour space."""
    state = hashlib.blake2b(image.pixels.data, digest_size=_BYTES)
    about = [state.hexdigest(), image.spec.to_xml(), image.type, image.colorspace.name, list(image.colorspace.to_xyz)]
    return _digest([_exact(each) for each in about])


@cache
def package_version(package: str) -> str:
    """Return the version of the installed distribution that an import package comes from; "" where there is none."""
    if package == "flowabs_nodes":
        return __version__
    names = importlib.metadata.packages_distributions().get(package, [])
    return ",".join(sorted(f"{name} {importlib.metadata.version(name)}" for name in set(names)))


def _digest(value: Any) -> str:
    """Hash plain data, in hexadecimal."""
    text = json.dumps(value, sort_keys=True, ensure_ascii=True, separators=(",", ":"))
    return hashlib.blake2b(text.encode(), digest_size=_BYTES).hexdigest()


def _exact(value: Any) -> Any:
    """Return plain data in which each number has one spelling: 5, 5.0 and NumPy's 5 are the same, to the last bit."""
    match value:
        case None | bool() | str():
            return value
        case Mapping():
            return {str(name): _exact(each) for name, each in value.items()}
        case list() | tuple():
            return [_exact(each) for each in value]
        case _:
            return {"number": float(value).hex()}
