"""The ink that every shipped graph that draws lines writes beside its picture, to be put over any other."""

import numpy as np
import OpenImageIO as oiio
import pytest

import flowabs_nodes as fa
from flowabs_nodes import graph

INK = {
    "lines": {"ink": "comp.ink"},
    "abstraction": {"ink": "comp.ink"},
    "abstraction_hdr": {"ink": "comp.ink"},
    "portrait": {"ink": "comp.ink"},
    "inked": {"ink_bold": "drawn.ink", "ink_fine": "comp.ink"},
    "bold": {"ink_bold": "drawn.ink", "ink_fine": "comp.ink"},
    "pencil": {"ink": "comp.ink"},
    "steady_lines": {"ink": "comp.ink"},
    "steady_abstraction": {"ink": "comp.ink"},
    "toon": {"ink": "comp.ink"},
    "outline": {"ink": "pens.image"},
}

#: Graphs that draw a render's passes, on which this file's plate has none.
OF_RENDERS = ("toon", "outline")

#: Graphs without a knob for the opacity of ink, and how dense theirs is at least.
FULL = {"lines": 0.95, "pencil": 0.8, "steady_lines": 0.95}


def plate(alpha=False):
    """A disc before a ground, and in a soft matte if ``alpha``."""
    y, x = np.mgrid[:90, :120]
    rgb = np.where((np.hypot(x - 60, y - 45) < 25)[..., None], [0.9, 0.5, 0.3], [0.05, 0.1, 0.2])
    cover = np.clip(60 - np.hypot(x - 60, y - 45), 0, 1)[..., None] if alpha else np.ones((90, 120, 1))
    return np.concatenate([rgb * cover, cover], 2).astype(np.float32)


def test_every_graph_that_draws_lines_writes_its_ink():
    draw = {"fdog", "fdog_iterative", "dog", "ink_lines"}
    for name in graph.shipped():
        nodes = graph.load(name).nodes.values()
        if any(node.declaration.type in draw for node in nodes):
            (out,) = (node for node in nodes if node.declaration.type == "write")
            layers = {layer: str(link) for layer, link in out.inputs.items() if layer != "image"}
            assert layers == INK[name], name


@pytest.mark.parametrize("name", sorted(INK.keys() - set(OF_RENDERS)))
@pytest.mark.parametrize("alpha", [False, True])
def test_the_file_has_it_premultiplied(name, alpha, tmp_path):
    source, target = tmp_path / "plate.exr", tmp_path / "out.exr"
    picture = oiio.ImageBuf(np.ascontiguousarray(plate(alpha)))
    assert picture.write(str(source))
    settings = {} if name in FULL else {"ink_opacity": 0.5}
    pen = "drawn" if "ink_bold" in INK[name] else "comp"
    report = fa.run(name, input=str(source), output=str(target), set={f"{pen}.ink": [0.2, 0.1, 0], **settings})
    assert report.exit_code == 0
    written = oiio.ImageBuf(str(target))
    pixels = dict(zip(written.spec().channelnames, np.moveaxis(written.get_pixels(), 2, 0), strict=True))
    layer = next(iter(INK[name]))
    k = pixels[f"{layer}.A"]
    assert 0 <= k.min() < 0.01
    assert k.max() > FULL.get(name, 0.45)
    for channel, ink in zip("RGB", (0.2, 0.1, 0), strict=True):
        np.testing.assert_allclose(pixels[f"{layer}.{channel}"], ink * k, atol=1e-3)
    assert written.spec().channelnames[:3] == ("R", "G", "B")
    if name in ("lines", "steady_lines"):
        np.testing.assert_allclose(pixels["R"], 1 - k, atol=1e-3)  # white paper, as ever


@pytest.mark.parametrize("name", ["lines", "abstraction", "portrait"])
def test_over_a_plate_it_is_the_composite(name):
    image = fa.Image.from_array(plate()[..., :3], colorspace="lin_rec709")
    settings = {"comp.ink": [0.2, 0.1, 0]}
    found = fa.load_graph(name).run(given={"plate": image}, set=settings, outputs=["comp", "comp.ink", "lines"])
    below = image if name == "lines" else fa.load_graph(name).run(given={"plate": image}, outputs=["flat"])["flat"]
    ink = found["comp.ink"].pixels
    np.testing.assert_allclose(ink[..., :3] + below.pixels * (1 - ink[..., 3:]), found["comp"].pixels, atol=1e-5)


def test_the_drawing_itself_stays_black_on_white_without_alpha():
    image = fa.Image.from_array(plate(alpha=True), colorspace="lin_rec709")
    lines = fa.load_graph("lines").run(given={"plate": image}, outputs="lines")["lines"]
    assert lines.type == "matte"
    assert lines.pixels.shape == (90, 120, 1)
