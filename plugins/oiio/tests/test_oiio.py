"""The functions against graph.run, and the manners of ImageBufAlgo."""

import inspect
import runpy
from pathlib import Path

import flowabs_oiio as fabuf
import numpy as np
import OpenImageIO as oiio
import pytest

import flowabs_nodes as fa

EXAMPLE = Path(__file__).parents[1] / "examples" / "mix.py"


def picture(alpha=False):
    """Return an ImageBuf of shapes, overscanned: its data window is larger than its display window."""
    y, x = np.mgrid[:60, :80].astype(np.float32)
    rgb = np.stack([x / 80, y / 60, np.hypot(x - 40, y - 30) < 18], axis=2) * 0.7
    pixels = np.dstack([rgb, np.ones((60, 80, 1))]) if alpha else rgb
    spec = oiio.ImageSpec(80, 60, pixels.shape[2], "float")
    spec.x, spec.y, spec.full_x, spec.full_y, spec.full_width, spec.full_height = -4, 3, 0, 8, 72, 50
    spec.attribute("owner", "somebody")
    buf = oiio.ImageBuf(spec)
    assert buf.set_pixels(oiio.ROI(), pixels.astype(np.float32))
    return buf


def windows(buf):
    """Return the data window and the display window."""
    return [(roi.xbegin, roi.xend, roi.ybegin, roi.yend) for roi in (buf.roi, buf.roi_full)]


def graph_run(outputs, **nodes):
    source = {"format": "flowabs.graph/1", "nodes": {"plate": {"type": "read@1"}, **nodes}}
    return fa.load_graph(source).run(given={"plate": picture()}, outputs=outputs)


ETF = {"type": "etf@1", "inputs": {"image": "plate"}, "params": {"radius": 3}}


def test_each_function_is_its_node():
    flow = fabuf.etf(picture(), radius=3)
    both = {"image": "plate", "flow": "flow"}
    expected = graph_run(
        ["flow", "lines", "lines.response", "smooth", "flat"],
        flow=ETF,
        lines={"type": "fdog@1", "inputs": both, "params": {"sigma_c": 1.5}},
        smooth={"type": "fbl@1", "inputs": both},
        flat={"type": "quantize@1", "inputs": {"image": "plate"}, "params": {"levels": 6}},
    )
    found = {
        "flow": flow,
        "lines": fabuf.fdog(picture(), flow, sigma_c=1.5),
        "lines.response": fabuf.fdog(picture(), flow, sigma_c=1.5, output="response"),
        "smooth": fabuf.fbl(picture(), flow=flow, nthreads=1),
        "flat": fabuf.quantize(picture(), levels=6),
    }
    for name, buf in found.items():
        assert not buf.has_error, buf.geterror()
        np.testing.assert_array_equal(buf.get_pixels(oiio.FLOAT), expected[name].pixels)
        assert windows(buf) == windows(picture())
        assert buf.spec().getattribute("owner") == "somebody"
    assert tuple(flow.spec().channelnames) == ("flow.x", "flow.y")


def test_a_flow_that_is_not_given_is_made():
    made = fabuf.fdog(picture()).get_pixels(oiio.FLOAT)
    np.testing.assert_array_equal(made, fabuf.fdog(picture(), fabuf.etf(picture())).get_pixels(oiio.FLOAT))


def test_a_region_has_the_pixels_of_the_whole():
    part = oiio.ROI(10, 42, 12, 30)
    whole, cut = fabuf.fbl(picture()), fabuf.fbl(picture(), roi=part)
    assert windows(cut)[0] == (10, 42, 12, 30)
    assert windows(cut)[1] == windows(picture())[1]
    np.testing.assert_array_equal(cut.get_pixels(oiio.FLOAT), whole.get_pixels(oiio.FLOAT, part))


def test_a_dst_is_filled():
    expected = fabuf.quantize(picture()).get_pixels(oiio.FLOAT)
    fresh = oiio.ImageBuf()
    assert fabuf.quantize(picture(), dst=fresh) is True
    np.testing.assert_array_equal(fresh.get_pixels(oiio.FLOAT), expected)
    spec = oiio.ImageSpec(80, 60, 3, "half")
    spec.x, spec.y = -4, 3
    held = oiio.ImageBuf(spec)
    oiio.ImageBufAlgo.fill(held, (9, 9, 9))
    assert fabuf.quantize(picture(), dst=held, roi=oiio.ROI(0, 20, 10, 20)) is True
    assert str(held.spec().format) == "half"
    pixels = held.get_pixels(oiio.FLOAT)
    np.testing.assert_array_equal(pixels[7:17, 4:24], expected[7:17, 4:24].astype(np.float16))
    assert (pixels[:7] == 9).all()


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: fabuf.etf(oiio.ImageBuf()), "ImageBuf"),
        (lambda: fabuf.etf(oiio.ImageBuf("no such file.exr")), "no such file"),
        (lambda: fabuf.etf(np.zeros((4, 4, 3))), "expected an ImageBuf, found ndarray"),
        (lambda: fabuf.etf(picture(), radius=-1), "radius"),
        (lambda: fabuf.fdog(picture(), picture()), "flow"),
        (lambda: fabuf.fdog(picture(), output="line"), "did you mean 'lines'"),
        (lambda: fabuf.fdog(fabuf.etf(picture(), radius=-1)), "radius"),
        (lambda: fabuf.etf(picture(), roi=oiio.ROI(500, 600, 0, 10)), "no pixels"),
        (lambda: fabuf.run("abstractoin", picture()), "did you mean 'abstraction'"),
        (lambda: fabuf.run("lines", picture(), line_width=99), "line_width"),
        (lambda: fabuf.run("lines", {"plat": picture()}), "plat"),
        (lambda: fabuf.run({"format": "flowabs.graph/1", "nodes": {}}, picture()), "reads no picture"),
    ],
)
def test_what_is_wrong_is_the_errors_of_the_result(call, said):
    result = call()
    assert result.has_error
    assert said in result.geterror(False)
    assert said in fabuf.geterror()
    assert fabuf.geterror() == ""
    assert oiio.ImageBufAlgo.add(result, 1.0).has_error  # and so on down the line
    assert said in result.geterror()
    assert not result.has_error


def test_a_dst_that_cannot_be_filled_is_said():
    dst = oiio.ImageBuf()
    assert fabuf.etf(picture(), radius=-1, dst=dst) is False
    assert "radius" in fabuf.geterror()
    assert not dst.initialized


def test_a_keyword_that_does_not_exist_is_a_type_error():
    with pytest.raises(TypeError, match="sigma_x"):
        fabuf.fdog(picture(), sigma_x=1)
    with pytest.raises(AttributeError, match="fdgo"):
        fabuf.fdgo(picture())


def test_a_graph_on_a_plate():
    expected = fa.load_graph("abstraction").run(given={"plate": picture(True)}, set={"line_width": 1.5}, scale=0.5)
    found = fabuf.run("abstraction", picture(True), line_width=1.5, scale=0.5)
    np.testing.assert_array_equal(found.get_pixels(oiio.FLOAT), next(iter(expected.values())).pixels)
    ink = fabuf.run("abstraction", {"plate": picture()}, output="comp.ink", roi=oiio.ROI(0, 8, 10, 20))
    assert (ink.roi.width, ink.roi.height, ink.nchannels) == (8, 10, 4)


def test_codes_are_decoded_by_what_the_buffer_says():
    eight = oiio.ImageBuf(oiio.ImageSpec(20, 10, 3, "uint8"))
    oiio.ImageBufAlgo.fill(eight, (0.5, 0.5, 0.5))
    flat = fabuf.blur(eight).get_pixels(oiio.FLOAT)
    np.testing.assert_allclose(flat, ((128 / 255 + 0.055) / 1.055) ** 2.4, rtol=1e-5)


def test_help_is_made_from_the_declaration():
    assert {"etf", "fdog", "fbl", "quantize", "run", "merge"} <= set(dir(fabuf))
    assert not {"read", "write"} & set(dir(fabuf))
    signature = inspect.signature(fabuf.fdog)
    assert list(signature.parameters)[:2] == ["image", "flow"]
    assert signature.parameters["sigma_m"].default == 3.0
    assert {"dst", "roi", "nthreads", "output"} <= set(signature.parameters)
    assert "sigma_m" in fabuf.fdog.__doc__
    assert '"lines" or "response"' in fabuf.fdog.__doc__


def test_the_example_mixes_both(tmp_path):
    example = runpy.run_path(str(EXAMPLE))
    plate, target = tmp_path / "plate.exr", tmp_path / "cartoon.exr"
    assert picture().write(str(plate), "half")
    assert example["main"](str(plate), str(target)) == 0
    drawn = oiio.ImageBuf(str(target)).get_pixels(oiio.FLOAT)
    assert drawn.shape == (60, 80, 3)
    assert np.isfinite(drawn).all()
    assert drawn.std() > 0.1
    assert example["main"](str(tmp_path / "none.exr"), str(target)) == 1
