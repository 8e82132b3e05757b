import re
import time
from pathlib import Path

import pytest

from flowabs_nodes import graph
from flowabs_nodes.graph.shipped import paper
from tools.gallery.__main__ import main
from tools.gallery.figures import FIGURES
from tools.gallery.inputs import DAMAGED, DRAWN, pictures
from tools.gallery.page import page
from tools.gallery.render import Rendered, render
from tools.gallery.texts import TEXTS

DOCS = Path(__file__).resolve().parents[3] / "docs"
BY_NAME = {figure.name: figure for figure in FIGURES}


def test_each_graph_of_the_paper_has_a_sheet_and_words():
    assert set(BY_NAME) == set(paper()) == set(TEXTS)
    assert all(text.claim.endswith(".") and text.see.endswith(".") for text in TEXTS.values())


@pytest.mark.parametrize("figure", FIGURES, ids=BY_NAME)
def test_figures_name_what_there_is(figure):
    values = graph.load(figure.name).values(1)
    nodes = graph.load(figure.name).nodes
    for row in figure.rows:
        assert row.picture in DRAWN or row.picture in DAMAGED or (pictures() / row.picture).is_file()
        for panel in row.panels:
            assert panel.output in nodes
            for key in (*panel.values, *re.findall(r"\{([\w.]+)\}", panel.title)):
                node, name = key.split(".")
                assert name in values[node]


def test_one_sheet_from_the_command_line(tmp_path, capsys):
    assert main(["--only", "fig08", "--out", str(tmp_path)]) == 0
    sheet = tmp_path / "fig08.jpg"
    assert str(sheet) in capsys.readouterr().out
    assert {file.name for file in (tmp_path / "inputs").iterdir()} == {"circle.exr", "x.exr", "t.exr"}
    assert not (tmp_path / "README.md").exists()
    files = [sheet, *(tmp_path / "inputs").iterdir()]
    before = [file.read_bytes() for file in files]
    time.sleep(1.1)  # a time in the header would have moved on
    assert main(["--only", "fig08", "--out", str(tmp_path)]) == 0
    assert [file.read_bytes() for file in files] == before


def test_captions_tell_the_values_of_the_graph_and_what_was_measured(tmp_path):
    captions = dict(render(BY_NAME["fig08"], tmp_path).captions)
    assert captions["(d) FDoG"] == "sigma_m 6, sigma_c 2, rho 0.99, tau 0.5; 1 piece of 2104 px"
    assert captions["(j) FDoG: third iteration"].startswith("pre_blur 1.5; 1 piece ")
    assert captions["(b) DoG"].endswith("28 pieces of 52 px")


def test_an_unknown_figure_is_a_wrong_command(tmp_path, capsys):
    assert main(["--only", "fig088", "--out", str(tmp_path)]) == 2
    assert "fig08" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_the_page_has_a_section_for_each_sheet():
    text = page(Rendered(figure, Path(f"{figure.name}.png"), (("(a) Input", ""),)) for figure in FIGURES)
    for figure in FIGURES:
        assert f"## {figure.title}\n\n![(a) Input]({figure.name}.png)" in text
        assert f"flowabs run {figure.name} -i docs/" in text


def test_what_the_page_links_to_is_there_and_small():
    text = (DOCS / "gallery" / "README.md").read_text(encoding="utf-8")
    targets = re.findall(r"\]\(([^)#]+)\)", text)
    images = [DOCS / "gallery" / target for target in targets if target.endswith((".png", ".jpg", ".svg"))]
    assert len(images) >= len(FIGURES)
    assert all((DOCS / "gallery" / target).exists() for target in targets)
    assert max(image.stat().st_size for image in images) < 250_000
    assert sum(file.stat().st_size for file in (DOCS / "gallery").rglob("*") if file.is_file()) < 5_000_000
    assert all((DOCS.parent / name).is_file() for name in re.findall(r"-i (\S+)", text))


def test_every_picture_has_a_source_and_a_licence():
    table = (DOCS / "pictures" / "README.md").read_text(encoding="utf-8")
    for file in (DOCS / "pictures").iterdir():
        assert file.name == "README.md" or f"| `{file.name}` |" in table
