"""Operators that read graph files into node trees, among them the graphs that come with flowabs, and write them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import bpy
from bpy_extras.io_utils import ExportHelper, ImportHelper

from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.graph import GraphError, shipped
from flowabs_nodes.graph.problems import Problems
from flowabs_nodes.graph.safe_json import MOST_BYTES, parse
from flowabs_nodes.graph.shipped import paper
from flowabs_nodes.io.formats import check_kind

from . import problems
from .identifiers import TREE
from .node_operators import OfTree, shown_tree
from .revive import revive
from .tree_json import fill, graph_of, readable

JSON_FILES: dict[str, Any] = {"default": "*.json", "options": {"HIDDEN"}}


def read_graph(file: Path) -> dict[str, Any]:
    """Return the document of a graph file. Raises FlowabsError where it is none, or OSError where it cannot be read."""
    check_kind(file)
    with file.open("rb") as opened:
        content = opened.read(MOST_BYTES + 1)
    found = Problems()
    document = parse(content, found)
    if found.found:
        raise GraphError(found.found, file=str(file))
    return document


def graph_text(document: dict[str, Any]) -> str:
    """Return a graph as the text of a file."""
    return json.dumps(document, indent=2, ensure_ascii=False) + "\n"


def write_graph(document: dict[str, Any], file: Path) -> None:
    """Write a graph file: whole, or not at all. Raises OSError, or FlowabsError where a text has no UTF-8."""
    try:
        content = graph_text(document).encode("utf-8")
    except UnicodeEncodeError as error:
        text = error.object[max(0, error.start - 30) : error.end + 30]
        raise FlowabsError(f"a name or path of the graph cannot be written in UTF-8: {text!r}") from None
    unfinished = file.with_name(f".{file.name}.tmp")
    try:
        unfinished.write_bytes(content)
        unfinished.replace(file)
    finally:
        unfinished.unlink(missing_ok=True)


def new_tree(document: dict[str, Any], name: str) -> tuple[bpy.types.NodeTree, list[str]]:
    """Make a tree of a graph; return it, and what was done to bring older nodes up to date. Raises as ``fill``."""
    readable(document)  # raises before there is a tree
    tree = bpy.data.node_groups.new(name, TREE)
    return tree, fill(tree, document)


def show(context: bpy.types.Context, tree: bpy.types.NodeTree) -> None:
    """Show a tree in the editor that an operator was called from; make it the scene's where the scene has none."""
    space = context.space_data
    if space is not None and space.type == "NODE_EDITOR":
        space.tree_type = TREE
        space.node_tree = tree
    if context.scene.flowabs_tree is None:
        context.scene.flowabs_tree = tree


def _opened(operator: bpy.types.Operator, context: bpy.types.Context, file: Path) -> set[str]:
    """Make a tree of a graph file and say how that went, in the report area."""
    try:
        tree, notes = new_tree(read_graph(file), file.stem)
    except FlowabsError as error:
        operator.report({"ERROR"}, f"{file}: {error.message}")
        return {"CANCELLED"}
    except OSError as error:
        operator.report({"ERROR"}, f"{file}: {error.strerror or error}")
        return {"CANCELLED"}
    show(context, tree)
    for note in notes:
        operator.report({"INFO"}, note)
    _report(operator, tree, "imported")
    return {"FINISHED"}


def _report(operator: bpy.types.Operator, tree: bpy.types.NodeTree, done: str) -> None:
    """Say what is wrong with a graph that was imported or exported all the same."""
    found = problems.refresh(tree)
    errors = [problem for problem in found if not problem.warning]
    for problem in errors[:5]:
        operator.report({"WARNING"}, str(problem))
    count = f", with {len(errors)} problem{'' if len(errors) == 1 else 's'}" if errors else ""
    operator.report({"WARNING" if errors else "INFO"}, f"{tree.name} {done}{count}")


class FLOWABS_OT_import_graph(bpy.types.Operator, ImportHelper):
    """Make a node tree of a graph file"""

    bl_idname = "flowabs.import_graph"
    bl_label = "Import graph"
    bl_options = {"REGISTER", "UNDO"}

    filename_ext = ".json"
    filter_glob: bpy.props.StringProperty(**JSON_FILES)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Read the file."""
        return _opened(self, context, Path(bpy.path.abspath(self.filepath)))


class FLOWABS_OT_new_from_preset(bpy.types.Operator):
    """Make a node tree of a graph that comes with flowabs"""

    bl_idname = "flowabs.new_from_preset"
    bl_label = "New from preset"
    bl_options = {"REGISTER", "UNDO"}

    preset: bpy.props.StringProperty(name="Preset")

    @classmethod
    def description(cls, context: bpy.types.Context, properties: bpy.types.OperatorProperties) -> str:
        """Return the tooltip: what the graph says of itself."""
        file = presets().get(properties.preset)
        said = json.loads(file.read_text(encoding="utf-8")).get("description") if file is not None else None
        return said or cls.__doc__ or ""

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Read the graph."""
        file = presets().get(self.preset)
        if file is None:
            self.report({"ERROR"}, f"no graph {self.preset!r} comes with flowabs; there are: {', '.join(presets())}")
            return {"CANCELLED"}
        return _opened(self, context, file)


class FLOWABS_OT_export_graph(OfTree, bpy.types.Operator, ExportHelper):
    """Write the node tree to a graph file"""

    bl_idname = "flowabs.export_graph"
    bl_label = "Export graph"

    filename_ext = ".json"
    filter_glob: bpy.props.StringProperty(**JSON_FILES)
    tree: bpy.props.StringProperty(description="Name of the tree; empty: the one shown", options={"HIDDEN"})

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Return whether there is any graph."""
        return any(tree.bl_idname == TREE for tree in bpy.data.node_groups)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Write the file."""
        tree = bpy.data.node_groups.get(self.tree) if self.tree else shown_tree(context)
        if tree is None or tree.bl_idname != TREE:
            self.report({"ERROR"}, f"no flowabs graph {self.tree!r}" if self.tree else "no flowabs graph is shown here")
            return {"CANCELLED"}
        file = Path(bpy.path.abspath(self.filepath))
        try:
            write_graph(graph_of(tree), file)
        except FlowabsError as error:
            self.report({"ERROR"}, f"{file}: {error.message}")
            return {"CANCELLED"}
        except OSError as error:
            self.report({"ERROR"}, f"{file}: {error.strerror or error}")
            return {"CANCELLED"}
        _report(self, tree, "exported")
        return {"FINISHED"}


class FLOWABS_OT_check(OfTree, bpy.types.Operator):
    """Look for everything that is wrong with the graph, and for nodes that have been installed since"""

    bl_idname = "flowabs.check"
    bl_label = "Check"

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Check the graph and say what is wrong."""
        tree = shown_tree(context)
        revived = revive(tree)
        if revived:
            self.report({"INFO"}, f"{revived} nodes are installed now, and are back")
        _report(self, tree, "checked")
        problems.mark_links(tree)
        return {"FINISHED"}


def presets() -> dict[str, Path]:
    """Return the files of the graphs that come with flowabs, those of the paper's figures too, by name."""
    return {**shipped(), **paper()}


CLASSES = (
    FLOWABS_OT_import_graph,
    FLOWABS_OT_new_from_preset,
    FLOWABS_OT_export_graph,
    FLOWABS_OT_check,
)
