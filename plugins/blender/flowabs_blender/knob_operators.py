"""Operators on the knobs of a graph: change what is said of one, take one away."""

from __future__ import annotations

import json

import bpy

from . import knobs
from .driving import stop_driving
from .names import clean, unique
from .node_classes import declaration_of
from .node_operators import OfTree, shown_tree
from .node_record import drive_in, read_record, write_record, written_params


class FLOWABS_OT_remove_knob(OfTree, bpy.types.Operator):
    """Take a knob away; what it drove stays where it is"""

    bl_idname = "flowabs.remove_knob"
    bl_label = "Remove knob"
    bl_options = {"REGISTER", "UNDO"}

    knob: bpy.props.StringProperty(options={"HIDDEN"})

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Remove the knob."""
        tree = shown_tree(context)
        if tree is None or self.knob not in tree.knobs:
            self.report({"ERROR"}, f"no knob {self.knob!r}")
            return {"CANCELLED"}
        for node in tree.nodes:
            declaration = declaration_of(node)
            for param in declaration.all_params.values() if declaration is not None else ():
                said = drive_in(written_params(read_record(node)).get(param.name))
                if said is not None and said["from"] == self.knob:
                    stop_driving(node, param)
        knobs.remove(tree, self.knob)
        tree.update()
        return {"FINISHED"}


class FLOWABS_OT_edit_knob(OfTree, bpy.types.Operator):
    """Change a knob's name, label, section, help and range"""

    bl_idname = "flowabs.edit_knob"
    bl_label = "Edit knob"
    bl_options = {"REGISTER", "UNDO"}

    knob: bpy.props.StringProperty(options={"HIDDEN"})
    name: bpy.props.StringProperty(name="Name", description="The knob's name in the graph file")
    label: bpy.props.StringProperty(name="Label")
    group: bpy.props.StringProperty(name="Section")
    help: bpy.props.StringProperty(name="Help")
    min: bpy.props.StringProperty(name="Minimum", description="A number; empty: none")
    max: bpy.props.StringProperty(name="Maximum", description="A number; empty: none")
    remove: bpy.props.BoolProperty(name="Remove this knob", description="What it drove stays where it is")

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask, with what stands there now."""
        knob = shown_tree(context).knobs.get(self.knob)
        if knob is None:
            return {"CANCELLED"}
        declared = knobs.declaration(knob)
        self.name, self.remove = knob.name, False
        for key in ("label", "group", "help", "min", "max"):
            setattr(self, key, str(declared.get(key, "")))
        return context.window_manager.invoke_props_dialog(self, width=380)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Change the knob, and its name in the parameters that it drives."""
        tree = shown_tree(context)
        knob = tree.knobs.get(self.knob) if tree is not None else None
        if knob is None:
            self.report({"ERROR"}, f"no knob {self.knob!r}")
            return {"CANCELLED"}
        if self.remove:
            return bpy.ops.flowabs.remove_knob(knob=self.knob)
        declared = knobs.interface_of(tree)[self.knob]
        numeric = declared.get("type") in ("float", "int")
        for key in ("label", "group", "help", *(("min", "max") if numeric else ())):
            text = getattr(self, key).strip()
            try:
                said = json.loads(text) if text and key in ("min", "max") else text
            except ValueError:
                self.report({"ERROR"}, f"{key} is {text!r}, expected a number")
                return {"CANCELLED"}
            declared.pop(key, None)
            if said != "":
                declared[key] = said
        name = clean(self.name, self.knob)
        if name != self.knob:
            name = unique(name, {each.name for each in tree.knobs})
        interface = {(name if key == self.knob else key): said for key, said in knobs.interface_of(tree).items()}
        interface[name] = declared
        knobs.fill(tree, interface)
        _rename_in_drives(tree, self.knob, name)
        tree.update()
        return {"FINISHED"}


def _rename_in_drives(tree: bpy.types.NodeTree, before: str, name: str) -> None:
    for node in tree.nodes:
        if declaration_of(node) is None or before == name:
            continue
        record = read_record(node)
        for said in written_params(record).values():
            if drive_in(said) is not None and said["from"] == before:
                said["from"] = name
        write_record(node, record)


CLASSES = (FLOWABS_OT_remove_knob, FLOWABS_OT_edit_knob)
