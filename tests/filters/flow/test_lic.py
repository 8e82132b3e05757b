import numpy as np
import pytest

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import lic
from tests.filters.flows import cases, random_flow
from tests.naive import streamline as naive


def test_is_noise_averaged_along_the_flow():
    _, flow = cases()["photo"]
    noise = np.random.default_rng(7).random((64, 64), np.float32).astype(np.float64)
    total = noise.copy()
    for way in (1, -1):
        for dx, dy, _ in naive.curve(flow, 4, way):
            total += naive.bilinear(noise, dx, dy)
    expected = np.clip(0.5 + 0.5 * 0.2 * (total / 9 - 0.5) / np.sqrt(1 / 12 / 9), 0, 1)
    np.testing.assert_allclose(lic(flow, length=8.7, seed=7, contrast=0.5), expected, atol=1e-5)


def test_streaks_run_along_the_flow():
    flow = np.zeros((60, 60, 2))
    flow[..., 0] = 1
    picture = lic(flow)
    along, across = (np.abs(np.diff(picture, axis=axis)).mean() for axis in (1, 0))
    assert along < across / 3


@pytest.mark.parametrize("length", [2, 10, 40])
def test_contrast_does_not_depend_on_length(length):
    flow = np.zeros((200, 200, 2))
    flow[..., 0] = 1
    assert lic(flow, length).std() == pytest.approx(0.2, rel=0.2)


def test_seed_contrast_and_length():
    flow = random_flow((30, 40))
    picture = lic(flow)
    assert picture.dtype == np.float32
    assert picture.shape == (30, 40)
    assert picture.min() >= 0
    assert picture.max() <= 1
    np.testing.assert_array_equal(picture, lic(flow, 20, 1, 1))
    assert (picture != lic(flow, seed=2)).any()
    assert (lic(flow, contrast=0) == 0.5).all()
    assert lic(flow, contrast=0.5).std() < picture.std()
    assert lic(random_flow((1, 1)), length=0).shape == (1, 1)


@pytest.mark.parametrize(
    ("arguments", "parameter"),
    [
        ({"flow": np.zeros((4, 5))}, "flow"),
        ({"length": -1}, "length"),
        ({"seed": -1}, "seed"),
        ({"seed": 1.5}, "seed"),
        ({"contrast": -1}, "contrast"),
    ],
)
def test_errors_name_the_argument(arguments, parameter):
    with pytest.raises(ArgumentError, match=parameter) as error:
        lic(**({"flow": np.zeros((4, 5, 2))} | arguments))
    assert error.value.parameter == parameter
