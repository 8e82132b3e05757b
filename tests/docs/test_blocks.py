"""Every block of README.md and of the pages below docs does what the page says.

Blocks run in order, each page in a folder of its own with the package installed from a wheel, or, where a block is
marked so, in a copy of the checkout (``blocks.py`` has the marks). What does not run says why, and is listed here.
"""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

import pytest

from tests.docs.blocks import ROOT, Page, pages, parsed
from tests.docs.reading import Place, Reading, Wrong, matches, shell
from tests.docs.supplies import supply

PAGES = pages()

needs_bash = pytest.mark.skipif(
    sys.platform == "win32" or not shutil.which("bash"), reason="blocks are written for bash"
)


def test_every_block_says_what_to_do_with_it():
    mistakes = [mistake for page in PAGES for mistake in page.mistakes]
    assert not mistakes, "\n".join(mistakes)


def test_what_does_not_run_is_listed(capsys):
    blocks = [block for page in PAGES for block in page.blocks]
    listed = [f"{block.place}: {block.marks['not run']}" for block in blocks if "not run" in block.marks]
    with capsys.disabled():
        print(f"\n{len(listed)} of {len(blocks)} blocks of the documentation are not run:", *listed, sep="\n  ")
    assert len(listed) < len(blocks) / 2


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


@needs_bash
@pytest.mark.slow
def test_the_package_that_blocks_find_is_the_wheel(here):
    where = shell('python -c "import flowabs_nodes; print(flowabs_nodes.__file__)"; command -v flowabs', here).split()
    assert not [path for path in where if Path(path).is_relative_to(ROOT)]
    assert [Path(path).name for path in where] == ["__init__.py", "flowabs"]
    assert len({path.split("/venv/")[0] for path in where}) == 1


# ---------------------------------------------------------------------- the test itself finds what it looks for


@pytest.fixture
def outcome(tmp_path):
    """Return a function that reads a page in an empty folder, by the Python of the tests, and returns the failures."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", os.defpath)])
    place = Place(tmp_path, {**os.environ, "PATH": path, "PYTHONPATH": str(ROOT)})

    def read_page(text: str) -> list[str]:
        page = parsed(text, "page.md")
        assert not page.mistakes
        supply(page, place.folder)
        return read(page, place, place)

    return read_page


def test_a_block_is_found_with_its_line_language_and_marks():
    text = "Words\n\n<!-- in a clone -->\n<!-- saved as `x` is not it: y -->\n"
    page = parsed("As `a.py`:\n\n<!-- saved as a.py -->\n<!-- in a clone -->\n~~~python\na = 1\n\n~~~\nAfter\n", "p.md")
    (block,) = page.blocks
    assert block[:4] == ("p.md", 5, "python", "a = 1\n\n")
    assert block.marks == {"saved as": "a.py", "in a clone": ""}
    assert page.words.endswith("After")
    assert not page.mistakes
    assert not parsed(text, "p.md").mistakes  # a comment that no block follows is not ours


@pytest.mark.parametrize(
    ("text", "mistake"),
    [
        ("Words\n\n    flowabs run\n", "p.md:3: code that is indented"),
        ("```\nflowabs run\n```\n", "p.md:1: the language ''"),
        ("```json5\n{}\n```\n", "p.md:1: the language 'json5'"),
        ("<!-- not run -->\n```sh\nx\n```\n", "<!-- not run --> is none of: not run: REASON"),
        ("<!-- skip -->\n```sh\nx\n```\n", "<!-- skip --> is none of"),
        ("<!-- saved as a.py -->\n```python\nx\n```\n", "expected `a.py`"),
        ("<!-- in a clone -->\n<!-- not run: long -->\n```sh\nx\n```\n", "is not run, and has other marks"),
    ],
)
def test_a_block_that_does_not_say_what_to_do_with_it_is_a_mistake(text, mistake):
    (found,) = parsed(text, "p.md").mistakes
    assert mistake in found


def test_an_item_of_a_list_may_go_on_indented():
    assert not parsed("1. One\n\n    goes on\n\n    - deeper\n", "p.md").mistakes


@needs_bash
def test_a_page_that_is_true_has_no_failures(outcome):
    page = """
In `a.py`:
<!-- saved as a.py -->
```python
def two():
    return 2
```
<!-- added to a.py -->
and `a.py` again
<!-- added to a.py -->
```python
def three():
    return two() + 1
```
```python
from a import three
found = three()
```
```python
print("found", found)
```
```text
found 3
```
```sh
test -f a.py
for n in 1 2 3; do echo "line $n"; done
```
```text
line 1
…3
```
```toml
[project.entry-points."some.thing"]
three = "a:three"
```
"""
    assert outcome(page) == []


GRAPH = '"nodes": {"plate": {"type": "read@1"}, "out": {"type": "write@1", "inputs": {"image": "%s"}}}'


@needs_bash
@pytest.mark.parametrize(
    ("page", "said"),
    [
        ("```sh\nfalse\ntrue\n```", "exit code 1"),
        ("```sh\nfalse | true\n```", "exit code 1"),
        ("```sh\ncat plate.exr\n```", "No such file"),
        ("```python\na = 1\n```\n```python\na / 0\n```", 'page.md:4", line 1'),
        ("```python\nraise ValueError('no')\n```", "ValueError: no"),
        ("```python\n1 +\n```", "SyntaxError"),
        ("```python\nprint(1)\n```\n```text\n2\n```", "expected what the block above prints:\n1"),
        ("```text\n2\n```", "(nothing)"),
        ("```toml\na = \n```", "TOMLDecodeError"),
        ('```toml\n[project.entry-points.a]\nb = "json:nothing"\n```', "AttributeError"),
        ('```json\n{"a": 1}\n```', "is no whole graph"),
        (f'```json\n{{"format": "flowabs.graph/1", {GRAPH % "plaet"}}}\n```', "unknown-node"),
        (
            f'`a.json`\n<!-- saved as a.json -->\n```json\n{{"format": "flowabs.graph/1", {GRAPH % "plate"}}}\n```\n'
            '`a.json`\n<!-- added to a.json -->\n```json\n"out": {"type": "wriet@1"}\n```',
            "unknown-type",
        ),
    ],
)
def test_what_is_not_true_fails(outcome, page, said):
    (failure,) = outcome(page)
    assert said in failure


@needs_bash
def test_a_page_gets_what_its_words_name(outcome):
    assert outcome("With a plate `plate.exr`:\n```sh\ntest -f plate.exr\n```\n") == []
    assert len(outcome("```sh\ntest -f shot.1001.exr\n```\n")) == 1


def test_dots_stand_for_anything():
    assert matches("done in … s\n", "done in 1.25 s   \n\n")
    assert matches("a\n…\nc", "a\nb\nb\nc")
    assert not matches("a\n…\nc", "a\nb\nb\nd")
    assert not matches("1.5", "1x5")
