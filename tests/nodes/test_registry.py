import subprocess
import sys
from importlib.metadata import EntryPoint

import pytest

from flowabs_nodes import nodes
from flowabs_nodes.nodes import registry

NODES = registry.builtin()
PLUGIN = """
from flowabs_nodes.nodes.declare import Node, Param, Port

def run(context, image, **params):
    return image

def node(type, inputs="color", output="=image", default=1.0):
    return Node(type, 1, "Help.", (Port("image", inputs, "In."),), (Port("image", output, "Out."),),
                (Param.float("amount", default, min=0, max=10, help="How much."),), run)

ONE = node("plugin_one")
SEVERAL = [node("plugin_two"), node("plugin_three")]
CLASH = node("etf")
SAME = node("plugin_one")
TWICE = [node("plugin_four"), node("plugin_four")]
NOT_A_NODE = "a text"
NOT_NODES = [node("plugin_four"), 5]
NUMBER = 5
BAD_INPUT = node("bad_input", inputs="colour")
BAD_OUTPUT = node("bad_output", output="=picture")
BAD_DEFAULT = node("bad_default", default=11.0)
"""


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """Pretend that entry points are installed: installed(one="ONE") for a module that has the nodes above."""
    (tmp_path / "plugin_for_tests.py").write_text(PLUGIN, encoding="utf-8")
    (tmp_path / "broken_for_tests.py").write_text("raise RuntimeError('no luck')", encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)

    def install(**points):
        values = {name: value if ":" in value else f"plugin_for_tests:{value}" for name, value in points.items()}
        found = [EntryPoint(name, value, registry.GROUP) for name, value in values.items()]
        monkeypatch.setattr(registry, "entry_points", lambda group: found)
        registry._load.cache_clear()

    yield install
    registry._load.cache_clear()


def test_the_nodes_of_the_package_come_first_and_in_their_order():
    assert list(nodes.catalogue().values())[: len(NODES)] == list(NODES)
    assert all(type == node.type for type, node in nodes.catalogue().items())
    assert tuple(node.type for node in NODES if node.type in registry.READING_ORDER) == registry.READING_ORDER
    assert [fault for node in NODES for fault in registry.faults(node)] == []


def test_an_entry_point_adds_a_node_or_several(installed):
    installed(one="ONE", several="SEVERAL")
    assert list(nodes.catalogue())[len(NODES) :] == ["plugin_one", "plugin_two", "plugin_three"]
    assert nodes.load_problems() == {}


@pytest.mark.parametrize(
    ("value", "why"),
    [
        ("CLASH", "'etf' is already a node of flowabs-nodes"),
        ("TWICE", "two nodes of one type"),
        ("NOTHING", "AttributeError"),
        ("NOT_A_NODE", "not a Node"),
        ("NOT_NODES", "not a Node"),
        ("NUMBER", "not a Node"),
        ("no_such_module:NODE", "ModuleNotFoundError"),
        ("broken_for_tests:NODE", "RuntimeError: no luck"),
        ("BAD_INPUT", "input 'image' of type 'colour'; did you mean 'color'?"),
        ("BAD_OUTPUT", "'picture', which is no input"),
        ("BAD_DEFAULT", "default of 'amount', 11.0"),
    ],
)
def test_what_cannot_be_loaded_is_left_out_and_reported(installed, value, why):
    installed(bad=value, good="ONE")
    assert list(nodes.catalogue())[len(NODES) :] == ["plugin_one"]
    assert nodes.catalogue()["etf"] is next(node for node in NODES if node.type == "etf")
    ((where, found),) = nodes.load_problems().items()
    assert where.endswith(": bad")
    assert why in found


def test_of_two_packages_with_the_same_type_the_first_by_name_stays(installed):
    installed(b="SAME", a="ONE")
    assert "plugin_one" in nodes.catalogue()
    assert list(nodes.load_problems()) == ["plugin_for_tests: b"]


def test_the_catalogue_is_a_copy():
    nodes.catalogue().clear()
    assert nodes.catalogue()


def test_the_catalogue_needs_no_kernels():
    code = "import sys, flowabs_nodes.nodes as n; n.catalogue(); print({'numba', 'colour'} & set(sys.modules))"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "set()"


@pytest.mark.parametrize(
    "statement", ["import sys; sys.exit(0)", "raise SystemExit", "raise BaseException('no')", "raise GeneratorExit"]
)
def test_a_package_that_ends_the_process_when_it_is_imported_is_left_out(installed, tmp_path, statement):
    (tmp_path / "ending_for_tests.py").write_text(statement, encoding="utf-8")
    sys.modules.pop("ending_for_tests", None)
    installed(bad="ending_for_tests:NODE", good="ONE")
    assert "plugin_one" in nodes.catalogue()
    assert list(nodes.load_problems()) == ["ending_for_tests: bad"]


def test_ctrl_c_while_a_package_is_imported_is_not_held_back(installed, tmp_path):
    (tmp_path / "interrupted_for_tests.py").write_text("raise KeyboardInterrupt", encoding="utf-8")
    installed(bad="interrupted_for_tests:NODE")
    with pytest.raises(KeyboardInterrupt):
        nodes.catalogue()
