"""Where the paper's equations are computed: ``python -m tools.equations`` writes the table of ``docs/layout.md``.

A line that computes equation 11 ends with ``# eq. 11``. The table is made of these marks; a test says when it is old.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "layout.md"
BEGIN, END = "<!-- equations -->\n", "<!-- end of equations -->\n"
MARK = re.compile(r"# eq\. (\d+)(?![\d.])")

#: What each numbered equation of the paper says.
EQUATIONS = {
    1: "the ETF filter: a tangent becomes the weighted sum of those around it",
    2: "w_s, the spatial weight: 1 inside of the radius",
    3: "w_m, the magnitude weight",
    4: "w_d, the direction weight",
    5: "φ, which turns a tangent that points the other way",
    6: "H, the FDoG response: along the flow, the DoG across it",
    7: "G, the Gaussian",
    8: "f, the difference of Gaussians",
    9: "lines: the response against the threshold τ",
    10: "H_g, the DoG along the gradient axis",
    11: "H_e, along the flow axis: the FDoG response in two passes",
    12: "C_e, the bilateral filter along the flow",
    13: "h, the range kernel: how alike two colours are",
    14: "C_g, the bilateral filter across the flow",
}


def marks(package: Path = ROOT / "flowabs_nodes") -> dict[int, list[tuple[str, int]]]:
    """Return, for each equation, (file, line) of every line of the package that is marked with it."""
    found: dict[int, list[tuple[str, int]]] = {}
    for file in sorted(package.rglob("*.py")):
        for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
            for mark in MARK.finditer(line):
                found.setdefault(int(mark[1]), []).append((file.relative_to(package.parent).as_posix(), number))
    return found


def table() -> str:
    """Return the table in Markdown: equation, what it says, where it is computed."""
    rows = ["| equation | what it says | computed at |", "|---|---|---|"]
    found = marks()
    for equation, words in EQUATIONS.items():
        places = ", ".join(
            f"[{Path(file).relative_to('flowabs_nodes').as_posix()}:{line}](../{file}#L{line})"
            for file, line in found.get(equation, [])
        )
        rows.append(f"| {equation} | {words} | {places} |")
    return "\n".join(rows) + "\n"


def page(text: str) -> str:
    """Return the page's text with the table as it is now."""
    before, rest = text.split(BEGIN)
    return before + BEGIN + table() + END + rest.split(END)[1]


if __name__ == "__main__":
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
    sys.exit(0)
