import numpy as np
import pytest

from flowabs_nodes.choices import SAMPLINGS
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import etf, fdog, fdog_iterative, threshold
from tests.filters.flows import THIN, cases, large, random_flow
from tests.naive import fdog as naive


@pytest.mark.parametrize("sampling", SAMPLINGS)
@pytest.mark.parametrize("kernel", ["separable", "full"])
@pytest.mark.parametrize("name", ["photo", "noise"])
def test_equals_the_equations_in_float64(name, kernel, sampling):
    image, flow = cases()[name]
    response = fdog(image[..., 0], flow, kernel=kernel, sampling=sampling)
    expected = naive.fdog(image[..., 0], flow, kernel=kernel, sampling=sampling)
    assert response.dtype == np.float32
    np.testing.assert_allclose(response, expected, rtol=0, atol=1e-4)
    assert (threshold(response) == naive.threshold(expected)).mean() > 0.999


@pytest.mark.parametrize(
    ("sigma_m", "sigma_c", "rho"),
    [(0, 1, 0.99), (0.05, 0.05, 1), (3, 0.3, 0.9), (20, 1, 0.99), (2, 15, 1), (4.5, 1.5, 0)],
)
@pytest.mark.parametrize("name", ["photo", "noise"])
def test_short_and_long_kernels(name, sigma_m, sigma_c, rho):
    image, flow = cases()[name]
    response = fdog(image[..., 1], flow, sigma_m, sigma_c, rho)
    np.testing.assert_allclose(response, naive.fdog(image[..., 1], flow, sigma_m, sigma_c, rho), rtol=0, atol=2e-4)


@pytest.mark.parametrize("kernel", ["separable", "full"])
@pytest.mark.parametrize("shape", THIN)
def test_thin_pictures(shape, kernel):
    code = np.random.default_rng(1).uniform(0, 255, shape).astype(np.float32)
    flow = random_flow(shape, 2)
    np.testing.assert_allclose(
        fdog(code, flow, kernel=kernel), naive.fdog(code, flow, kernel=kernel), rtol=0, atol=2e-4
    )


@pytest.mark.parametrize("sampling", SAMPLINGS)
@pytest.mark.parametrize("kernel", ["separable", "full"])
@pytest.mark.parametrize("length", [0.01, 1.2, 1.3, 40])
def test_tangents_of_any_length(length, kernel, sampling):
    image, flow = cases()["noise"]
    lengths = np.random.default_rng(5).uniform(0, length, (*flow.shape[:2], 1)).astype(np.float32)
    response = fdog(image[..., 0], lengths * flow, kernel=kernel, sampling=sampling)
    expected = naive.fdog(image[..., 0], lengths * flow, kernel=kernel, sampling=sampling)
    np.testing.assert_allclose(response, expected, rtol=0, atol=2e-4)


@pytest.mark.parametrize("sampling", SAMPLINGS)
def test_one_long_tangent_changes_nothing_far_from_it(sampling):
    image, flow = large()
    long = flow.copy()
    long[70, 140] *= 5
    near, far = (fdog(image, each, sampling=sampling) for each in (flow, long))
    np.testing.assert_allclose(near[:, 200:], far[:, 200:], rtol=0, atol=1e-4)  # by another path
    assert abs(near - far).max() > 1


@pytest.mark.parametrize("sampling", SAMPLINGS)
@pytest.mark.parametrize(("sigma_m", "sigma_c"), [(3, 1), (60, 0.4), (0.4, 40)])
def test_pictures_of_several_tiles(sigma_m, sigma_c, sampling):
    image, flow = large()
    response = fdog(image, flow, sigma_m, sigma_c, sampling=sampling)
    np.testing.assert_allclose(
        response, naive.fdog(image, flow, sigma_m, sigma_c, sampling=sampling), rtol=0, atol=3e-4
    )


@pytest.mark.parametrize("name", ["photo", "noise"])
def test_lines_from_colour(name):
    image, flow = cases()[name]
    for weight in (0.5, 3.0):
        response = fdog(image, flow, color_weight=weight)
        np.testing.assert_allclose(response, naive.fdog(image, flow, color_weight=weight), rtol=0, atol=2e-4)
    np.testing.assert_array_equal(fdog(image, flow), fdog(image[..., 0], flow))
    grey = np.stack([image[..., 0], np.full(flow.shape[:2], 3), np.full(flow.shape[:2], -7)], -1)
    d = fdog(grey, flow, rho=1).astype(np.float64)
    np.testing.assert_allclose(fdog(grey, flow, rho=1, color_weight=1), np.tanh(2 * d) * abs(d), atol=1e-4)


@pytest.mark.parametrize("name", ["photo", "noise"])
@pytest.mark.parametrize("weight", [0.5, 3.0])
def test_lines_from_colour_of_equal_lightness(name, weight):
    image, flow = cases()[name]
    flat = np.concatenate([0.1 * image[..., :1], image[..., 1:]], -1)  # lightness decides here and colour there
    response = fdog(flat, flow, color_weight=weight, color_sign=True)
    expected = naive.fdog(flat, flow, color_weight=weight, color_sign=True)
    np.testing.assert_allclose(response, expected, rtol=0, atol=1e-3)
    assert abs(response - fdog(flat, flow, color_weight=weight)).max() > 2


def test_where_there_is_no_colour_the_sign_is_that_of_lightness():
    image, flow = cases()["photo"]
    grey = np.stack([image[..., 0], np.full(flow.shape[:2], 3), np.full(flow.shape[:2], -7)], -1)
    for code in (image[..., 0], np.float32(grey)):
        with_sign, without = (fdog(code, flow, rho=1, color_weight=1, color_sign=sign) for sign in (True, False))
        np.testing.assert_allclose(with_sign, without, rtol=0, atol=1e-3)
    np.testing.assert_array_equal(fdog(image, flow, color_sign=True), fdog(image, flow))  # nor where colour has none
    constant = np.full((20, 30, 3), 90, np.float32)
    np.testing.assert_allclose(fdog(constant, flow[:20, :30], rho=1, color_weight=1, color_sign=True), 0, atol=1e-3)


@pytest.mark.parametrize(
    ("left", "right"),
    [
        ((60, 50), (-60, 40)),  # red and green
        ((60, 50), (20, -90)),  # red and blue
        ((40, 80), (-30, -20)),  # orange and teal
        ((0, 0), (30, 10)),  # grey and pink
        ((0, -40), (0, 40)),  # blue and yellow
        ((50, 0), (-50, 0)),  # magenta and green
    ],
)
@pytest.mark.parametrize("kernel", ["separable", "full"])
def test_an_edge_of_equal_lightness_is_one_line_beside_it(left, right, kernel):
    code = np.full((40, 60, 3), 130.0)
    code[:, :30, 1:], code[:, 30:, 1:] = left, right
    flow = np.zeros((40, 60, 2))
    flow[..., 1] = 1
    options = {"rho": 1.0, "color_weight": 0.5, "kernel": kernel}
    ink = threshold(fdog(code, flow, color_sign=True, **options), contrast=1.0) == 0
    assert ink[:, 28:32].any(axis=1).all()  # the whole edge
    assert 1 <= ink.sum(axis=1).max() <= 3  # on one side of it
    assert not ink[:, :27].any()
    assert not ink[:, 33:].any()
    assert threshold(fdog(code, flow, **options), contrast=1.0).all()


def test_a_thin_shape_of_equal_lightness_is_outlined():
    code = np.full((60, 60, 3), 130.0)
    y, x = np.mgrid[:60, :60]
    r = np.hypot(x - 30, y - 30)
    code[..., 1:] = np.where((r < 18)[..., None], (55, 15), (-5, -45))  # a petal before the sky
    flow = etf(code)
    ink = threshold(fdog(code, flow, rho=1, color_weight=0.5, color_sign=True), contrast=1.0) == 0
    assert np.abs(r[ink] - 18).max() < 4
    around = np.degrees(np.arctan2(y - 30, x - 30))[ink]
    assert np.unique(np.round(around / 10)).size >= 36


def a_disc(chroma, hue, lightness=0.0):
    """A disc of some hue before grey, anti-aliased: code values, its distance from each pixel, its flow."""
    y, x = np.mgrid[:96, :96] - 47.5
    r = np.hypot(x, y)
    cover = np.clip(30.5 - r, 0, 1)[..., None]
    angle = np.radians(hue)
    code = [127, 0, 0] + cover * [lightness, chroma * np.cos(angle), chroma * np.sin(angle)]
    return code, np.abs(r - 30), np.stack([-y, x], -1) / r[..., None]


def ink_at_the_edge(chroma, hue, lightness=0.0, **options):
    """Return pixels of ink for each pixel of the disc's edge, drawn as the shipped graphs do."""
    code, distance, flow = a_disc(chroma, hue, lightness)
    options = {"contrast": 1.0, "softness": 4.0, "iterations": 2, "pre_blur": 1.0, "color_weight": 0.5} | options
    lines, _ = fdog_iterative(code, flow, rho=1.0, color_sign=True, **options)
    assert (lines[distance > 8] == 1).all()
    return (1 - lines).sum() / (2 * np.pi * 30)


@pytest.mark.parametrize("chroma", [64, 100, 150])
def test_no_hue_of_equal_lightness_is_blind(chroma):
    blind = np.degrees(np.arctan2(0.4, -0.7))  # here neither side of the edge has less 0.4 a + 0.7 b
    ink = [ink_at_the_edge(chroma, hue) for hue in [*range(0, 360, 10), blind, blind + 180]]
    assert min(ink) > 0.2
    assert max(ink) < 10 * min(ink)


@pytest.mark.parametrize("hue", [60, 150, 240, 330])
def test_nor_is_an_edge_where_lightness_and_colour_disagree(hue):
    assert min(ink_at_the_edge(100, hue, step) for step in range(-30, 31, 2)) > 0.3


def test_ink_changes_steadily_with_the_hue():
    ink = np.array([ink_at_the_edge(100, hue) for hue in range(140, 161)])
    assert np.abs(np.diff(ink)).max() < 0.5


@pytest.mark.parametrize("sigma", [1, 2, 4])
def test_noise_makes_no_ink_of_colour(sigma):
    """Noise stays below the strength from which both sides of an edge may be dark: H is that of the sign alone."""
    code = [127, 0, 0] + sigma * np.random.default_rng(1).standard_normal((160, 240, 3))
    lines, _ = fdog_iterative(
        code, etf(code, fill=4.0), rho=1, contrast=1, softness=4, color_weight=0.5, color_sign=True, pre_blur=1
    )
    assert (lines == 1).all()


@pytest.mark.parametrize("name", ["photo", "noise"])
def test_full_and_separable_are_one_when_the_curve_is_read_at_pixels(name):
    image, flow = cases()[name]
    full, separable = (fdog(image[..., 0], flow, kernel=kernel, sampling="nearest") for kernel in ("full", "separable"))
    np.testing.assert_allclose(full, separable, rtol=0, atol=1e-4)


@pytest.mark.parametrize("kernel", ["separable", "full"])
@pytest.mark.parametrize("value", [0, 40, 255, -30])
def test_where_code_values_are_constant_the_response_is_their_share(kernel, value):
    response = fdog(np.full((12, 300), value), random_flow((12, 300)), rho=0.97, kernel=kernel)
    np.testing.assert_allclose(response, 0.03 * value, atol=1e-4)


def test_a_dark_line_is_below_0_and_a_bright_one_above():
    flow = np.zeros((30, 30, 2))
    flow[..., 1] = 1
    dark = np.full((30, 30), 200.0)
    dark[:, 14:16] = 50
    assert fdog(dark, flow, rho=1)[:, 14:16].max() < -20
    assert fdog(250 - dark, flow, rho=1)[:, 14:16].min() > 20


@pytest.mark.parametrize("kernel", ["separable", "full"])
def test_the_sign_of_a_flow_has_no_meaning(kernel):
    image, flow = cases()["noise"]
    signs = np.random.default_rng(3).choice([-1, 1], (*flow.shape[:2], 1)).astype(np.float32)
    np.testing.assert_allclose(
        fdog(image[..., 0], flow * signs, kernel=kernel), fdog(image[..., 0], flow, kernel=kernel), rtol=0, atol=1e-4
    )


@pytest.mark.parametrize("axis", [0, 1])
def test_a_mirrored_picture_gives_a_mirrored_response(axis):
    image, flow = cases()["photo"]
    mirrored = np.flip(flow, axis) * np.array([1, -1] if axis == 0 else [-1, 1])
    np.testing.assert_allclose(
        fdog(np.flip(image[..., 0], axis), mirrored), np.flip(fdog(image[..., 0], flow), axis), rtol=0, atol=1e-4
    )


def test_any_memory_layout_and_dtype_gives_the_same():
    image, flow = cases()["photo"]
    expected = fdog(image[..., 0].copy(), flow)
    for code in (image[..., 0], image[..., 0].astype(np.uint8), np.asfortranarray(image[..., 0]).astype(np.float64)):
        np.testing.assert_array_equal(fdog(code, flow.astype(np.float64)), expected)


@pytest.mark.parametrize("kernel", ["separable", "full"])
def test_every_number_of_threads_gives_the_same_bits(each_thread_count, kernel):
    image, flow = cases()["noise"]
    one, *others = each_thread_count(lambda: fdog(image, flow, color_weight=0.5, kernel=kernel, color_sign=True))
    for other in others:
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("sampling", SAMPLINGS)
def test_tiles_may_begin_in_any_row(each_thread_count, sampling):
    image, flow = large()
    one, *others = each_thread_count(lambda: fdog(image, flow, sampling=sampling))
    for other in others:
        np.testing.assert_array_equal(one, other)
    np.testing.assert_array_equal(fdog(image[:130], flow[:130], sampling=sampling)[:100], one[:100])


@pytest.mark.parametrize(
    ("arguments", "parameter"),
    [
        ({"code": np.zeros((4, 5, 4))}, "code"),
        ({"code": np.full((4, 5), np.inf)}, "code"),
        ({"flow": np.zeros((4, 6, 2))}, "flow"),
        ({"sigma_m": -0.1}, "sigma_m"),
        ({"sigma_c": 0}, "sigma_c"),
        ({"rho": 2.1}, "rho"),
        ({"color_weight": -1}, "color_weight"),
        ({"color_sign": 1}, "color_sign"),
        ({"kernel": "fast"}, "kernel"),
        ({"sampling": "cubic"}, "sampling"),
    ],
)
def test_errors_name_the_argument(arguments, parameter):
    with pytest.raises(ArgumentError, match=parameter) as error:
        fdog(**({"code": np.zeros((4, 5)), "flow": np.zeros((4, 5, 2))} | arguments))
    assert error.value.parameter == parameter


@pytest.mark.parametrize("sampling", SAMPLINGS)
@pytest.mark.parametrize("kernel", ["separable", "full"])
@pytest.mark.parametrize("shape", THIN)
def test_one_channel_is_read_like_many(shape, kernel, sampling):
    code = np.random.default_rng(2).uniform(0, 255, (*shape, 1)).astype(np.float32)
    flow = random_flow(shape, 3)
    grey = np.concatenate([code, np.zeros((*shape, 2), np.float32)], -1)
    alone, among = (fdog(c, flow, color_weight=1, kernel=kernel, sampling=sampling) for c in (code[..., 0], grey))
    np.testing.assert_allclose(alone, among, rtol=0, atol=1e-5)
