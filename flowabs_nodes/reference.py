"""Writes what the documentation takes from the declarations: ``python -m flowabs_nodes.reference [FOLDER]``.

``nodes.md``, the node reference, and ``graph.schema.json``, the JSON Schema of the graph file, of the nodes that come
with the package (not of what else is installed). A test says when they are old.
"""

from __future__ import annotations

import json
import sys
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


def main(folder: Path) -> None:
    """Write the files into ``folder``."""
    for name, content in files().items():
        (folder / name).write_text(content, encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parent.parent / "docs")
