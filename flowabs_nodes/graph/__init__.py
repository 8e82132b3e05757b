"""Reads the graph file: parsing, validation, schema, upgrade. A :class:`Graph` is valid; nothing here runs it."""

from flowabs_nodes.graph.load import check, load
from flowabs_nodes.graph.model import Graph, GraphNode, Knob, Link
from flowabs_nodes.graph.overrides import override, parse_setting
from flowabs_nodes.graph.problems import GraphError, Problem
from flowabs_nodes.graph.schema import schema
from flowabs_nodes.graph.shipped import shipped
from flowabs_nodes.graph.values import Curve, FromKnob, Literal, Value

__all__ = [
    "Curve",
    "FromKnob",
    "Graph",
    "GraphError",
    "GraphNode",
    "Knob",
    "Link",
    "Literal",
    "Problem",
    "Value",
    "check",
    "load",
    "override",
    "parse_setting",
    "schema",
    "shipped",
]
