"""Lists the nodes in the editor's Add menu, by category; Blender's own search in the menu finds them too."""

from __future__ import annotations

from typing import Any

import bpy

from flowabs_nodes.choices import CATEGORIES, readable
from flowabs_nodes.nodes import catalogue
from flowabs_nodes.nodes.declare import Node

from .identifiers import TREE, node_id

_menus: list[type] = []  # registered


def by_category() -> dict[str, list[Node]]:
    """Return the installed nodes by category: those of flowabs in its order, then those of other packages."""
    found: dict[str, list[Node]] = {category: [] for category in CATEGORIES}
    for declaration in catalogue().values():
        found.setdefault(declaration.category, []).append(declaration)
    return {category: nodes for category, nodes in found.items() if nodes}


def _menu_id(category: str) -> str:
    letters = "".join(letter if letter.isalnum() and letter.isascii() else "_" for letter in category)
    return f"FLOWABS_MT_add_{letters.lower()}"[:63]


def _menu_class(category: str, nodes: list[Node]) -> type:
    def draw(self: Any, context: bpy.types.Context) -> None:
        for declaration in nodes:
            add_item(self.layout, node_id(declaration.type), declaration.label)

    label = CATEGORIES.label.get(category, readable(category))
    content = {"bl_idname": _menu_id(category), "bl_label": label, "__doc__": CATEGORIES.meaning.get(category, label)}
    return type(_menu_id(category), (bpy.types.Menu,), {**content, "draw": draw})


def add_item(layout: Any, class_name: str, label: str) -> None:
    """Draw the menu item that adds a node and lets it follow the mouse."""
    button = layout.operator("node.add_node", text=label)
    button.type, button.use_transform = class_name, True


def draw_add(self: Any, context: bpy.types.Context) -> None:
    """Draw the categories; appended to the editor's Add menu."""
    if getattr(context.space_data, "tree_type", "") != TREE:
        return
    self.layout.operator_context = "INVOKE_REGION_WIN"
    for menu in _menus:
        self.layout.menu(menu.bl_idname)
    self.layout.separator()
    add_item(self.layout, "NodeFrame", "Frame")
    add_item(self.layout, "NodeReroute", "Reroute")


def register() -> None:
    """Register the menus and put them into the Add menu."""
    for category, nodes in by_category().items():
        _menus.append(_menu_class(category, nodes))
        bpy.utils.register_class(_menus[-1])
    bpy.types.NODE_MT_add.append(draw_add)


def unregister() -> None:
    """Take them out again."""
    bpy.types.NODE_MT_add.remove(draw_add)
    while _menus:
        bpy.utils.unregister_class(_menus.pop())
