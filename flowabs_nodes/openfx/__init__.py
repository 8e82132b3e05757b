"""The OpenFX plug-in: what it is built from, and what it tells a host of each graph (docs/openfx.md).

The plug-in itself is C, in ``plugins/openfx``; it asks :mod:`flowabs_nodes.serve` for pixels. Here its bundle is made.
"""
