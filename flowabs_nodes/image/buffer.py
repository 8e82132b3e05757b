"""View the memory in which a host holds a picture as an array (H, W, C), to read from or to write to, without a copy.

A host holds an array, or a flat buffer: the numbers of row after row, perhaps with a gap between the rows.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from flowabs_nodes.errors import ArgumentError, nearest
from flowabs_nodes.file_choices import ROWS

#: The data types that raw bytes may turn out to be, for the hint of an error.
_USUAL = (np.uint8, np.uint16, np.float16, np.float32, np.float64)


def picture_in(
    memory: Any, shape: Sequence[int] | None, row_bytes: int | None, dtype: npt.DTypeLike | None, rows: str, name: str
) -> npt.NDArray[Any]:
    """Return a view of a picture (H, W, C), its top row first; a copy only of what NumPy cannot view.

    Parameters
    ----------
    memory
        An array (H, W) or (H, W, C); or with ``shape`` a flat buffer: a 1-D array, bytes, a memoryview, or any other
        object with the buffer protocol.
    shape
        (H, W) or (H, W, C) of the picture in a flat buffer.
    row_bytes
        How many bytes of a flat buffer lie from the start of a row to that of the next, negative where the first row
        is the last in memory. None: the rows follow each other without gaps.
    dtype
        The data type of the numbers in a buffer of bytes.
    rows
        "top-down", or "bottom-up" where the first row is the lowest of the picture.
    name
        The argument that ``memory`` came from, for errors.

    Raises
    ------
    ArgumentError
        No numbers of such a shape, a buffer of another length, ``row_bytes`` that are shorter than a row, ``shape``,
        ``row_bytes`` or ``dtype`` that do not fit ``memory``; words that ``rows`` does not know.
    """
    if rows not in ROWS:
        raise ArgumentError(
            f"rows: expected {' or '.join(map(repr, ROWS))}, found {rows!r}", hint=nearest(rows, ROWS), parameter="rows"
        )
    if shape is None:
        picture = _array(memory, row_bytes, dtype, name)
    else:
        picture = _rows(*_raw(memory, dtype, name), _checked(shape), row_bytes, name)
    picture = picture if picture.ndim == 3 else picture[..., None]
    return picture[::-1] if rows == "bottom-up" else picture


def _array(memory: Any, row_bytes: int | None, dtype: npt.DTypeLike | None, name: str) -> npt.NDArray[Any]:
    """Return an array (H, W) or (H, W, C) of numbers, of what NumPy can read."""
    picture = _read(memory, name)
    if picture.ndim not in (2, 3) or picture.size == 0 or picture.dtype.kind not in "fiub":
        flat = picture.ndim == 1 or isinstance(memory, bytes | bytearray)
        raise ArgumentError(
            f"expected numbers of shape (H, W) or (H, W, C), found {picture.dtype} {picture.shape}",
            hint="of a flat buffer, shape=(height, width, channels)" if flat else "",
            parameter=name,
        )
    if row_bytes is not None:
        raise ArgumentError(
            f"row_bytes: expected a flat buffer and its shape, found an array {picture.shape}, which knows its strides",
            parameter="row_bytes",
        )
    if dtype is not None and data_type(dtype) != picture.dtype:
        raise ArgumentError(f"dtype: expected that of the array, {picture.dtype}, found {dtype}", parameter="dtype")
    return picture


def _read(memory: Any, name: str) -> npt.NDArray[Any]:
    """Return whatever NumPy reads as an array; raise ArgumentError for the rest."""
    try:
        return np.asarray(memory)
    except (TypeError, ValueError, RuntimeError) as error:  # a ragged list, a tensor on a graphics card
        raise ArgumentError(f"{name}: NumPy cannot read it: {error}", code="wrong-type", parameter=name) from error


def _raw(memory: Any, dtype: npt.DTypeLike | None, name: str) -> tuple[npt.NDArray[np.uint8], np.dtype[Any]]:
    """Return the bytes of a flat buffer, and the data type of its numbers: ``dtype``, where it holds bytes."""
    try:
        flat = memory if isinstance(memory, np.ndarray) else np.asarray(memoryview(memory))
    except (TypeError, ValueError, BufferError):  # a list, a tensor: what NumPy itself can read
        flat = _read(memory, name)
    if not flat.flags.c_contiguous:
        raise ArgumentError(
            f"expected a flat buffer without gaps between its numbers, found {flat.dtype} {flat.shape}, "
            f"strides {flat.strides}",
            hint="an array (H, W, C) with strides needs no shape",
            parameter=name,
        )
    found = np.dtype(np.uint8) if flat.dtype.kind in "SV" and flat.dtype.itemsize == 1 else flat.dtype
    wanted = found if dtype is None else data_type(dtype)
    if wanted != found and found.itemsize > 1:
        raise ArgumentError(f"dtype: expected that of the buffer, {found}, found {wanted}", parameter="dtype")
    if wanted.kind not in "fiub":
        raise ArgumentError(f"expected real numbers, found {wanted}", code="wrong-type", parameter=name)
    return flat.reshape(-1).view(np.uint8), wanted


def _rows(
    raw: npt.NDArray[np.uint8], dtype: np.dtype[Any], shape: tuple[int, ...], row_bytes: int | None, name: str
) -> npt.NDArray[Any]:
    """Return the picture of ``shape`` whose rows lie ``row_bytes`` from each other in the bytes of a flat buffer."""
    height, row = shape[0], math.prod(shape[1:]) * dtype.itemsize
    step = row if row_bytes is None else _whole(row_bytes, "row_bytes")
    if abs(step) < row:
        raise ArgumentError(
            f"row_bytes: expected at least {row}, a row of {' x '.join(map(str, shape[1:]))} {dtype}, found {step}",
            parameter="row_bytes",
        )
    least, most = (height - 1) * abs(step) + row, height * abs(step)  # the gap behind the last row may be missing
    if not least <= raw.size <= most:
        bytes_ = f"{least}" if least == most else f"{least} to {most}"
        raise ArgumentError(
            f"expected {bytes_} bytes for shape {shape} of {dtype}, found {raw.size} bytes",
            hint=_fitting(raw.size, shape) if row_bytes is None else "",
            parameter=name,
        )
    start = (height - 1) * -step if step < 0 else 0
    strides = (step, *(math.prod(shape[axis + 1 :]) * dtype.itemsize for axis in range(1, len(shape))))
    return np.ndarray(shape, dtype, raw, start, strides)


def _fitting(size: int, shape: tuple[int, ...]) -> str:
    """Return a hint: the data type of which a picture of this shape takes ``size`` bytes; "" where none does."""
    count = math.prod(shape)
    fitting = [np.dtype(each).name for each in _USUAL if count * np.dtype(each).itemsize == size]
    return f'it would fit dtype="{fitting[-1]}"' if fitting else ""


def _checked(shape: Sequence[int]) -> tuple[int, ...]:
    """Return ``shape`` as two or three numbers above 0. Raises ArgumentError."""
    sizes: tuple[Any, ...] = tuple(shape) if isinstance(shape, Iterable) else (shape,)
    if len(sizes) not in (2, 3) or any(_whole(size, "shape") < 1 for size in sizes):
        raise ArgumentError(
            f"shape: expected (height, width) or (height, width, channels), found {shape!r}", parameter="shape"
        )
    return tuple(_whole(size, "shape") for size in sizes)


def _whole(value: Any, name: str) -> int:
    """Return a whole number; raise ArgumentError for anything else."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer):
        raise ArgumentError(f"{name}: expected whole numbers, found {value!r}", code="wrong-type", parameter=name)
    return int(value)


def data_type(dtype: npt.DTypeLike) -> np.dtype[Any]:
    """Return a data type; raise ArgumentError for what is none of real numbers."""
    try:
        found = np.dtype(dtype)
    except TypeError:
        found = np.dtype(object)
    if found.kind not in "fiub":
        raise ArgumentError(
            f"dtype: expected a data type of real numbers, found {dtype!r}",
            hint=nearest(dtype, [np.dtype(each).name for each in _USUAL]),
            parameter="dtype",
        )
    return found
