"""The comp of docs/comp.md: it runs, it does what the page says, and the page says what every node does."""

import json
from pathlib import Path

import numpy as np
import pytest

from flowabs_nodes import graph
from flowabs_nodes.engine import load_graph
from flowabs_nodes.image import Window
from flowabs_nodes.io.read import read_image
from flowabs_nodes.nodes.merge import MERGE
from tests.comp.pictures import run

DOCS = Path(__file__).resolve().parents[2] / "docs"
COMP = DOCS / "comp.json"
OUTPUTS = ["fine", "bold", "dark", "lines", "graded", "under", "comp", "comp.ink"]


@pytest.fixture(scope="module")
def images():
    plate = read_image(str(DOCS / "pictures" / "coffee.exr")).on_window(Window(160, 0, 280, 230))
    return load_graph(COMP).run(given={"plate": plate}, outputs=OUTPUTS)


def test_it_has_no_problem():
    assert graph.check(json.loads(COMP.read_text(encoding="utf-8"))) == []


def test_both_pens_draw_where_the_matte_is_and_the_bold_one_elsewhere(images):
    window = images["fine"].data_window  # an inverted matte reaches the display window
    fine, bold, dark = (images[name].on_window(window).pixels for name in ("fine", "bold", "dark"))
    assert images["lines"].type == "matte"
    expected = np.minimum(fine, bold) * dark + bold * (1 - dark)
    np.testing.assert_allclose(images["lines"].pixels, expected, atol=1e-6)
    assert (np.minimum(fine, bold) < bold - 0.5).any(), "the fine pen adds lines"
    assert 0.05 < dark.mean() < 0.95


def test_the_ink_layer_over_the_picture_below_is_the_comp(images):
    over = run(MERGE, {"A": images["comp.ink"], "B": images["under"]})
    np.testing.assert_allclose(over.pixels[..., :3], images["comp"].pixels, rtol=1e-5, atol=1e-6)


def test_on_paper_the_same_lines_lie(images):
    plate = read_image(str(DOCS / "pictures" / "coffee.exr")).on_window(Window(160, 0, 280, 230))
    paper = load_graph(COMP).run(given={"plate": plate}, outputs=["lines", "under"], set={"ground": 1})
    np.testing.assert_array_equal(paper["lines"].pixels, images["lines"].pixels)
    assert (paper["under"].pixels == paper["under"].pixels[0, 0]).all()


def test_the_page_names_every_node_of_the_graph():
    page = (DOCS / "comp.md").read_text(encoding="utf-8")
    nodes = json.loads(COMP.read_text(encoding="utf-8"))["nodes"]
    assert [name for name in nodes if f"`{name}`" not in page and name not in ("plate", "flow", "smooth")] == []
