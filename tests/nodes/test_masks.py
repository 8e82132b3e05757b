"""The masks that nodes declare themselves: where lines are drawn, and which pixels a flow comes from."""

import numpy as np
import pytest

import flowabs_nodes as fa
from flowabs_nodes import filters
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.image import Image, Window

pytest.importorskip("cv2")  # of canny

DRAWING = ("fdog", "fdog_iterative", "dog", "canny")
HEIGHT, WIDTH = 48, 64


def plate(seed=3):
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    rgb = 0.2 + 0.5 * ((x // 9 + y // 7) % 2)[..., None] * [1, 0.8, 0.6]
    return Image.from_array((rgb + np.random.default_rng(seed).normal(0, 0.02, rgb.shape)).astype(np.float32))


def matte(values, window=None):
    image = plate().with_pixels(np.broadcast_to(np.float32(values), (HEIGHT, WIDTH)), "matte")
    return image if window is None else image.on_window(window)


RAMP = np.linspace(-0.2, 1.2, WIDTH)  # what is not 0 to 1 is clipped


def run(node, mask=None, params=None, output="", image=None):
    nodes = {
        "plate": {"type": "read@1"},
        "matte": {"type": "read@1"},
        "roto": {"type": "matte@1", "inputs": {"image": "matte"}, "params": {"channel": "R"}},
        "flow": {"type": "etf@1", "inputs": {"image": "plate"}},
        "it": {"type": f"{node}@1", "inputs": {"image": "plate"}, "params": params or {}},
    }
    if node.startswith("fdog"):
        nodes["it"]["inputs"]["flow"] = "flow"
    given = {"plate": plate() if image is None else image}
    if mask is not None:
        nodes["it"]["inputs"]["mask"] = "roto"
        given["roto"] = mask
    name = f"it.{output}" if output else "it"
    graph = fa.load_graph({"format": "flowabs.graph/1", "nodes": nodes})
    return graph.run(given=given, outputs=name)[name].pixels


@pytest.mark.parametrize("node", DRAWING)
def test_ink_is_multiplied_by_the_mask(node):
    lines, masked = run(node)[..., 0], run(node, matte(RAMP))[..., 0]
    np.testing.assert_allclose(1 - masked, (1 - lines) * np.clip(RAMP, 0, 1), atol=1e-6)
    assert (1 - masked).sum() > 10
    np.testing.assert_array_equal(run(node, matte(1.0))[..., 0], lines)
    assert (run(node, matte(0.0)) == 1).all()


@pytest.mark.parametrize("params", [{"form": "xdog"}, {"softness": 4.0, "smooth": 2.0}])
@pytest.mark.parametrize("node", ["fdog", "fdog_iterative"])
def test_after_all_that_makes_the_lines(node, params):
    lines, masked = run(node, None, params)[..., 0], run(node, matte(RAMP), params)[..., 0]
    np.testing.assert_allclose(1 - masked, (1 - lines) * np.clip(RAMP, 0, 1), atol=1e-6)


@pytest.mark.parametrize("node", ["fdog", "fdog_iterative", "dog"])
def test_the_response_is_that_of_the_whole_picture(node):
    np.testing.assert_array_equal(run(node, matte(RAMP), output="response"), run(node, output="response"))


@pytest.mark.parametrize("node", [*DRAWING, "etf"])
def test_a_mask_with_pixels_in_a_part_of_the_picture_is_0_elsewhere(node):
    part = Window(20, 10, 30, 25)
    full = np.zeros((HEIGHT, WIDTH))
    full[10:35, 20:50] = 1
    np.testing.assert_array_equal(run(node, matte(1.0, part)), run(node, matte(full)))


@pytest.mark.parametrize("node", [*DRAWING, "etf"])
def test_a_picture_with_another_data_window_than_its_mask(node):
    part = Window(20, 10, 30, 25)
    image = plate().on_window(part)
    mask = matte(RAMP)
    np.testing.assert_array_equal(run(node, mask, image=image), run(node, mask.on_window(part), image=image))


@pytest.mark.parametrize("node", [*DRAWING, "etf"])
def test_a_mask_of_a_proxy_is_refused(node):
    proxy = Image.from_array(np.ones((HEIGHT // 2, WIDTH // 2), np.float32), type="matte")
    with pytest.raises(FlowabsError, match="'mask' is of a picture of 32x24, but input 'image' of 64x48") as caught:
        run(node, proxy)
    assert (caught.value.code, caught.value.node) == ("window-mismatch", "it")


def test_a_masked_flow_is_that_of_the_filter():
    image, mask = plate(), matte(RAMP)
    code = image.encoded_mono("lab", ground=1.0)
    np.testing.assert_array_equal(run("etf", mask), filters.etf(code, mask=np.clip(mask.pixels[..., 0], 0, 1)))


def test_what_is_masked_out_steers_no_flow():
    step = (np.arange(WIDTH) >= 32).astype(np.float32)
    noisy = np.where(np.arange(WIDTH)[:, None] < 30, plate(5).pixels[:, ::-1], plate().pixels).astype(np.float32)
    flows = [
        run("etf", matte(step), {"gradient_reference": 16}, image=plate().with_pixels(p))
        for p in (plate().pixels, noisy)
    ]
    np.testing.assert_array_equal(*flows)


@pytest.mark.parametrize("node", [*DRAWING, "etf"])
def test_a_mask_that_is_not_finite_is_refused_or_stays_in_its_pixel(node):
    bad = np.ones((HEIGHT, WIDTH))
    bad[5, 6] = np.nan
    if node == "etf":
        with pytest.raises(FlowabsError, match="mask"):
            run(node, matte(bad))
    else:
        assert np.argwhere(np.isnan(run(node, matte(bad))[..., 0])).tolist() == [[5, 6]]
