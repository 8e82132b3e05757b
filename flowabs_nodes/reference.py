"""Writes what the documentation takes from the declarations: ``python -m flowabs_nodes.reference [FOLDER]``.

``nodes.md``, the node reference, and ``graph.schema.json``, the JSON Schema of the graph file, of the nodes that come
with the package (not of what else is installed). Without FOLDER they go into ``docs`` of the checkout that this package
is in, or, where it is installed, into the current folder. A test says when those of the checkout are old.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path

from flowabs_nodes.graph.schema import schema
from flowabs_nodes.nodes import describe
from flowabs_nodes.nodes.registry import builtin

INTRODUCTION = """\
# Node reference

Made from the declarations by `python -m flowabs_nodes.reference`; `flowabs nodes TYPE` shows the same for every node
that is installed. What the numbers mean, and what all nodes share, is in [the numbers](numbers.md).

"""


def files() -> dict[str, str]:
    """Return the content of each file, by name."""
    nodes = builtin()
    graph_schema = schema({node.type: node for node in nodes})
    return {
        "nodes.md": INTRODUCTION + describe.reference(nodes) + "\n",
        "graph.schema.json": json.dumps(graph_schema, indent=2, ensure_ascii=False) + "\n",
    }


def folder() -> Path:
    """Return ``docs`` of the checkout that this package is in; the current folder where it is in none."""
    project = Path(__file__).resolve().parent.parent
    return project / "docs" if (project / "pyproject.toml").is_file() else Path()


def main(arguments: Sequence[str]) -> int:
    """Write the files into the folder that ``arguments`` name, which is made, and return the process's exit code."""
    if len(arguments) > 1 or any(each.startswith("-") for each in arguments):
        print("usage: python -m flowabs_nodes.reference [FOLDER]", file=sys.stderr)
        return 2
    into = Path(arguments[0]) if arguments else folder()
    try:
        into.mkdir(parents=True, exist_ok=True)
        for name, content in files().items():
            (into / name).write_text(content, encoding="utf-8")
            print(into / name)
    except OSError as error:
        print(f"cannot write into {into}: {error.strerror}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
