"""Send EXRs through two graphs, and see what is kept: ``python -m tools.reliability.fidelity FOLDER…``.

One graph reads and writes, the other flattens lightness in between; both keep all layers. A table says of each file
which promises of docs/exr.md are kept; the exit code is 1 if one is broken, or a file is refused that OpenImageIO and
OpenEXR read whole.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import traceback
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import OpenImageIO as oiio

import flowabs_nodes as fa
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.io.oiio_error import reason
from flowabs_nodes.io.read import read_data, read_image
from tools.reliability.exr_facts import read_parts
from tools.reliability.promises import PROMISES, Passage
from tools.reliability.reading import OTHERS

#: Ways through, by name: the node that reads, and the one that changes colours.
WAYS = {"copy": ("read@1", ""), "quantize": ("read@1", "quantize@1"), "data": ("read_aov@1", "")}
#: Codes of errors that say of a sound file that it is not for us.
_NOT_FOR_US = ("deep", "too-large")
_SIGNS = {None: "·", "": "kept"}


@dataclass(frozen=True)
class Row:
    """What became of a file on one way: what each promise says, or the error that refused the file."""

    file: Path
    way: str
    promises: dict[str, str | None] = field(default_factory=dict)
    refused: str = ""
    fault: str = ""

    @property
    def faults(self) -> list[str]:
        """Return what is wrong, each as a line."""
        broken = [f"{name}: {said}" for name, said in self.promises.items() if said]
        return [f"{self.file}, {self.way}: {said}" for said in (*broken, *filter(None, [self.fault]))]


class Refused(Exception):
    """A file that the graph does not take; ``error`` says why."""

    def __init__(self, error: FlowabsError) -> None:
        super().__init__(str(error))
        self.error = error


def graph(way: str, plate: Path, made: Path) -> dict[str, Any]:
    """Return the graph of a way, from one file to another."""
    read, change = WAYS[way]
    nodes: dict[str, Any] = {"plate": {"type": read, "params": {"file": str(plate)}}}
    if change:
        nodes["changed"] = {"type": change, "inputs": {"image": "plate"}}
    output = "changed" if change else "plate"
    written = {"file": str(made), "keep_layers": "*"}
    nodes["out"] = {"type": "write@1", "inputs": {"image": output}, "params": written}
    return {"format": "flowabs.graph/1", "nodes": nodes}


def passage(plate: Path, way: str, made: Path) -> Passage:
    """Send a plate through a graph, and return both ends. Raises Refused."""
    try:
        report = fa.run(graph(way, plate.resolve(), made), existing="overwrite")
    except FlowabsError as error:
        raise Refused(error) from error
    if report.frames[0].error is not None:
        raise Refused(report.frames[0].error)
    read = read_data if way == "data" else read_image
    first, second = read(plate), read(made)
    assert first.origin is not None
    said = (*report.notes, *report.frames[0].notes)
    return Passage(
        before=read_parts(plate),
        after=read_parts(made),
        origin=first.origin,
        way="data" if way == "data" else "changed" if WAYS[way][1] else "same",
        notes=tuple(note.text for note in said if not note.warning),
        warnings=tuple(note.text for note in said if note.warning),
        spaces=(first.colorspace.name, second.colorspace.name),
    )


def rows(plate: Path) -> Iterator[Row]:
    """Send a plate on the ways that are for it: a file without colour goes as data."""
    ways = ["copy", "quantize"]
    with tempfile.TemporaryDirectory() as folder:
        while ways:
            way = ways.pop(0)
            try:
                ends = passage(plate, way, Path(folder) / f"{way}.exr")
                yield Row(plate, way, {name: kept(ends) for name, kept in PROMISES.items()})
            except Refused as refused:
                if refused.error.code in ("no-color", "ambiguous-layer") and way == "copy":
                    ways = ["data"]
                    continue
                ways = []
                yield Row(plate, way, refused=refused.error.message, fault=_unjust(plate, refused.error))
            except Exception:  # noqa: BLE001 - that is what is looked for
                yield Row(plate, way, fault=traceback.format_exc(limit=-2))


def _unjust(plate: Path, error: FlowabsError) -> str:
    """Return who reads a file whole that was refused; "" where the refusal is right."""
    whole = all(reads(str(plate)) for reads in OTHERS.values())
    reason(oiio)  # else what OpenImageIO said is printed when the process ends
    if error.code in _NOT_FOR_US or not whole:
        return ""
    return f"refused, though {' and '.join(OTHERS)} read it whole: {error}"


def table(made: Sequence[Row], folder: Path) -> str:
    """Return all rows as a table of plain text: kept, BROKEN, or a dot where a file has nothing of the kind."""
    names = [str(row.file.relative_to(folder) if folder in row.file.parents else row.file) for row in made]
    first = max(map(len, names), default=4)
    lines = ["  ".join([f"{'file':{first}}", f"{'way':8}", *PROMISES])]
    for name, row in zip(names, made, strict=True):
        start = [f"{name:{first}}", f"{row.way:8}"]
        if row.promises:
            cells = [f"{_SIGNS.get(said, 'BROKEN'):{len(promise)}}" for promise, said in row.promises.items()]
        else:
            cells = [f"refused: {row.refused}"[:120] if row.refused else "TRACEBACK"]
        lines.append("  ".join([*start, *cells]))
    return "\n".join(lines)


def main() -> int:
    """Print the table; return 1 if a promise is broken."""
    parser = argparse.ArgumentParser(prog="python -m tools.reliability.fidelity", description=__doc__)
    parser.add_argument("places", nargs="+", type=Path, metavar="FOLDER", help="folders, or EXR files")
    given = parser.parse_args()
    made: list[Row] = []
    for place in given.places:
        plates = sorted(place.rglob("*.exr")) if place.is_dir() else [place]
        found = [row for plate in plates for row in rows(plate)]
        print(table(found, place))
        made += found
    faults = [fault for row in made for fault in row.faults]
    print(*faults, sep="\n")
    refused = sum(bool(row.refused) for row in made)
    print(f"{len({row.file for row in made})} files, {refused} refused; {len(faults)} promises broken")
    return int(bool(faults) or not made)


if __name__ == "__main__":
    sys.exit(main())
