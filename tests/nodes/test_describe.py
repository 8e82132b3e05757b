"""Terminal, documentation and schema say the same, because one declaration says it."""

from pathlib import Path

import pytest

from flowabs_nodes import reference
from flowabs_nodes.graph.schema import schema
from flowabs_nodes.nodes import describe
from flowabs_nodes.nodes.registry import builtin
from tests.graph.fakes import CATALOGUE

NODES = builtin()
DOCS = Path(__file__).resolve().parents[2] / "docs"


def squeezed(text):
    return " ".join(text.split())


def test_a_page():
    assert describe.page(CATALOGUE["flow"]).splitlines()[:17] == [
        "flow@1",
        "",
        "  Finds a flow.",
        "",
        "Inputs",
        "  image  color  A picture.",
        "",
        "Outputs",
        "  flow  flow  The flow.",
        "",
        "Parameters",
        "  radius: a number from 0 to 100 (px), usually 2 to 15; default 5.0",
        "      Radius.",
        "  iterations: a whole number from 0 to 10, usually 1 to 5; default 3",
        "      Passes.",
        "  kernel: one of 'full', 'separable'; default \"full\"",
        "      Kernel.",
    ]


def test_what_the_engine_adds_is_on_the_page():
    page = describe.page(CATALOGUE["blur"])
    assert "mask" in page
    assert "mix: a number from 0 to 1" in page
    assert "image as image The same kind, blurred." in squeezed(page)


def test_special_cases_are_said():
    page = squeezed(describe.page(CATALOGUE["write"]))
    assert "(any name) any, optional A layer." in page
    assert "file: a file name or sequence pattern; set by the graph or the run" in page
    assert "amount: a number from 0; required" in squeezed(describe.page(CATALOGUE["needy"]))
    assert "lines matte, default" in squeezed(describe.page(CATALOGUE["lines"]))


def test_the_listing_has_a_line_for_each():
    assert len(describe.listing(NODES).splitlines()) == len(NODES)


@pytest.mark.parametrize("node", NODES, ids=lambda node: node.type)
def test_page_documentation_and_schema_agree(node):
    page, markdown = squeezed(describe.page(node)), describe.reference([node])
    in_schema = schema({node.type: node})["$defs"][f"node.{node.type}"]["properties"]["params"]["properties"]
    assert in_schema.keys() == node.all_params.keys()
    for name, param in node.all_params.items():
        assert squeezed(param.help) in page
        assert param.help.replace("|", "\\|") in markdown
        assert in_schema[name]["description"] == param.help
        assert squeezed(f"{name}: {describe.rule(param)}; {describe.default(param)}") in page
        assert describe.rule(param).replace("|", "\\|") in markdown
        if not param.required:
            default = param.default
            assert in_schema[name]["default"] == (list(default) if isinstance(default, tuple) else default)
        if param.numeric:
            literal = in_schema[name]["anyOf"][0]
            assert literal.get("exclusiveMinimum" if param.above else "minimum") == param.min
            assert literal.get("maximum") == param.max
        if param.kind == "enum":
            assert in_schema[name]["anyOf"][0]["enum"] == list(param.choices)
        assert in_schema[name].get("x-unit", "") == param.unit


def test_every_part_of_every_node_is_documented():
    for node in NODES:
        assert node.help.endswith(".")
        for port in (*node.inputs, *node.outputs):
            assert port.help.endswith("."), (node.type, port.name)
        for param in node.params:
            assert param.help.endswith("."), (node.type, param.name)


def test_the_documentation_is_up_to_date():
    for name, content in reference.files().items():
        assert (DOCS / name).read_text(encoding="utf-8") == content, "run python -m flowabs_nodes.reference"


def test_the_reference_is_written_where_it_is_asked_for(tmp_path):
    reference.main(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["graph.schema.json", "nodes.md"]
