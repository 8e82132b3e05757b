"""A server for all tests of a file, and graphs on disk."""

import pytest

from flowabs_nodes.engine.runnable import load_graph
from flowabs_nodes.image import Image
from flowabs_nodes.serve.client import Client
from tests.serve import wire


@pytest.fixture(scope="module")
def client():
    """Return a client with a server of its own."""
    with Client() as client:
        yield client


@pytest.fixture
def graph(tmp_path):
    """Return the path of a graph with a knob ``stops``."""
    return wire.graph_file(tmp_path)


@pytest.fixture(scope="session")
def compiled():
    """Have the kernels of :data:`wire.SLOW` on disk: a server that compiles them says so, and ends later."""
    load_graph(wire.document(**wire.SLOW)).run(given={"plate": Image.from_array(wire.plate(4, 4))})


@pytest.fixture
def slow(tmp_path, compiled):
    """Return the path of a graph that is at work for minutes on :func:`wire.slow_plate`."""
    return wire.graph_file(tmp_path, "slow.json", **wire.SLOW)
