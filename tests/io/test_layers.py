"""A channel's layer is what stands before its last dot."""

from __future__ import annotations

from flowabs_nodes.io.layers import layer_of


def test_layer_of() -> None:
    assert [layer_of(name) for name in ("diffuse.R", "a.b.R", "Z", "R", "A")] == ["diffuse", "a.b", "Z", "", ""]
