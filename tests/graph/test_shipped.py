import json
import re
from pathlib import Path

import numpy as np
import pytest

import flowabs_nodes
from flowabs_nodes import Image, graph, load_graph
from flowabs_nodes.errors import CommandError
from flowabs_nodes.graph import shipped
from flowabs_nodes.graph.shipped import paper, resolve

ROOT = Path(__file__).resolve().parents[2]
NAMES = {"lines", "flat", "abstraction", "abstraction_hdr", "portrait", "inked", "flow"}


def test_the_graphs_that_come_with_it():
    assert set(graph.shipped()) >= NAMES


@pytest.mark.parametrize("name", sorted(graph.shipped()))
def test_each_is_valid_and_described(name):
    assert graph.check(name) == []
    loaded = graph.load(name)
    assert loaded.name == name
    assert loaded.description.endswith(".")
    assert all(knob.help.endswith(".") for knob in loaded.interface.values())
    for knob in loaded.interface.values():
        for end in (knob.min, knob.max):
            assert end is None or graph.override(loaded, {knob.name: end}).values(1)


def test_inside_an_installed_package_the_folder_is_its_own(tmp_path, monkeypatch):
    package = tmp_path / "flowabs_nodes"
    (package / "graphs").mkdir(parents=True)
    (package / "graphs" / "mine.json").write_text("{}")
    (tmp_path / "graphs").mkdir()
    monkeypatch.setattr(flowabs_nodes, "__file__", str(package / "__init__.py"))
    assert shipped() == {"mine": package / "graphs" / "mine.json"}


def test_another_package_named_graphs_is_not_taken_for_ours(tmp_path, monkeypatch):
    (tmp_path / "graphs").mkdir()
    (tmp_path / "graphs" / "theirs.json").write_text("{}")
    monkeypatch.setattr(flowabs_nodes, "__file__", str(tmp_path / "flowabs_nodes" / "__init__.py"))
    assert shipped() == {}


def test_what_a_name_means(tmp_path, monkeypatch):
    assert resolve("lines") == graph.shipped()["lines"]
    assert resolve("./lines") == Path("lines")
    assert resolve("lines.json") == Path("lines.json")
    with pytest.raises(CommandError) as caught:
        resolve("abstracton")
    assert "abstraction" in caught.value.hint
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine").write_text("{}")
    with pytest.raises(CommandError) as caught:
        resolve("mine")
    assert "./mine" in caught.value.hint


def test_figures_of_the_paper_have_names_too_and_are_listed_apart():
    assert resolve("fig07") == paper()["fig07"]
    assert paper()["fig07"].parent == graph.shipped()["lines"].parent / "paper"
    assert not set(paper()) & set(graph.shipped())
    with pytest.raises(CommandError) as caught:
        resolve("fig077")
    assert "fig07" in caught.value.hint


def test_the_graph_in_the_documentation_is_valid():
    text = (ROOT / "docs" / "graph-file.md").read_text(encoding="utf-8")
    example = re.search(r"```json\n(.*?)```", text, re.DOTALL)
    assert example
    assert graph.check(json.loads(example[1])) == []


def test_every_code_is_in_the_documentation():
    text = (ROOT / "docs" / "graph-file.md").read_text(encoding="utf-8")
    from flowabs_nodes.graph.problems import CODES

    assert [code for code in CODES if f"`{code}`" not in text] == []


@pytest.mark.parametrize("sigma", [0.005, 0.01, 0.02])
@pytest.mark.parametrize("name", ["abstraction", "abstraction_hdr", "flat", "inked", "portrait"])
def test_noise_in_blacks_stays_in_blacks(name, sigma):
    """Read noise about a black level, at the size that the graphs' lengths are meant for."""
    noise = np.random.default_rng(1).normal(0.002, sigma, (540, 160, 3)).astype(np.float32)
    output = "flat" if name == "flat" else "comp"
    pixels = load_graph(name).run(1, given={"plate": Image.from_array(noise)}, outputs=[output])[output].pixels
    assert pixels.max() < 1.5 * noise.max()
    assert pixels.min() > 1.5 * noise.min()


@pytest.mark.parametrize(("name", "right"), [("fig1", "fig01"), ("Fig7", "fig07"), ("LINES", "lines")])
def test_a_graph_is_found_case_and_zeros_aside(name, right):
    with pytest.raises(CommandError) as caught:
        resolve(name)
    assert caught.value.hint == f"did you mean {right!r}?"
