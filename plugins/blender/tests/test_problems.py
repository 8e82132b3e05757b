"""What is wrong with a graph is said on the node concerned, and links that do not fit are marked."""

import json
from typing import Any

from flowabs_blender import problems, tree_json
from flowabs_blender.sockets import socket_of
from test_editing import node_of

from graphs import WIDTH, small, with_knobs


def said(tree: Any, name: str) -> list[str]:
    text = node_of(tree, name).problems
    return [problem["short"] for problem in json.loads(text)] if text else []


def test_nothing_is_wrong(tree_of: Any) -> None:
    tree = tree_of(small())
    assert not any(node.problems for node in tree.nodes)
    assert not tree.problems


def test_on_the_node_concerned(tree_of: Any) -> None:
    tree = tree_of(
        small(
            a={"type": "blur@1", "inputs": {"image": "nobody"}, "params": {"sigma": -1}},
            b={"type": "halftone@3", "inputs": {"image": "plate"}},
            c={"type": "etf@99", "inputs": {"image": "plate"}},
        )
    )
    assert said(tree, "a") == ["Sigma: -1, expected a number from 0 to 500 (px)", 'Image: there is no node "nobody"']
    assert said(tree, "b") == ['not installed: "halftone@3"']
    assert said(tree, "c") == ['newer than what is installed: "etf@99"']
    assert said(tree, "flow") == []


def test_it_goes_when_it_is_mended(tree_of: Any) -> None:
    tree = tree_of(small(lines={"type": "fdog@1", "inputs": {"image": "plate"}}))
    assert said(tree, "lines") == ["Flow is not linked"]
    tree.links.new(node_of(tree, "flow").outputs[0], socket_of(node_of(tree, "lines").inputs, "flow"))
    assert said(tree, "lines") == []


def test_it_comes_when_a_value_is_wrong(tree_of: Any) -> None:
    tree = tree_of(small())
    node_of(tree, "flow").p_gradient_reference = "most"
    assert len(said(tree, "flow")) == 1


def test_a_link_that_does_not_fit_is_marked(tree_of: Any) -> None:
    tree = tree_of(small(x={"type": "lic@1", "inputs": {"flow": "plate"}}))
    problems.mark_links(tree)
    assert [link.to_node.graph_name for link in tree.links if not link.is_valid] == ["x"]


def test_a_matte_goes_where_a_mono_or_a_colour_is_asked_for(tree_of: Any) -> None:
    tree = tree_of(
        small(x={"type": "blur@1", "inputs": {"image": "lines"}}, y={"type": "etf@1", "inputs": {"image": "x"}})
    )
    problems.mark_links(tree)
    assert all(link.is_valid for link in tree.links)


def test_an_output_has_the_colour_of_what_comes_out(tree_of: Any) -> None:
    tree = tree_of(
        small(
            x={"type": "blur@1", "inputs": {"image": "lines"}},
            y={"type": "merge@1", "inputs": {"B": "x", "A": "plate"}},
            z={"type": "crop@1", "inputs": {"image": "flow"}},
            alone={"type": "crop@1"},
        )
    )
    kinds = {name: node_of(tree, name).outputs[0].kind for name in ("x", "y", "z", "alone")}
    assert kinds == {"x": "matte", "y": "color", "z": "flow", "alone": "any"}


def test_of_the_graph_itself(tree_of: Any) -> None:
    tree = tree_of({**with_knobs(width={**WIDTH, "default": 9}), "later": 1})
    codes = [problem["code"] for problem in json.loads(tree.problems)]
    assert codes == ["unknown-key", "out-of-range"]


def test_a_circle_stops_nothing(tree_of: Any) -> None:
    tree = tree_of(
        small(a={"type": "blur@1", "inputs": {"image": "b"}}, b={"type": "blur@1", "inputs": {"image": "a"}})
    )
    assert "it needs its own result" in said(tree, "a") + said(tree, "b")
    assert problems.find(tree_json.graph_of(tree))
