"""Registers the extension in the bpy module that runs the tests, and gives each test an empty file."""

import json
import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import bpy  # Blender's module: python -m tools.blender
import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))
import flowabs_blender
from flowabs_blender import import_export, tree_json

STATUS = pytest.StashKey[int]()


def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    session.config.stash[STATUS] = int(exitstatus)


@pytest.hookimpl(trylast=True)
def pytest_unconfigure(config: pytest.Config) -> None:
    """End at once: Blender 4.5 as a module sometimes hangs while Python takes itself apart."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(config.stash.get(STATUS, 1))


@pytest.fixture(scope="session", autouse=True)
def extension() -> Iterator[None]:
    flowabs_blender.register()
    yield
    flowabs_blender.unregister()


@pytest.fixture(autouse=True)
def empty_file(extension: None) -> None:
    bpy.ops.wm.read_homefile(use_empty=True)


@pytest.fixture(autouse=True)
def no_errors_printed(capfd: pytest.CaptureFixture[str]) -> Iterator[None]:
    """Fail where Blender printed the traceback of a callback of ours: it tells nobody else of it."""
    yield
    said = "".join(capfd.readouterr())
    assert "Traceback" not in said, said


@pytest.fixture
def tree_of() -> Callable[[dict[str, Any]], Any]:
    """Return the function that makes a tree of a graph."""
    return lambda graph: import_export.new_tree(graph, "graph")[0]


@pytest.fixture
def after_round_trip(tree_of: Any) -> Callable[[dict[str, Any]], str]:
    """Return the function that takes a graph through a tree, twice, and returns its text.

    The text, not the dict, as 1 and 1.0, and the order of keys, are to stay.
    """

    def text(graph: dict[str, Any]) -> str:
        once = tree_json.graph_of(tree_of(graph))
        return json.dumps(tree_json.graph_of(tree_of(once)))

    return text
