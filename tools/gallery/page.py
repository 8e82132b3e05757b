"""Write the gallery's page in Markdown: a picture, a claim, what there is to see and a command for each figure."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path

from flowabs_nodes.graph.shipped import paper
from tools.gallery.figures import Figure
from tools.gallery.inputs import DAMAGED, DRAWN
from tools.gallery.render import Rendered
from tools.gallery.texts import TEXTS

HEAD = """\
# Gallery

Every figure of "Flow-Based Image Abstraction" (Kang, Lee, Chui, IEEE TVCG 15(1), 2009), made by the graphs in
[graphs/paper](../../graphs/paper) on [pictures](../pictures/README.md) that ship with flowabs, or on inputs that are
drawn by code. Parameters are the paper's as printed, its default values where it prints none; Figs. 8, 9 and 20, which
need others and print few, have our own beside the printed ones. Captions name what the graph ran with, and numbers in
captions are measured on the very pictures shown.

One sheet of it again, and all of it:

<!-- in a clone -->
```sh
python -m tools.gallery --only fig07
```

<!-- not run: a minute and more; the tests make each sheet's graph run, in the blocks below -->
```sh
python -m tools.gallery
```

Figs. 14 and 21 need OpenCV: `pip install 'flowabs-nodes[compare]'`.

A figure's graph runs on any picture from the command line. The EXR that comes out holds its panels as layers; with a
name in .png it is the main panel alone. Lengths are pixels, as printed: on plates much larger than the paper's
512x512 lines come out thin (the [shipped graphs](../start.md) scale with the plate, these do not).

"""

TAIL = """\
<a id="fig23"></a>

## Fig. 23: time

![Time against kernel radius](fig23.svg)

**The paper:** the time of ETF, FDoG and FBL grows linearly with the radius of the kernel.

**Here:** so it does, on one thread; the plot has the fits, and [the numbers](fig23.json) are beside it. The full
bilateral filter grows with the square.

<!-- not run: minutes of measuring -->
```sh
python -m tools.gallery.speed --json docs/gallery/fig23.json --svg docs/gallery/fig23.svg
```

Figs. 2, 6 and 15 of the paper are diagrams, Fig. 22 shows its test pictures. [Side by side](../compare/README.md)
has our lines and flat colour beside other methods on five pictures, with numbers.
"""


def page(sheets: Iterable[Rendered]) -> str:
    """Return the whole page."""
    sheets = list(sheets)
    links = " · ".join(f"[{sheet.figure.title.partition(':')[0]}](#{sheet.figure.name})" for sheet in sheets)
    links += " · [Fig. 23](#fig23)"
    return HEAD + links + "\n\n" + "\n".join(map(section, sheets)) + "\n" + TAIL


def section(sheet: Rendered) -> str:
    """Return the section of one figure."""
    figure = sheet.figure
    alt = "; ".join(title for title, _ in sheet.captions)
    text = TEXTS[figure.name]
    layers = _layers(figure.name)
    return f"""\
<a id="{figure.name}"></a>

## {figure.title}

![{alt}]({sheet.file.name})

**The paper:** {text.claim}

**Here:** {text.see}

<!-- in a clone -->
```sh
flowabs run {figure.name} -i {_input(figure)} -o {figure.name}.exr{f"    # layers: {layers}" if layers else ""}
```
"""


def _input(figure: Figure) -> str:
    name = figure.rows[0].picture
    if name in DRAWN:
        return f"docs/gallery/inputs/{name}.exr"
    return f"docs/gallery/inputs/{name}.png" if name in DAMAGED else f"docs/pictures/{name}"


def _layers(graph: str) -> str:
    """Return the names of the layers beside the main picture."""
    nodes = json.loads(Path(paper()[graph]).read_text(encoding="utf-8"))["nodes"]
    return ", ".join(name for name in nodes["out"]["inputs"] if name != "image")
