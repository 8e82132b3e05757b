"""Graphs that are wrong in any way at all come out as they went in, or are refused whole."""

import copy
import json
import random
from typing import Any

import pytest
from flowabs_blender import import_export, tree_json

from flowabs_nodes.graph import GraphError

#: What takes the place of a part of a graph.
ATOMS = [
    None, True, 0, -1, 1, 3, 2.5, 1e-320, 1e308, 2**31, -(2**63), 10**40, "", "a", "plate", "lines.response", "x.y.z",
    "é\t\"'\\", "n" * 200, [], [1], [0.1, 0.2, 0.3], [[0, 1], [1, 2]], {}, {"from": "line_width"}, {"curve": {"1": 2}},
    {"from": "levels", "map": [[4, 1], [16, 3]]}, {"curve": {"5": 1, "1": 0.1}}, {"type": "etf@1"}, {"pos": [1.5, -2]},
]  # fmt: skip


def places(value: Any, place: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Return the keys that lead to every part of a document."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [place, *(found for key, item in items for found in places(item, (*place, key)))]


def mutated(graph: dict[str, Any], chance: random.Random) -> dict[str, Any]:
    """Return a graph in which a few parts are others, are gone, or have other names."""
    graph = copy.deepcopy(graph)
    for _ in range(chance.randint(1, 4)):
        *way, last = chance.choice(places(graph)[1:])
        owner = graph
        for key in way:
            owner = owner[key]
        what = chance.random()
        if what < 0.6 or isinstance(owner, list):
            owner[last] = copy.deepcopy(chance.choice(ATOMS))
        elif what < 0.8:
            del owner[last]
        else:
            new = chance.choice(["plate", "x", "x.001", "radius", "image", "é", "n" * 100, f"{last}_2"])
            items = [(new if key == last else key, item) for key, item in owner.items()]
            owner.clear()
            owner.update(items)
    return graph


@pytest.mark.parametrize("seed", range(60))
def test_a_mutated_graph(seed: int, after_round_trip: Any) -> None:
    chance = random.Random(seed)
    names = [*import_export.presets()]
    graph = mutated(json.loads(import_export.presets()[chance.choice(names)].read_text(encoding="utf-8")), chance)
    try:
        tree_json.readable(graph)
    except GraphError:
        return
    assert after_round_trip(graph) == json.dumps(graph)
