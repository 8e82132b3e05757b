"""Terminal, documentation and schema say the same, because one declaration says it."""

from pathlib import Path

import pytest

from flowabs_nodes import reference
from flowabs_nodes.choices import CATEGORIES, Choices
from flowabs_nodes.graph.schema import schema
from flowabs_nodes.nodes import describe
from flowabs_nodes.nodes.declare import Node, Param, Port
from flowabs_nodes.nodes.regions import pixelwise
from flowabs_nodes.nodes.registry import builtin
from tests.graph.fakes import CATALOGUE

NODES = builtin()
DOCS = Path(__file__).resolve().parents[2] / "docs"


def squeezed(text):
    return " ".join(text.split())


def test_a_page():
    assert describe.page(CATALOGUE["flow"]).splitlines()[:19] == [
        "flow@1  Flow",
        "",
        "  Finds a flow.",
        "",
        "  In menus under Utility. It needs the whole picture.",
        "",
        "Inputs",
        "  image  color  A picture.",
        "",
        "Outputs",
        "  flow  flow  The flow.",
        "",
        "Parameters",
        "  radius: a number from 0 to 100 (px), usually 2 to 15; default 5.0",
        "      Radius: Radius.",
        "  iterations: a whole number from 0 to 10, usually 1 to 5; default 3",
        "      Iterations: Passes.",
        "  kernel: one of 'full', 'separable'; default \"full\"",
        "      Kernel: Kernel.",
    ]


FOG = Node(
    "fog",
    1,
    "Fogs.",
    (Port("image", "color", "In."),),
    (Port("image", "color", "Out."),),
    (
        Param.enum(
            "kind", "thin", Choices({"thin": "little", "low": "at the ground"}, {"low": "On the ground"}), help="?"
        ),
        Param.float(
            "height", 1.0, label="Height above ground", group="Ground", enabled_when={"kind": ("low",)}, help="."
        ),
        Param.int("seed", 1, animatable=False, help="A seed."),
        Param.float("floor", 0.0, group="Ground", help="The floor."),
    ),
    print,
    label="Fog and mist",
    category="weather",
    frames=lambda params: {"image": (-1, 0)},
    region=pixelwise("image"),
)


def test_what_panels_need_is_on_the_page():
    lines = describe.page(FOG).splitlines()
    assert lines[0] == "fog@1  Fog and mist"
    assert "  In menus under weather. It can work on a part of the picture, and reads other frames." in lines
    assert lines[lines.index("Parameters") :] == [
        "Parameters",
        "  kind: one of 'thin', 'low'; default \"thin\"",
        "      Kind: ?",
        "      thin: little",
        "      low (On the ground): at the ground",
        "  seed: a whole number; default 1",
        "      Seed: A seed.",
        "      The same on every frame.",
        "  mix: a number from 0 to 1, usually 0 to 1; default 1.0",
        "      Mix: How much of the result goes over the input.",
        "",
        "Parameters: Ground",
        "  height: a number; default 1.0",
        "      Height above ground: .",
        '      Ignored unless kind is "low".',
        "  floor: a number; default 0.0",
        "      Floor: The floor.",
    ]


def test_what_panels_need_is_in_documentation_and_schema():
    markdown = describe.reference([FOG])
    assert "| [`fog@1`](#fog1) | Fog and mist | weather | Fogs. |" in markdown
    assert "| **Ground** | | | | |\n| `height` | Height above ground | `1.0` | a number | . Ignored unless" in markdown
    assert "<br>low (On the ground): at the ground |" in markdown
    made = schema({"fog": FOG})["$defs"]["node.fog"]
    assert (made["title"], made["x-category"]) == ("Fog and mist", "weather")
    assert (made["x-region"], made["x-frames"]) == (True, True)
    params = made["properties"]["params"]["properties"]
    assert (params["height"]["title"], params["height"]["x-group"]) == ("Height above ground", "Ground")
    assert params["kind"]["anyOf"][0]["x-enum-titles"] == ["Thin", "On the ground"]
    assert params["kind"]["anyOf"][0]["enumDescriptions"] == ["little", "at the ground"]
    assert [params[name]["x-animatable"] for name in ("kind", "height", "seed")] == [False, True, False]
    assert [len(params[name]["anyOf"]) for name in ("kind", "height", "seed")] == [2, 3, 2]  # without and with a curve


def test_every_node_of_the_package_has_a_place_in_menus():
    for node in NODES:
        assert node.category in CATEGORIES, node.type
        assert not node.label.endswith(".")
    assert len({node.label for node in NODES}) == len(NODES)


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
        assert squeezed(f"{param.label}: {param.help}") in page
        assert param.label in markdown
        assert in_schema[name]["title"] == param.label
        assert in_schema[name].get("x-group", "") == param.group
        assert in_schema[name]["x-animatable"] == param.animatable == (len(in_schema[name]["anyOf"]) == 3)
        for said in (*describe.conditions(param), *describe.choices(param)):
            assert squeezed(said) in page
            assert said in markdown
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


def test_the_reference_is_written_where_it_is_asked_for(tmp_path, capsys):
    assert reference.main([str(tmp_path / "made")]) == 0
    assert sorted(path.name for path in (tmp_path / "made").iterdir()) == ["graph.schema.json", "nodes.md"]
    assert str(tmp_path / "made" / "nodes.md") in capsys.readouterr().out


def test_in_a_checkout_the_reference_goes_into_docs_and_elsewhere_into_the_current_folder(monkeypatch, tmp_path):
    assert reference.folder() == DOCS
    monkeypatch.setattr(reference, "__file__", str(tmp_path / "site-packages" / "flowabs_nodes" / "reference.py"))
    monkeypatch.chdir(tmp_path)
    assert reference.main([]) == 0
    assert (tmp_path / "nodes.md").read_text(encoding="utf-8") == reference.files()["nodes.md"]


def test_a_reference_that_cannot_be_written_is_said_in_a_line(tmp_path, capsys):
    (tmp_path / "file").touch()
    for arguments in ([str(tmp_path / "file")], [str(tmp_path / "file" / "in")], ["--help"], ["a", "b"]):
        assert reference.main(arguments) == 2
        assert len(capsys.readouterr().err.splitlines()) == 1
