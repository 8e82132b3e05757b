"""Builds nodes in a scene's compositor, which each version of Blender keeps in another place."""

from __future__ import annotations

from collections.abc import Mapping

import bpy


def tree_of(scene: bpy.types.Scene) -> bpy.types.NodeTree | None:
    """Return the nodes of a scene's compositor that is at work; None where there is none."""
    if hasattr(scene, "compositor_effects"):  # Blender 5.3
        effects = [effect for effect in scene.compositor_effects if effect.enable_for_render]
        return next((effect.node_group for effect in effects if effect.node_group is not None), None)
    if bpy.app.version < (5, 0):
        return scene.node_tree if scene.use_nodes else None
    return scene.compositing_node_group


def own_trees(scene: bpy.types.Scene) -> list[bpy.types.NodeTree]:
    """Return the node groups of a scene's compositor that stay when the scene is removed."""
    tree = tree_of(scene)
    return [tree] if tree is not None and not tree.is_embedded_data else []


def show_pictures(scene: bpy.types.Scene, pictures: Mapping[str, bpy.types.Image]) -> None:
    """Have a scene's compositor read each picture; the first goes to its output where nothing else does."""
    tree = tree_of(scene) or _new_tree(scene)
    output = _output(tree)
    for row, (name, picture) in enumerate(pictures.items()):
        node = next((each for each in tree.nodes if getattr(each, "image", None) == picture), None)
        if node is None:
            node = tree.nodes.new("CompositorNodeImage")
            node.image, node.label = picture, name
            node.location = (-400, -360 * row)
        if not output.is_linked:
            tree.links.new(node.outputs[0], output)


def keep_passes(scene: bpy.types.Scene) -> str:
    """Make a Render Layers node where a scene's compositor has none: without one, no passes come out.

    Returns the node's name; "" where none was needed.
    """
    tree = tree_of(scene)
    if tree is None or any(node.type == "R_LAYERS" and node.scene == scene for node in tree.nodes):
        return ""
    node = tree.nodes.new("CompositorNodeRLayers")
    node.scene, node.label = scene, "Keeps the passes for flowabs"
    node.location = (-400, 500)
    return node.name


def drop_node(scene: bpy.types.Scene, name: str) -> None:
    """Remove a node of :func:`keep_passes`, if it is still there and nobody links it."""
    tree = tree_of(scene)
    node = tree.nodes.get(name) if tree is not None else None
    if node is not None and not any(socket.is_linked for socket in node.outputs):
        tree.nodes.remove(node)


def _new_tree(scene: bpy.types.Scene) -> bpy.types.NodeTree:
    """Return a compositor with nothing but its output."""
    if bpy.app.version < (5, 0):
        scene.use_nodes = True
        scene.node_tree.nodes.clear()
        return scene.node_tree
    tree = bpy.data.node_groups.new(scene.name, "CompositorNodeTree")
    if hasattr(scene, "compositor_effects"):  # Blender 5.3
        scene.compositor_effects.new(scene.name).node_group = tree
    else:
        scene.compositing_node_group = tree
    return tree


def _output(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
    """Return the socket that takes the composite, with its node where that is missing."""
    kind = "CompositorNodeComposite" if tree.is_embedded_data else "NodeGroupOutput"
    node = next((each for each in tree.nodes if each.bl_idname == kind), None) or tree.nodes.new(kind)
    if kind == "NodeGroupOutput" and not any(each.in_out == "OUTPUT" for each in tree.interface.items_tree):
        tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
    return node.inputs[0]
