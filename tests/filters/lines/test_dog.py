import numpy as np
import pytest

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import dog
from tests.filters.flows import THIN
from tests.filters.pictures import noise, photo
from tests.naive import fdog as naive


@pytest.mark.parametrize(("sigma_c", "rho"), [(0.2, 0.99), (1, 0.99), (2.5, 1), (12, 0.97)])
def test_equals_the_sum_in_float64(sigma_c, rho):
    for code in (photo()[..., 0], noise()):
        np.testing.assert_allclose(dog(code, sigma_c, rho), naive.dog(code, sigma_c, rho), rtol=0, atol=1e-4)


@pytest.mark.parametrize("shape", THIN)
def test_thin_pictures(shape):
    code = np.random.default_rng(1).uniform(0, 255, shape)
    np.testing.assert_allclose(dog(code, 2.0), naive.dog(code, 2.0, 0.99), rtol=0, atol=1e-4)


def test_where_code_values_are_constant_the_response_is_their_share():
    np.testing.assert_allclose(dog(np.full((9, 9), 100.0), rho=0.98), 2, atol=1e-4)


def test_is_the_same_in_every_direction():
    code = photo()[..., 1]
    np.testing.assert_allclose(dog(code.T), dog(code).T, atol=1e-4)


def test_every_number_of_threads_gives_the_same_bits(each_thread_count):
    one, *others = each_thread_count(lambda: dog(noise()))
    for other in others:
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(
    ("arguments", "parameter"),
    [({"code": np.zeros((2, 2, 3))}, "code"), ({"sigma_c": 0}, "sigma_c"), ({"rho": -0.1}, "rho")],
)
def test_errors_name_the_argument(arguments, parameter):
    with pytest.raises(ArgumentError, match=parameter) as error:
        dog(**({"code": np.zeros((2, 2))} | arguments))
    assert error.value.parameter == parameter
