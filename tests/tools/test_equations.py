"""Every equation of the paper is found from docs/layout.md at the line that computes it."""

from __future__ import annotations

import re

import pytest

from tools import equations


def test_the_table_is_what_the_marks_say():
    text = equations.PAGE.read_text(encoding="utf-8")
    assert text == equations.page(text), "run python -m tools.equations"


@pytest.mark.parametrize("equation", [1, 6, 9, 10, 11, 12, 14])
def test_the_equation_is_computed_where_the_table_points(equation):
    places = equations.marks()[equation]
    assert places
    for file, number in places:
        line = (equations.ROOT / file).read_text(encoding="utf-8").splitlines()[number - 1]
        code = line.split("#")[0].strip()
        assert re.search(r"[=(]", code), f"{file}:{number} marks no computation: {line}"


def test_no_mark_is_of_an_equation_that_the_paper_does_not_have():
    assert set(equations.marks()) <= set(equations.EQUATIONS)


def test_every_file_that_the_page_names_is_there():
    """In a row of a table, a name without a folder is in that of the name before it."""
    package = equations.ROOT / "flowabs_nodes"
    for row in equations.PAGE.read_text(encoding="utf-8").splitlines():
        folder = ""
        for name in re.findall(r"`((?!tests/)[\w/]+\.py)`", row):
            folder = name.rsplit("/", 1)[0] if "/" in name else folder
            assert (package / folder / name.rsplit("/", 1)[-1]).is_file(), name
