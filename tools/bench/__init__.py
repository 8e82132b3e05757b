"""Measure how fast the filters are on this machine: ``python -m tools.bench`` (docs/performance.md)."""
