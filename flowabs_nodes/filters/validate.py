"""Check the arguments of filters. Each ArgumentError names the argument, the rule and what was found.

Arrays come back as C-contiguous float32, not copied if they are that already.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.errors import ArgumentError, nearest
from flowabs_nodes.simd.finite import is_finite, is_summable, refuse_enormous, refuse_non_finite

log = logging.getLogger("flowabs")

#: What filters call the code values that they work on.
_CODE_VALUES = ("code", "codes")


def plane(name: str, value: npt.ArrayLike, shape: tuple[int, ...] | None = None, *, check_finite: bool = True) -> Array:
    """Return ``value`` as (H, W) finite float32, H and W those of ``shape`` if given.

    ``check_finite`` is False for a filter whose compiled kernel looks at every number itself; such a filter calls
    :func:`~flowabs_nodes.simd.finite.refuse_non_finite` when the kernel found a number that is not finite.
    """
    return _fitting(name, _array(name, value, "(H, W)", lambda found: len(found) == 2, check_finite), shape)


def matte(name: str, value: npt.ArrayLike, shape: tuple[int, ...]) -> Array:
    """Return ``value`` as (H, W) float32 from 0 to 1, H and W those of ``shape``."""
    result = plane(name, value, shape)
    low, high = float(result.min()), float(result.max())
    if low < 0 or high > 1:
        message = f"{name}: expected numbers from 0 to 1, found {low:g} to {high:g}"
        raise ArgumentError(message, code="out-of-range", parameter=name)
    return result


def ids(name: str, value: npt.ArrayLike, shape: tuple[int, ...] | None = None) -> npt.NDArray[np.uint32]:
    """Return ``value`` as (H, W) uint32, whole numbers from 0 to 4294967295; H and W those of ``shape`` if given."""
    found = np.asarray(value)
    if found.ndim != 2 or found.size == 0 or found.size >= 2**29:
        raise ArgumentError(f"{name}: expected shape (H, W) with 1 to 2^29 pixels, found {found.shape}", parameter=name)
    if shape is not None and found.shape != shape[:2]:
        raise _other_size(name, found.shape, shape)
    if found.dtype.kind not in "iub":
        raise ArgumentError(
            f"{name}: expected whole numbers, found dtype {found.dtype}", code="wrong-type", parameter=name
        )
    if found.dtype != np.uint32 and (found.min() < 0 or found.max() > 2**32 - 1):
        raise ArgumentError(
            f"{name}: expected ids from 0 to 4294967295, found {found.min()} to {found.max()}",
            code="out-of-range",
            parameter=name,
        )
    return np.ascontiguousarray(found, np.uint32)


def planes(
    name: str,
    value: npt.ArrayLike,
    shape: tuple[int, ...] | None = None,
    *,
    check_finite: bool = True,
    summed: bool = False,
) -> Array:
    """Return ``value`` as (H, W, 3) finite float32; ``shape`` and ``check_finite`` as for :func:`plane`.

    ``summed`` is True for a filter whose sums would leave float32 if numbers were larger than 1.04e34
    (:data:`~flowabs_nodes.simd.finite.LARGEST`): such numbers are refused as well.
    """
    array = _array(name, value, "(H, W, 3)", lambda found: len(found) == 3 and found[2] == 3, check_finite, summed)
    return _fitting(name, array, shape)


def plane_or_planes(name: str, value: npt.ArrayLike, *, summed: bool = False) -> Array:
    """Return ``value`` as (H, W) or (H, W, 3) finite float32; ``summed`` as for :func:`planes`."""

    def fits(shape: tuple[int, ...]) -> bool:
        return len(shape) == 2 or (len(shape) == 3 and shape[2] == 3)

    return _array(name, value, "(H, W) or (H, W, 3)", fits, summed=summed)


def any_channels(name: str, value: npt.ArrayLike, *, check_finite: bool = True, summed: bool = False) -> Array:
    """Return ``value`` as (H, W) or (H, W, C) finite float32; the others are as for :func:`planes`."""
    return _array(name, value, "(H, W) or (H, W, C)", lambda shape: len(shape) in (2, 3), check_finite, summed)


def flow_field(value: npt.ArrayLike, shape: tuple[int, ...] | None = None, name: str = "flow") -> Array:
    """Return ``value`` as a flow, (H, W, 2) finite float32, x then y; H and W those of ``shape`` if given."""
    return _fitting(name, _array(name, value, "(H, W, 2)", lambda found: len(found) == 3 and found[2] == 2), shape)


def _fitting(name: str, array: Array, shape: tuple[int, ...] | None) -> Array:
    """Return ``array`` if its height and width are those of ``shape``."""
    if shape is not None and array.shape[:2] != shape[:2]:
        raise _other_size(name, array.shape, shape)
    return array


def _other_size(name: str, found: tuple[int, ...], shape: tuple[int, ...]) -> ArgumentError:
    """Return the error for an array that is not of the size of the picture."""
    return ArgumentError(
        f"{name}: expected the size of the picture, {shape[1]}x{shape[0]}, found {found[1]}x{found[0]}", parameter=name
    )


def number(
    name: str,
    value: Any,
    *,
    min: float | None = None,
    max: float | None = None,
    above: float | None = None,
) -> float:
    """Return ``value`` as a finite float of at least ``min``, at most ``max``, greater than ``above``."""
    value = _from_array(value)
    if isinstance(value, bool) or not isinstance(value, int | float | np.integer | np.floating):
        raise ArgumentError(f"{name}: expected a number, found {value!r}", code="wrong-type", parameter=name)
    result = float(value)
    rules = []
    if min is not None:
        rules.append(f"at least {min:g}")
    if above is not None:
        rules.append(f"greater than {above:g}")
    if max is not None:
        rules.append(f"at most {max:g}")
    broken = (min is not None and result < min) or (max is not None and result > max)
    if not math.isfinite(result) or broken or (above is not None and result <= above):
        rule = " and ".join(rules) or "finite"
        raise ArgumentError(f"{name}: expected a number {rule}, found {value!r}", code="out-of-range", parameter=name)
    return result


def whole(name: str, value: Any, *, min: int | None = None, max: int | None = None) -> int:
    """Return ``value`` as an int from ``min`` to ``max``; 1.0 and True are not whole numbers here."""
    value = _from_array(value)
    if isinstance(value, bool) or not isinstance(value, int | np.integer):
        raise ArgumentError(f"{name}: expected a whole number, found {value!r}", code="wrong-type", parameter=name)
    return int(number(name, value, min=min, max=max))


def _from_array(value: Any) -> Any:
    """Return the number in an array without axes, such as ``np.array(5)``; anything else as it is."""
    return value.item() if isinstance(value, np.ndarray) and value.ndim == 0 else value


def choice(name: str, value: Any, choices: tuple[str, ...]) -> str:
    """Return ``value`` if it is one of ``choices``."""
    if value not in choices:
        raise ArgumentError(
            f"{name}: expected one of {', '.join(map(repr, choices))}, found {value!r}",
            hint=nearest(value, choices),
            parameter=name,
        )
    return str(value)


def flag(name: str, value: Any) -> bool:
    """Return ``value`` if it is True or False."""
    if not isinstance(value, bool | np.bool_):
        raise ArgumentError(f"{name}: expected True or False, found {value!r}", code="wrong-type", parameter=name)
    return bool(value)


def _array(
    name: str,
    value: npt.ArrayLike,
    shapes: str,
    fits: Callable[[tuple[int, ...]], bool],
    check_finite: bool = True,
    summed: bool = False,
) -> Array:
    """Return ``value`` as float32 if its shape ``fits``; ``shapes`` says in words which shapes do."""
    array = np.asarray(value)
    if array.dtype.kind not in "fiub":
        raise ArgumentError(
            f"{name}: expected real numbers, found dtype {array.dtype}", code="wrong-type", parameter=name
        )
    if not fits(array.shape) or array.size == 0:
        raise ArgumentError(
            f"{name}: expected shape {shapes} with at least one pixel, found {array.shape}", parameter=name
        )
    if array.shape[0] * array.shape[1] >= 2**29:  # kernels count with int32, up to four floats for each pixel
        raise ArgumentError(f"{name}: expected fewer than 2^29 pixels, found {array.shape}", parameter=name)
    with np.errstate(over="ignore"):  # numbers beyond float32 become Inf
        result: Array = np.ascontiguousarray(array, np.float32)
    if check_finite and not (is_summable(result) if summed else is_finite(result)):
        refuse_non_finite(name, result)
        refuse_enormous(name, result)
    if name in _CODE_VALUES:
        _note_if_0_to_1(name, result)
    return result


def _note_if_0_to_1(name: str, codes: Array) -> None:
    """Write a line to the log where code values look as if white were 1. A picture of blacks alone does not."""
    if codes[::16, ::16].max() <= 1 and 0.5 < codes.max() <= 1 and codes.min() >= 0:
        log.warning("%s: code values look like 0..1: multiply by 255 (white is 255)", name)
