import sys

import cv2
import numpy as np
import pytest

from flowabs_nodes.errors import ArgumentError, FlowabsError
from flowabs_nodes.filters import canny
from tests.filters.flows import THIN
from tests.filters.pictures import noise, photo
from tests.naive.streamline import gaussian


def reference(code, sigma, low, high):
    """OpenCV's Canny on the gradient in float64, as 16-bit integers."""
    steps = int(np.ceil(3 * sigma))
    weights = gaussian(sigma, steps)
    wide = np.pad(code.astype(np.float64), steps, "edge")
    rows = sum(w * wide[k : k + code.shape[0]] for k, w in enumerate(weights))
    blurred = np.pad(sum(w * rows[:, k : k + code.shape[1]] for k, w in enumerate(weights)), 1, "edge")
    down, across = blurred[2:] - blurred[:-2], blurred[:, 2:] - blurred[:, :-2]
    gy = down[:, :-2] + 2 * down[:, 1:-1] + down[:, 2:]
    gx = across[:-2] + 2 * across[1:-1] + across[2:]
    scale = 32767 / np.hypot(gx, gy).max()
    gx, gy = (np.rint(scale * each).astype(np.int16) for each in (gx, gy))
    return 1 - cv2.Canny(gx, gy, low * 32767, high * 32767, L2gradient=True) / 255.0


@pytest.mark.parametrize(("sigma", "low", "high"), [(1, 0.1, 0.2), (0, 0.3, 0.5), (3, 0.05, 0.3)])
def test_is_opencvs_on_our_gradient(sigma, low, high):
    for code in (photo()[..., 0], noise()):
        lines = canny(code, sigma, low, high)
        assert lines.dtype == np.float32
        np.testing.assert_array_equal(lines, reference(code, sigma, low, high))


def test_an_edge_is_one_pixel_wide_and_a_weak_part_of_it_goes_on():
    code = np.zeros((30, 30))
    code[:, 15:] = 100
    code[20:, 15:] = 30
    lines = canny(code)
    assert (1 - lines[2:18]).sum(axis=1).tolist() == [1] * 16
    assert (1 - lines[23:28]).sum(axis=1).tolist() == [1] * 5
    assert canny(code, low=0.5, high=0.6)[23:28].all()


def test_a_flat_picture_is_paper():
    np.testing.assert_array_equal(canny(np.full((7, 9), 40)), np.ones((7, 9)))


@pytest.mark.parametrize("shape", THIN)
def test_thin_pictures_and_thresholds_in_any_order(shape):
    code = np.random.default_rng(1).uniform(0, 255, shape)
    lines = canny(code, low=0.4, high=0.1)
    assert set(np.unique(lines)) <= {0, 1}
    np.testing.assert_array_equal(lines, canny(code, low=0.1, high=0.4))


def test_values_far_above_white_are_not_clipped():
    code = photo()[..., 0]
    np.testing.assert_array_equal(canny(code * 64), canny(code))


def test_every_number_of_threads_gives_the_same_bits(each_thread_count):
    one, *others = each_thread_count(lambda: canny(noise()))
    for other in others:
        np.testing.assert_array_equal(one, other)


def test_without_opencv_the_error_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "cv2", None)
    with pytest.raises(FlowabsError, match=r"canny needs OpenCV.*pip install 'flowabs-nodes\[compare\]'") as error:
        canny(np.zeros((3, 3)))
    assert error.value.code == "missing-package"


@pytest.mark.parametrize(
    ("arguments", "parameter"),
    [({"code": np.zeros((2, 2, 3))}, "code"), ({"sigma": -1}, "sigma"), ({"low": 2}, "low"), ({"high": -0.1}, "high")],
)
def test_errors_name_the_argument(arguments, parameter):
    with pytest.raises(ArgumentError, match=parameter) as error:
        canny(**({"code": np.zeros((2, 2))} | arguments))
    assert error.value.parameter == parameter
