"""Declares the nodes, each beside others of its family, and collects the catalogue of all that are installed."""

from flowabs_nodes.nodes.registry import catalogue, load_problems

__all__ = ["catalogue", "load_problems"]
