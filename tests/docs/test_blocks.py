"""Every block of README.md and of the pages below docs does what the page says.

Blocks run in order, each page in a folder of its own with the package installed from a wheel, or, where a block is marked so,
in a copy of the checkout (``blocks.py`` has the marks). What does not run says why, and is listed here.
"""

from __future__ import annotations

import shutil

import pytest

from tests.docs.blocks import Page, pages, parsed
from tests.docs.reading import Place, Reading, Wrong, matches
from tests.docs.supplies import supply

PAGES = pages()

needs_bash = pytest.mark.skipif(not shutil.which("bash"), reason="blocks are written for bash")


def test_every_block_says_what_to_do_with_it():
    mistakes = [mistake for page in PAGES for mistake in page.mistakes]
    assert not mistakes, "\n".join(mistakes)


def test_what_does_not_run_is_listed(capsys):
    listed = [f"{block.place}: {block.marks['not run']}" for page in PAGES for block in page.blocks if "not run" in block.marks]
    with capsys.disabled():
        print("\nblocks of the documentation that are not run:", *(listed or ["none"]), sep="\n  ")


@needs_bash
@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_page(page: Page, here: Place, in_clone: Place):
    supply(page, here.folder)
    failures = read(page, here, in_clone)
    assert not failures, "\n\n".join(failures)


def read(page: Page, here: Place, clone: Place) -> list[str]:
    """Return what went wrong, block by block; the blocks after it are tried too."""
    failures = []
    with Reading(here, clone) as reading:
        for block in page.blocks:
            try:
                reading.do(block)
            except (Wrong, ValueError, OSError, SyntaxError) as problem:
                failures.append(f"{block.place}:\n{block.text}{type(problem).__name__}: {problem}")
    return failures
