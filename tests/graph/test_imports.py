"""Within ``graph/`` and within ``nodes/`` no file imports another that, in the end, imports it."""

import ast
from pathlib import Path

import pytest

import flowabs_nodes
from flowabs_nodes.graph.order import components

PACKAGE = Path(flowabs_nodes.__file__).parent


def imports(folder):
    """Return, for each module of a folder, the modules of the same folder it imports, for type checking included."""
    prefix = f"flowabs_nodes.{folder}."
    sources = {path.stem: path.read_text(encoding="utf-8") for path in (PACKAGE / folder).glob("*.py")}
    found = {}
    for module, source in sources.items():
        names = set()
        for node in ast.walk(ast.parse(source)):
            if isinstance(node, ast.Import):
                names.update(alias.name for alias in node.names)
            elif isinstance(node, ast.ImportFrom) and node.module:
                names.add(node.module)
                names.update(f"{node.module}.{alias.name}" for alias in node.names)
        inside = {name.removeprefix(prefix).partition(".")[0] for name in names if name.startswith(prefix)}
        found[module] = sorted(inside & sources.keys())
    return found


@pytest.mark.parametrize("folder", ["graph", "nodes"])
def test_there_is_no_circle_of_imports(folder):
    found = imports(folder)
    assert sum(map(len, found.values())) > 10
    assert [component for component in components(found) if len(component) > 1] == []
