"""docs/exr.md: each test that it names is there, and each promise that the tests try is in its table."""

from __future__ import annotations

import ast
import re

import pytest

from tests.docs.blocks import ROOT
from tools.reliability.promises import PROMISES

PAGE = (ROOT / "docs/exr.md").read_text(encoding="utf-8")
NAMED = sorted(set(re.findall(r"`(tests/[\w/]+\.py)::(\w+)`", PAGE)))


@pytest.mark.parametrize("file", sorted({file for file, _ in NAMED}))
def test_what_is_named_is_there(file: str) -> None:
    body = ast.parse((ROOT / file).read_text(encoding="utf-8")).body
    there = {each.name for each in body if isinstance(each, ast.FunctionDef)}
    assert {name for named, name in NAMED if named == file} <= there


def test_each_row_names_a_test() -> None:
    rows = [line for line in PAGE.splitlines() if line.startswith("|") and not line.startswith("|---")]
    without = [row for row in rows if "::test_" not in row]
    assert [row.rpartition("| ")[2] for row in without] == ["proved by |", "seen by |", "proved by |"]


def test_each_promise_is_in_the_table() -> None:
    first = {cell for row in PAGE.splitlines() if row.startswith("| ") for cell in row.split(" | ")[0][2:].split(", ")}
    assert set(PROMISES) <= first
