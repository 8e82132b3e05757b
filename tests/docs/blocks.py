"""Find the blocks of code in a page of Markdown, and what comments above them say about running them.

A comment stands on lines of its own straight above the fence, where GitHub does not show it:

- ``<!-- not run: REASON -->``: nothing is done with the block;
- ``<!-- in a clone -->``: it runs in a copy of the checkout, not where only the package is installed;
- ``<!-- saved as NAME -->``: the reader puts it into a file of this name, which the words above the block say too;
- ``<!-- added to NAME -->``: the reader adds it to a file that is there by then: Python at its end, JSON to the nodes
  of a graph.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]

#: Each mark, and whether something has to follow it.
MARKS = {"not run": True, "in a clone": False, "saved as": True, "added to": True}

LANGUAGES = ("sh", "bash", "python", "json", "toml", "text")

_FENCE = re.compile(r"( {0,3})(`{3,}|~{3,})\s*(\S*)")
_COMMENT = re.compile(r"\s*<!--\s*(.*?)\s*-->\s*")
_ITEM = re.compile(r"\s*([-*+]|\d+[.)])\s")


class Block(NamedTuple):
    """A block of code: its page and the line of its fence, its language, text and marks, and the words above it."""

    page: str
    line: int
    language: str
    text: str
    marks: dict[str, str]
    words: str

    @property
    def place(self) -> str:
        """Return the page and the line of the block, as editors and compilers write them."""
        return f"{self.page}:{self.line}"


class Page(NamedTuple):
    """A page: its path from the root, its blocks in order, all its words outside of them, and what is wrong with it."""

    name: str
    blocks: tuple[Block, ...]
    words: str
    mistakes: tuple[str, ...]


def pages(root: Path = ROOT) -> list[Page]:
    """Return README.md and every page below docs that has a block of code, or a mistake."""
    files = [root / "README.md", *sorted((root / "docs").rglob("*.md"))]
    found = [parsed(path.read_text(encoding="utf-8"), path.relative_to(root).as_posix()) for path in files]
    return [page for page in found if page.blocks or page.mistakes]


def parsed(text: str, name: str) -> Page:
    """Return a page from its Markdown."""
    blocks: list[Block] = []
    mistakes: list[str] = []
    words: list[str] = []  # lines since the last block
    everything: list[str] = []
    lines = iter(enumerate(text.splitlines(), 1))
    for number, line in lines:
        fence = _FENCE.match(line)
        if not fence:
            if _is_indented_code(line, words):
                mistakes.append(f"{name}:{number}: code that is indented: put it between ``` and name its language")
            words.append(line)
            continue
        inside = list(_until(fence[2], lines))
        code = "".join(each.removeprefix(fence[1]) + "\n" for each in inside)
        marks, wrong = _marks(words)
        block = Block(name, number, fence[3], code, marks, "\n".join(words))
        blocks.append(block)
        mistakes += [f"{block.place}: {each}" for each in [*wrong, *_wrong(block)]]
        everything += words
        words = []
    return Page(name, tuple(blocks), "\n".join([*everything, *words]), tuple(mistakes))


def _until(fence: str, lines: Iterator[tuple[int, str]]) -> Iterator[str]:
    """Yield the lines up to the fence that closes a block."""
    for _, line in lines:
        if line.strip().startswith(fence) and not line.strip().strip(fence[0]):
            return
        yield line


def _is_indented_code(line: str, above: list[str]) -> bool:
    """Return whether a line, after an empty one, is indented as code is, and does not go on with an item of a list."""
    if not line.startswith("    ") or not line.strip() or (above and above[-1].strip()):
        return False
    outer = next((each for each in reversed(above) if each.strip() and not each.startswith(" ")), "")
    return not _ITEM.match(outer)


def _marks(above: list[str]) -> tuple[dict[str, str], list[str]]:
    """Return the marks in the comments at the end of ``above``, and a sentence for each that cannot be understood."""
    marks: dict[str, str] = {}
    wrong = []
    for line in reversed(above):
        comment = _COMMENT.fullmatch(line)
        if not comment:
            break
        mark = next((each for each in MARKS if comment[1].startswith(each)), "")
        said = comment[1].removeprefix(mark).lstrip(": ").strip()
        if not mark or bool(said) != MARKS[mark]:
            wrong.append(f"<!-- {comment[1]} --> is none of: {', '.join(map(_written, MARKS))}")
        else:
            marks[mark] = said
    return marks, wrong


def _written(mark: str) -> str:
    return f"{mark}: REASON" if mark == "not run" else f"{mark} NAME" if MARKS[mark] else mark


def _wrong(block: Block) -> Iterator[str]:
    """Yield a sentence for each way in which a block does not say what to do with it."""
    if block.language not in LANGUAGES:
        yield f"the language {block.language!r} is none of: {', '.join(LANGUAGES)}"
    for mark in ("saved as", "added to"):
        name = block.marks.get(mark)
        if name and f"`{name}`" not in block.words:
            yield f"is {mark} {name}, and the words above the block do not say so: expected `{name}` in them"
    if len(block.marks) > 1 and "not run" in block.marks:
        yield "is not run, and has other marks"
