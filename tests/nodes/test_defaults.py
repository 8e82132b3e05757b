"""A default stands in a declaration and in the signature of the function that does the work: both are the same."""

import inspect
import sys

import pytest

from flowabs_nodes import filters
from flowabs_nodes.io.output_image import build_picture
from flowabs_nodes.io.read import read_data, read_image
from flowabs_nodes.nodes.registry import builtin

NODES = {node.type: node for node in builtin()}

#: The functions that do the work of a node, where they are not the filter of the node's own name alone.
WORKERS = {
    "dog": (filters.dog, filters.threshold, filters.xdog),
    "fdog": (filters.fdog, filters.threshold, filters.xdog),
    "read": (read_image,),
    "read_aov": (read_data,),
    "write": (build_picture,),
}
#: They come from the run, or from inputs and parameters of other names.
NOT_PARAMETERS = {"alpha", "pens", "frame", "origin", "outputs", "view", "settings", "note", "warn", "layers"}
NOT_PARAMETERS |= {"before", "after", "guides", "depths", "normals", "alphas"}


def workers(type):
    """Return the functions that do the work of a node; of most the filter of its name, in filters/ or beside it."""
    beside = sys.modules[NODES[type].run.__module__]
    found = WORKERS.get(type, (getattr(filters, type, None) or getattr(beside, type, None),))
    return [function for function in found if function is not None]


def defaults(type):
    """Return the defaults of all functions that do the work of a node, by parameter; no inputs."""
    found = {}
    others = NOT_PARAMETERS | {port.name for port in NODES[type].inputs}
    for function in workers(type):
        for name, parameter in inspect.signature(function).parameters.items():
            if parameter.default is not inspect.Parameter.empty and name not in others:
                found.setdefault(name, parameter.default)
    return found


TYPES = [type for type in NODES if defaults(type)]


def test_most_nodes_are_looked_at():
    assert len(TYPES) >= 17


@pytest.mark.parametrize("type", TYPES)
def test_declaration_and_function_have_the_same_default(type):
    declared = {name: param.default for name, param in NODES[type].all_params.items()}
    written = {name: default for name, default in defaults(type).items() if name in declared}
    written.pop("metadata", None)  # the function has None in place of an empty dict
    assert written
    assert written == {name: declared[name] for name in written}


@pytest.mark.parametrize("type", TYPES)
def test_the_node_has_every_parameter_of_its_function(type):
    assert defaults(type).keys() - NODES[type].all_params.keys() == set()
