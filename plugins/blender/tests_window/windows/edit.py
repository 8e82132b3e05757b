"""Makes a graph of a preset, looks at all that is drawn of it, adds a node, and undoes that."""

import json
from pathlib import Path
from typing import Any

import bpy
import steps


def play(told: dict[str, Any]) -> steps.Steps:
    from flowabs_blender import tree_json

    nodes, image = steps.open_editors("FlowabsTree", "IMAGE_EDITOR")
    yield 0.5
    with steps.within(nodes):
        bpy.ops.flowabs.new_from_preset(preset="abstraction")
    tree = nodes.spaces.active.node_tree
    for each in (nodes, image):
        each.spaces.active.show_region_ui = True
    yield 0.5
    with steps.within(nodes):
        bpy.ops.node.view_all()
        bpy.ops.wm.call_menu(name="NODE_MT_add")
    yield 0.5
    steps.press("ESC")
    yield 0.5
    for node in tree.nodes:  # the sidebar shows the active one
        tree.nodes.active = node
        nodes.tag_redraw()
        yield 0.1
    steps.screenshot(Path(steps.GIVEN["picture"]))
    before = json.dumps(tree_json.graph_of(tree))
    with steps.within(nodes):
        bpy.ops.ed.undo_push(message="before")
        bpy.ops.node.add_node(type="FlowabsNode_quantize")
        bpy.ops.ed.undo_push(message="after")
    yield 0.3
    told["added"] = [node.bl_idname for node in tree.nodes if node.bl_idname == "FlowabsNode_quantize"]
    with steps.within(nodes):
        bpy.ops.ed.undo()
    yield 0.3
    told["undone"] = json.dumps(tree_json.graph_of(bpy.data.node_groups["abstraction"])) == before


steps.play(play)
