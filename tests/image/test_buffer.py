"""The memory of a host's picture, viewed as an array."""

from __future__ import annotations

import array
import ctypes
from typing import Any

import numpy as np
import pytest

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.image.buffer import picture_in

HEIGHT, WIDTH, CHANNELS = 3, 5, 4
SHAPE = (HEIGHT, WIDTH, CHANNELS)
PICTURE = np.random.default_rng(2).random(SHAPE, np.float32)


def viewed(memory: Any, shape: Any = SHAPE, row_bytes: Any = None, dtype: Any = None, rows: str = "top-down") -> Any:
    return picture_in(memory, shape, row_bytes, dtype, rows, "array")


def in_ctypes(picture: np.ndarray) -> Any:
    return (ctypes.c_float * picture.size)(*picture.ravel())


@pytest.mark.parametrize(
    ("memory", "dtype"),
    [
        (PICTURE.ravel(), None),
        (memoryview(PICTURE.tobytes()), "float32"),
        (PICTURE.tobytes(), np.float32),
        (bytearray(PICTURE.tobytes()), "f4"),
        (memoryview(PICTURE.copy()), None),
        (array.array("f", PICTURE.ravel().tolist()), None),
        (in_ctypes(PICTURE), None),
        ((ctypes.c_char * PICTURE.nbytes)(*PICTURE.tobytes()), "float32"),
        (PICTURE.ravel().tolist(), None),
        (PICTURE, None),
    ],
    ids=[
        "array",
        "memoryview",
        "bytes",
        "bytearray",
        "3-D memoryview",
        "array.array",
        "ctypes",
        "chars",
        "list",
        "3-D",
    ],
)
def test_a_flat_buffer_is_a_picture_of_its_shape(memory: Any, dtype: Any) -> None:
    found = viewed(memory, dtype=dtype)
    np.testing.assert_array_equal(found.astype(np.float32), PICTURE)
    if not isinstance(memory, list):
        view = np.asarray(memory if not isinstance(memory, bytes) else memoryview(memory))
        assert np.shares_memory(found, view), "a view, no copy"


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float16, np.float32, np.float64])
@pytest.mark.parametrize("gap", [0, 3, 40])
@pytest.mark.parametrize("behind_the_last", [True, False])
@pytest.mark.parametrize("upwards", [True, False])
def test_rows_lie_row_bytes_from_each_other(dtype: type, gap: int, behind_the_last: bool, upwards: bool) -> None:
    picture = (200 * PICTURE).astype(dtype)
    in_memory = picture[::-1] if upwards else picture
    raw = b"".join(row.tobytes() + b"\xff" * gap for row in in_memory)
    raw = raw if behind_the_last else raw[: len(raw) - gap]
    step = WIDTH * CHANNELS * np.dtype(dtype).itemsize + gap
    found = viewed(raw, row_bytes=-step if upwards else step, dtype=dtype)
    np.testing.assert_array_equal(found, picture)
    assert found.dtype == dtype


def test_bottom_up_is_a_view_that_is_turned_over() -> None:
    for memory, shape in ((PICTURE, None), (PICTURE.ravel(), SHAPE)):
        found = viewed(memory, shape, rows="bottom-up")
        np.testing.assert_array_equal(found, PICTURE[::-1])
        assert np.shares_memory(found, PICTURE)


def test_an_openfx_picture_is_the_right_way_up_whatever_the_sign_of_its_row_bytes() -> None:
    step = WIDTH * CHANNELS * 4
    lowest_first = np.ascontiguousarray(PICTURE[::-1]).ravel()
    np.testing.assert_array_equal(viewed(lowest_first, row_bytes=step, rows="bottom-up"), PICTURE)
    np.testing.assert_array_equal(viewed(PICTURE.ravel(), row_bytes=-step, rows="bottom-up"), PICTURE)


def test_what_is_written_to_the_view_is_in_the_buffer() -> None:
    memory = bytearray(HEIGHT * 24)
    viewed(memory, (HEIGHT, WIDTH, CHANNELS), row_bytes=-24, dtype=np.uint8)[0, 0] = (1, 2, 3, 4)
    assert memory[48:52] == bytes((1, 2, 3, 4))
    assert sum(memory) == 10
    assert not viewed(bytes(60), dtype="uint8").flags.writeable


def test_a_shape_without_channels_has_one() -> None:
    assert viewed(np.zeros(15), (3, 5)).shape == (3, 5, 1)
    assert viewed(np.zeros((3, 5)), None).shape == (3, 5, 1)


FLAT = PICTURE.ravel()


@pytest.mark.parametrize(
    ("arguments", "parameter", "message"),
    [
        ({"memory": FLAT, "shape": None}, "array", r"found float32 \(60,\) \(of a flat buffer, shape="),
        ({"memory": PICTURE.tobytes(), "shape": None}, "array", r"of a flat buffer, shape=\(height, width, channels\)"),
        ({"memory": [[1, 2], [3]], "shape": None}, "array", "NumPy cannot read it: .*inhomogeneous"),
        ({"memory": FLAT[:-1]}, "array", r"expected 240 bytes for shape \(3, 5, 4\) of float32, found 236 bytes$"),
        ({"memory": FLAT, "shape": (3, 5, 3)}, "array", "expected 180 bytes"),
        (
            {"memory": PICTURE.tobytes()},
            "array",
            r'expected 60 bytes .* found 240 bytes \(it would fit dtype="float32"',
        ),
        ({"memory": PICTURE.tobytes() + b"1", "dtype": "float32"}, "array", "expected 240 bytes .* found 241 bytes"),
        ({"memory": FLAT, "row_bytes": 100}, "array", "expected 280 to 300 bytes"),
        ({"memory": FLAT, "row_bytes": 79}, "row_bytes", "at least 80, a row of 5 x 4 float32, found 79"),
        ({"memory": FLAT, "row_bytes": -79}, "row_bytes", "found -79"),
        ({"memory": FLAT, "row_bytes": 80.0}, "row_bytes", r"row_bytes: expected whole numbers, found 80\.0"),
        ({"memory": PICTURE, "shape": None, "row_bytes": 80}, "row_bytes", "expected a flat buffer and its shape"),
        ({"memory": PICTURE, "shape": None, "dtype": "uint8"}, "dtype", "expected that of the array, float32"),
        ({"memory": FLAT, "dtype": "float64"}, "dtype", "expected that of the buffer, float32, found float64"),
        ({"memory": PICTURE.tobytes(), "dtype": "flaot32"}, "dtype", "found 'flaot32' .did you mean 'float32'"),
        ({"memory": FLAT, "shape": (60,)}, "shape", r"expected \(height, width\) or .* found \(60,\)"),
        ({"memory": FLAT, "shape": 60}, "shape", "found 60"),
        ({"memory": FLAT, "shape": (3, 0, 4)}, "shape", r"found \(3, 0, 4\)"),
        ({"memory": FLAT, "shape": "3x5"}, "shape", "whole numbers"),
        ({"memory": FLAT[::2], "shape": (3, 5, 2)}, "array", r"without gaps .* strides \(8,\)"),
        ({"memory": FLAT.astype(complex)}, "array", "expected real numbers, found complex128"),
        ({"memory": PICTURE, "shape": None, "rows": "bottomup"}, "rows", "found 'bottomup' .did you mean 'bottom-up'"),
    ],
)
def test_what_does_not_fit_is_said(arguments: dict[str, Any], parameter: str, message: str) -> None:
    with pytest.raises(ArgumentError, match=message) as error:
        viewed(**arguments)
    assert error.value.parameter == parameter
