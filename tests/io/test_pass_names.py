"""Usual names are compared plainly; Blender's old names and its new ones are the same."""

from __future__ import annotations

import pytest

from flowabs_nodes.io.pass_names import plain_name, same_pass


@pytest.mark.parametrize(
    ("layer", "plain"),
    [
        ("ViewLayer.Depth", "depth"),
        ("A view.Object Index", "objectindex"),
        ("VRayZDepth", "zdepth"),
        ("Z Depth", "zdepth"),
        ("crypto_object00", "cryptoobject00"),
        ("N", "n"),
        ("VRay", "vray"),
    ],
)
def test_plain_names(layer: str, plain: str) -> None:
    assert plain_name(layer) == plain


@pytest.mark.parametrize(
    ("layer", "asked", "same"),
    [
        ("Fg.Diffuse Color", "DiffCol", True),
        ("Fg.DiffCol", "diffuse_color", True),
        ("Fg.DiffCol", "Fg.Diffuse Color", True),
        ("Bg.01.IndexOB", "Bg.01.Object Index", True),
        ("Fg.AO", "Ambient Occlusion", True),
        ("Fg.DiffCol", "Bg.Diffuse Color", False),
        ("Fg.GlossCol", "Diffuse Color", False),
        ("Fg.Transmission Color", "TransCol", True),
    ],
)
def test_a_pass_by_its_old_and_its_new_name(layer: str, asked: str, same: bool) -> None:
    assert same_pass(layer, asked) == same
