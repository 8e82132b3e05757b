"""Writes what hands a run to a render farm."""
