import numpy as np
import pytest

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import validate

READERS = {
    validate.plane: ((4, 5), [(4,), (4, 5, 1), (0, 5)]),
    validate.planes: ((4, 5, 3), [(4, 5), (4, 5, 4), (4, 0, 3)]),
    validate.plane_or_planes: ((4, 5, 3), [(4, 5, 2), (4,), (0, 0)]),
    validate.any_channels: ((4, 5, 4), [(4,), (4, 5, 3, 1), (4, 5, 0)]),
}


@pytest.mark.parametrize("read", READERS)
def test_arrays_become_contiguous_float32(read):
    shape, _ = READERS[read]
    for dtype in (np.float16, np.float32, np.float64, np.int32, np.uint8, bool):
        value = np.ones(shape[::-1], dtype).T
        result = read("code", value)
        assert result.dtype == np.float32
        assert result.flags.c_contiguous
        assert result.shape == shape


def test_nothing_is_copied_without_need():
    value = np.zeros((4, 5), np.float32)
    assert validate.plane("code", value) is value


@pytest.mark.parametrize("read", READERS)
def test_wrong_shapes_are_named(read):
    for shape in READERS[read][1]:
        with pytest.raises(ArgumentError) as error:
            read("code", np.zeros(shape))
        assert error.value.parameter == "code"
        assert str(shape) in str(error.value)


@pytest.mark.parametrize("value", [np.zeros((2, 2), complex), np.array([["a", "b"]]), np.array([[None, None]])])
def test_wrong_dtypes_are_named(value):
    with pytest.raises(ArgumentError, match="code: expected real numbers, found dtype") as error:
        validate.plane("code", value)
    assert error.value.code == "wrong-type"


@pytest.mark.filterwarnings("error")
def test_pixels_that_are_not_finite_are_counted():
    value = np.zeros((4, 5))
    value[0, 0], value[1, 1], value[2, 2] = np.nan, np.inf, -np.inf
    with pytest.raises(ArgumentError, match="code: expected finite pixels, found 3 that are NaN or Inf"):
        validate.plane("code", value)


@pytest.mark.filterwarnings("error")
def test_numbers_beyond_float32_are_not_finite():
    with pytest.raises(ArgumentError, match="found 2 that are NaN or Inf"):
        validate.plane("code", np.array([[1e300, -1e300, 1]]))


def test_the_largest_finite_pixels_are_finite():
    largest = np.full((100, 100), np.finfo(np.float32).max)
    np.testing.assert_array_equal(validate.plane("code", largest), largest)


def test_flow_has_to_fit_the_picture():
    flow = np.zeros((4, 5, 2), np.float32)
    assert validate.flow_field(flow, (4, 5, 3)) is flow
    with pytest.raises(ArgumentError, match="expected the size of the picture, 4x5, found 5x4"):
        validate.flow_field(flow, (5, 4))
    with pytest.raises(ArgumentError, match=r"expected shape \(H, W, 2\)"):
        validate.flow_field(flow[..., 0])


@pytest.mark.parametrize("value", [1, 1.5, np.float32(2), np.int64(3)])
def test_numbers(value):
    result = validate.number("sigma", value, min=1, max=3, above=0.5)
    assert type(result) is float
    assert result == value


@pytest.mark.parametrize(
    ("value", "rule"),
    [(0.9, "at least 1"), (3.1, "at most 3"), (float("nan"), "at least 1 and at most 3"), (float("inf"), "at most 3")],
)
def test_numbers_out_of_range_name_rule_and_value(value, rule):
    with pytest.raises(ArgumentError, match=f"sigma: expected a number .*{rule}.*, found {value!r}") as error:
        validate.number("sigma", value, min=1, max=3)
    assert error.value.code == "out-of-range"


def test_above_leaves_the_limit_out():
    with pytest.raises(ArgumentError, match="greater than 0"):
        validate.number("sigma", 0, above=0)


@pytest.mark.parametrize("value", [True, "1", None, 1j, [1]])
def test_other_types_are_no_numbers(value):
    with pytest.raises(ArgumentError, match="expected a number") as error:
        validate.number("sigma", value)
    assert error.value.code == "wrong-type"


@pytest.mark.parametrize("value", [True, 1.0, "1", None])
def test_other_types_are_no_whole_numbers(value):
    with pytest.raises(ArgumentError, match="expected a whole number"):
        validate.whole("iterations", value)


def test_whole_numbers():
    assert validate.whole("iterations", np.int32(3), min=0) == 3
    with pytest.raises(ArgumentError, match="iterations"):
        validate.whole("iterations", -1, min=0)


def test_choice_hints_at_the_nearest():
    assert validate.choice("kernel", "full", ("full", "separable")) == "full"
    with pytest.raises(ArgumentError, match="did you mean 'separable'"):
        validate.choice("kernel", "seperable", ("full", "separable"))


def test_pictures_that_kernels_could_not_count_are_refused():
    with pytest.raises(ArgumentError, match=r"code: expected fewer than 2\^29 pixels"):
        validate.plane("code", np.broadcast_to(np.uint8(0), (2**16, 2**13)))


def test_a_plane_has_to_fit_the_picture():
    assert validate.plane("alpha", np.zeros((4, 5)), (4, 5, 3)).shape == (4, 5)
    with pytest.raises(ArgumentError, match="alpha: expected the size of the picture, 5x4, found 4x5") as error:
        validate.plane("alpha", np.zeros((5, 4)), (4, 5, 3))
    assert error.value.parameter == "alpha"


@pytest.mark.parametrize("name", ["code", "codes"])
@pytest.mark.parametrize(
    ("low", "high", "told"),
    [
        (0, 1, True),
        (0.1, 0.8, True),
        (0, 255, False),
        (0, 1.2, False),
        (0, 0.3, False),
        (-0.1, 1, False),
        (0, 0, False),
    ],
)
def test_code_values_of_0_to_1_are_noted(name, low, high, told, caplog):
    picture = np.linspace(low, high, 40 * 50 * 3).reshape(40, 50, 3)
    with caplog.at_level("INFO", "flowabs"):
        validate.planes(name, picture)
        validate.planes("rgb", picture)
    assert [record.message for record in caplog.records] == (
        [f"{name}: code values look like 0..1: multiply by 255 (white is 255)"] if told else []
    )


def test_a_filter_of_0_to_1_is_noted_and_runs(caplog):
    from flowabs_nodes import filters

    code = np.random.default_rng(1).random((20, 30))
    flow = filters.etf(code)
    filters.fdog(code, flow)
    filters.dog(code)
    assert len(caplog.records) == 3


@pytest.mark.parametrize("five", [5, 5.0, np.float16(5), np.int8(5), np.longdouble(5), np.array(5), np.array(5.0)])
def test_numbers_of_numpy_are_numbers(five):
    assert validate.number("radius", five) == 5
    assert type(validate.number("radius", five)) is float


@pytest.mark.parametrize("three", [3, np.int64(3), np.uint8(3), np.array(3), np.array(3, np.int16)])
def test_whole_numbers_of_numpy_are_whole_numbers(three):
    assert validate.whole("iterations", three) == 3
    assert type(validate.whole("iterations", three)) is int


@pytest.mark.parametrize(
    "other", [3.0, np.float64(3), np.array(3.0), np.array([3]), True, np.bool_(True), np.array(True)]
)
def test_what_is_no_whole_number_of_numpy_is_refused(other):
    with pytest.raises(ArgumentError, match="iterations: expected a whole number, found"):
        validate.whole("iterations", other)
