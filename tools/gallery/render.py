"""Render a figure's contact sheet: run its graph on its pictures, and caption them with the parameters used."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from flowabs_nodes.engine import load_graph
from flowabs_nodes.graph.shipped import paper
from flowabs_nodes.image import Image
from tools.gallery import inputs
from tools.gallery.figures import Figure
from tools.gallery.sheet import Tile, display, enlarged, fitted, save, sheet

Results = Mapping[str, Image]


@dataclass(frozen=True)
class Rendered:
    """A sheet on disk, and its captions for the page: (letter and title, words)."""

    figure: Figure
    file: Path
    captions: tuple[tuple[str, str], ...]


def render(figure: Figure, folder: Path) -> Rendered:
    """Run a figure's graph and write its sheet into ``folder``; drawn inputs go into ``folder/inputs``."""
    graph = load_graph(paper()[figure.name])
    values = graph.values(1)
    results: dict[str, Results] = {}
    measured: dict[str, Mapping[str, str]] = {}
    for picture in dict.fromkeys(row.picture for row in figure.rows):
        wanted = {panel.output for row in figure.rows if row.picture == picture for panel in row.panels}
        file = inputs.file_of(picture, folder / "inputs")
        done = graph.run(set={"plate.file": str(file)}, outputs=sorted(wanted), on_event=lambda event: None)
        results[picture] = done
        measured[picture] = figure.measure(done, picture) if figure.measure else {}
    letters = iter("abcdefghijklmnopqrstuvwxyzABCDEFGH")
    whole = {row.picture for row in figure.rows if row.box is None}
    rows: list[list[Tile]] = []
    for row in figure.rows:
        tiles = []
        for panel in row.panels:
            words = ", ".join(f"{key.split('.')[1]} {_plain(_value(values, key))}" for key in panel.values)
            found = measured[row.picture].get(panel.output, "")
            words = "; ".join(part for part in (words, found) if part)
            pixels = display(results[row.picture][panel.output])
            shown = enlarged(pixels, row.box, row.zoom) if row.box else fitted(pixels, figure.width)
            title = re.sub(r"\{([\w.]+)\}", lambda found: _plain(_value(values, found[1])), panel.title)
            closer = ", enlarged" if row.zoom > 1 else ", 1:1" if row.box else ""
            tiles.append(
                Tile(shown, f"({next(letters)}) {title}{closer}", "" if row.box and row.picture in whole else words)
            )
        columns = row.columns or figure.columns
        rows.extend(tiles[i : i + columns] for i in range(0, len(tiles), columns))
    captions = tuple((tile.title, tile.words) for tiles in rows for tile in tiles)
    return Rendered(figure, save(sheet(rows), folder / f"{figure.name}.png"), captions)


def _value(values: Mapping[str, Mapping[str, object]], key: str) -> object:
    node, name = key.split(".")
    return values[node][name]


def _plain(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
