"""Operators on one node: what is wrong with it, further layers of ``write``, links that a file had to nowhere."""

from __future__ import annotations

import bpy

from flowabs_nodes.graph.links import taken_names

from .identifiers import graph_nodes
from .knobs import is_ours
from .names import clean, unique
from .node_classes import declaration_of
from .node_record import read_record, write_record
from .sockets import add_socket, socket_of


def shown_tree(context: bpy.types.Context) -> bpy.types.NodeTree | None:
    """Return the flowabs graph in the editor that an operator was called from, or else the scene's; None without."""
    tree = getattr(context.space_data, "edit_tree", None) if context.space_data is not None else None
    return tree if is_ours(tree) else getattr(context.scene, "flowabs_tree", None)


class OfTree:
    """Lets an operator be called where there is a flowabs graph; mixed into the operators."""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Return whether there is a graph to work on."""
        return shown_tree(context) is not None


class FLOWABS_OT_explain_problem(bpy.types.Operator):
    """Says what is wrong"""

    bl_idname = "flowabs.explain_problem"
    bl_label = "What is wrong"
    bl_options = {"INTERNAL"}

    text: bpy.props.StringProperty()

    @classmethod
    def description(cls, context: bpy.types.Context, properties: bpy.types.OperatorProperties) -> str:
        """Return the tooltip: the whole problem."""
        return properties.text

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Put the whole problem into the report area, where it can be copied."""
        self.report({"WARNING"}, self.text)
        return {"FINISHED"}


class FLOWABS_OT_add_layer(OfTree, bpy.types.Operator):
    """Add an input for a further layer of the file, named as the layer"""

    bl_idname = "flowabs.add_layer"
    bl_label = "Add layer"
    bl_options = {"REGISTER", "UNDO"}

    node: bpy.props.StringProperty(options={"HIDDEN"})
    layer: bpy.props.StringProperty(name="Layer", default="layer")

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Add the input."""
        tree = shown_tree(context)
        node = tree.nodes.get(self.node) if tree is not None else None
        declaration = declaration_of(node) if node is not None else None
        if declaration is None or declaration.extra_inputs is None:
            self.report({"ERROR"}, f"{self.node!r} takes no further layers")
            return {"CANCELLED"}
        taken = [*taken_names(declaration), *(socket.port for socket in node.inputs)]
        add_socket(node.inputs, unique(clean(self.layer, "layer"), taken), declaration.extra_inputs, extra=True)
        tree.update()
        return {"FINISHED"}


class FLOWABS_OT_remove_layer(OfTree, bpy.types.Operator):
    """Take the input of this layer away"""

    bl_idname = "flowabs.remove_layer"
    bl_label = "Remove layer"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    node: bpy.props.StringProperty(options={"HIDDEN"})
    layer: bpy.props.StringProperty(options={"HIDDEN"})

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Remove the input and its link."""
        tree = shown_tree(context)
        node = tree.nodes.get(self.node) if tree is not None else None
        socket = socket_of(node.inputs, self.layer) if node is not None else None
        if socket is None or not socket.is_extra:
            self.report({"ERROR"}, f"no layer {self.layer!r} to remove")
            return {"CANCELLED"}
        node.inputs.remove(socket)
        tree.update()
        return {"FINISHED"}


class FLOWABS_OT_forget_unknown(OfTree, bpy.types.Operator):
    """Drop what the graph file says and this flowabs does not know: links to nowhere, unknown parameters"""

    bl_idname = "flowabs.forget_unknown"
    bl_label = "Drop what is unknown"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Drop it from the selected nodes."""
        tree = shown_tree(context)
        changed = 0
        for node in graph_nodes(tree) if tree is not None else ():
            declaration = declaration_of(node)
            if declaration is None or not node.select:
                continue
            record = read_record(node)
            kept = record.pop("kept", None)
            params = record.get("body", {}).get("params", {})
            unknown = [name for name in params if name not in declaration.all_params]
            for name in unknown:
                del params[name]
            if kept or unknown:
                write_record(node, record)
                changed += 1
        self.report({"INFO"}, f"{changed} nodes changed")
        tree.update()
        return {"FINISHED"}


class FLOWABS_OT_use_in_scene(bpy.types.Operator):
    """Make this the scene's graph: its keyframes then move its sliders"""

    bl_idname = "flowabs.use_in_scene"
    bl_label = "Use in this scene"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Return whether the editor shows a graph."""
        return is_ours(getattr(context.space_data, "edit_tree", None))

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Point the scene at the graph."""
        context.scene.flowabs_tree = context.space_data.edit_tree
        return {"FINISHED"}


CLASSES = (
    FLOWABS_OT_use_in_scene,
    FLOWABS_OT_explain_problem,
    FLOWABS_OT_add_layer,
    FLOWABS_OT_remove_layer,
    FLOWABS_OT_forget_unknown,
)
