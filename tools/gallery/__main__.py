"""Make the gallery's sheets and its page: ``python -m tools.gallery [--only fig07]... [--out DIR]``."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from flowabs_nodes.errors import CommandError, FlowabsError, nearest
from tools.gallery.figures import FIGURES
from tools.gallery.inputs import pictures
from tools.gallery.page import page
from tools.gallery.render import render


def main(arguments: list[str] | None = None) -> int:
    """Make the sheets asked for, and the page if all are; return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m tools.gallery", description="Makes docs/gallery again.")
    parser.add_argument(
        "--only", action="append", metavar="FIGURE", help="one sheet, without the page; may be repeated"
    )
    parser.add_argument("--out", type=Path, metavar="DIR", help="where to (docs/gallery)")
    given = parser.parse_args(arguments)
    try:
        make(given.only or [], given.out or pictures().parent / "gallery")
    except FlowabsError as error:
        print(error, file=sys.stderr)
        return error_code(error)
    return 0


def make(only: list[str], folder: Path) -> None:
    """Write the sheets named, or all and the page, into ``folder``."""
    known = {figure.name: figure for figure in FIGURES}
    for name in only:
        if name not in known:
            raise CommandError(f"no figure {name!r}", hint=nearest(name, known), code="unknown-figure")
    sheets = []
    for figure in (known[name] for name in only or known):
        sheets.append(render(figure, folder))
        print(f"{sheets[-1].file}  {sheets[-1].file.stat().st_size / 1000:.0f} kB", flush=True)
    if not only:
        (folder / "README.md").write_text(page(sheets), encoding="utf-8")


def error_code(error: FlowabsError) -> int:
    """Return the exit code of an error, as the command line: 2 where the command is wrong, 1 where the work failed."""
    return 2 if isinstance(error, CommandError) else 1


if __name__ == "__main__":
    sys.exit(main())
