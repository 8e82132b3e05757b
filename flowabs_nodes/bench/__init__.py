"""How fast the filters are on this machine: ``python -m flowabs_nodes.bench`` (docs/performance.md)."""
