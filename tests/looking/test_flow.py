import numpy as np

from flowabs_nodes.filters.flow.flow_color import flow_color
from flowabs_nodes.filters.flow.lic import lic
from flowabs_nodes.image import Image
from flowabs_nodes.looking.flow import look_at_flow


def flow(height=24, width=32):
    angle = np.linspace(0, np.pi, height * width).reshape(height, width)
    return np.stack([np.cos(angle), np.sin(angle)], axis=2).astype(np.float32)


def test_colour_of_the_orientation_times_the_lic():
    look = look_at_flow(Image.from_array(flow()))
    expected = flow_color(flow()) * (1.5 * lic(flow())[..., None])
    np.testing.assert_allclose(look.codes, expected.clip(0, 1), atol=1e-6)
    assert "LIC" in look.said


def test_streaks_grow_with_the_picture():
    image = Image.from_array(flow())
    spec = image.spec
    spec.full_width, spec.full_height = 2048, 1080
    look = look_at_flow(Image(image.pixels, spec, "flow"))
    expected = flow_color(flow()) * (1.5 * lic(flow(), length=40)[..., None])
    np.testing.assert_allclose(look.codes, expected.clip(0, 1), atol=1e-6)
