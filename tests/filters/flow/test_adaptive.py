import numpy as np
import pytest

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import etf
from flowabs_nodes.filters.flow.adaptive import kernel_choice, radii
from tests.filters.pictures import noise, photo
from tests.naive import adaptive as naive
from tests.naive.etf import degrees_between
from tools.gallery import drawings

GREY = photo().mean(-1)
TEXTURE = drawings.small_texture()[:60, :70]


def test_radii_are_halved_down_to_two_and_a_half():
    assert radii(10) == [10, 5, 2.5]
    assert radii(7) == [7, 3.5, 2.5]
    assert radii(3) == [3, 2.5]
    for small in (2.5, 1, 0):
        assert radii(small) == [small]


@pytest.mark.parametrize("code", [GREY, photo(), TEXTURE, noise(60, 41)], ids=["photo", "colour", "texture", "noise"])
@pytest.mark.parametrize("radius", [5.0, 14.0])
def test_the_choice_is_that_of_float64(code, radius):
    assert (kernel_choice(np.asarray(code, np.float32), radius) == naive.kernel_choice(code, radius)).mean() > 0.999


@pytest.mark.parametrize("kernel", ["full", "separable"])
@pytest.mark.parametrize("code", [GREY, TEXTURE], ids=["photo", "texture"])
def test_each_pixel_has_its_own_kernel_in_float64(code, kernel):
    choice = kernel_choice(code, 7.0)
    assert np.unique(choice).tolist() == [0, 1, 2]
    error = degrees_between(etf(code, 7.0, 2, kernel, adaptive=True), naive.etf(code, 7.0, 2, kernel, choice))
    assert np.median(error) < 1e-4
    assert np.quantile(error, 0.999) < 0.05


def test_texture_takes_a_small_kernel_noise_and_edges_the_full_one():
    assert (kernel_choice(TEXTURE, 5.0) > 0).mean() > 0.9
    assert (kernel_choice(noise(60, 60), 5.0) > 0).mean() < 0.05
    edge = np.broadcast_to(np.where(np.arange(50) < 25, 0.0, 255.0), (50, 50)).astype(np.float32)
    assert not kernel_choice(edge, 5.0).any()
    assert not kernel_choice(np.full((9, 9), 7, np.float32), 5.0).any()


@pytest.mark.parametrize("scale", [2.0**-100, 2.0**100])
def test_the_scale_of_the_picture_does_not_matter(scale):
    code = np.round(GREY)
    np.testing.assert_array_equal(kernel_choice(code, 7.0), kernel_choice(code * np.float32(scale), 7.0))


@pytest.mark.parametrize("kernel", ["full", "separable"])
def test_every_number_of_threads_gives_the_same_bits(each_thread_count, kernel):
    code = np.vstack([TEXTURE, noise(90, 70)])
    one, *others = each_thread_count(lambda: etf(code, 6.0, kernel=kernel, adaptive=True))
    for other in others:
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("shape", [(1, 1), (1, 17), (17, 1), (2, 3, 3)])
def test_small_pictures(shape):
    code = np.random.default_rng(2).uniform(0, 255, shape)
    np.testing.assert_allclose(np.linalg.norm(etf(code, 1000, adaptive=True), axis=-1), 1, rtol=1e-6)


def test_it_is_true_or_false():
    with pytest.raises(ArgumentError, match="adaptive"):
        etf(GREY, adaptive=1)
