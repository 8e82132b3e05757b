import numpy as np
import pytest

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import composite


def test_equals_the_definition():
    random = np.random.default_rng(0)
    rgb, lines, alpha = random.normal(1, 3, (5, 6, 3)), random.random((5, 6)), random.random((5, 6))
    ink = (0.3, 0.1, 2.0)
    k = ((1 - lines) * 0.7)[..., None]
    np.testing.assert_allclose(composite(rgb, lines, ink, 0.7), rgb * (1 - k) + np.array(ink) * k, rtol=1e-5)
    expected = rgb * (1 - k) + np.array(ink) * alpha[..., None] * k
    np.testing.assert_allclose(composite(rgb, lines, ink, 0.7, alpha), expected, rtol=1e-5, atol=1e-6)


def test_paper_leaves_the_picture_and_ink_covers_it():
    rgb = np.random.default_rng(0).normal(0, 1e3, (4, 5, 3)).astype(np.float32)
    np.testing.assert_array_equal(composite(rgb, np.ones((4, 5))), rgb)
    np.testing.assert_array_equal(composite(rgb, np.zeros((4, 5)), opacity=0), rgb)
    np.testing.assert_array_equal(composite(rgb, np.zeros((4, 5)), (0.25, 0.5, 1)), np.full((4, 5, 3), (0.25, 0.5, 1)))


@pytest.mark.parametrize(
    ("arguments", "parameter"),
    [
        ({"rgb": np.zeros((4, 5, 4))}, "rgb"),
        ({"lines": np.zeros((5, 4))}, "lines"),
        ({"lines": np.full((4, 5), np.nan)}, "lines"),
        ({"ink": (0, 0)}, "ink"),
        ({"ink": (0, 0, np.nan)}, "ink"),
        ({"ink": (0, 0, "black")}, "ink"),
        ({"opacity": 1.5}, "opacity"),
        ({"alpha": np.ones((4, 6))}, "alpha"),
    ],
)
def test_errors_name_the_argument(arguments, parameter):
    with pytest.raises(ArgumentError, match=parameter) as error:
        composite(**({"rgb": np.zeros((4, 5, 3)), "lines": np.ones((4, 5))} | arguments))
    assert error.value.parameter == parameter
