"""Know the type of EXR's standard attributes, and make their values of the texts and numbers that people give."""

from __future__ import annotations

import re
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import OpenEXR


class _WrongValue(ValueError):
    """Says what was expected in place of a value."""


def standard_value(name: str, value: str | int | float) -> Any:
    """Return the value of an EXR attribute as the OpenEXR module writes it in the standard's type.

    ``name`` is the name in an EXR header. Any other attribute's value is returned as it is. Raises ValueError, which
    says what is expected, where a value cannot be of its attribute's type.
    """
    for names, make in _TYPES.items():
        if name in names:
            return make(value)
    return value


def _float(value: str | int | float) -> float:
    """Return a number, also of a text or a fraction such as "1/48"."""
    try:
        return float(Fraction(value.strip())) if isinstance(value, str) else float(value)
    except (ValueError, ZeroDivisionError):
        raise _WrongValue("a number") from None


def _int(value: str | int | float) -> int:
    """Return a whole number, also of a text."""
    number = _float(value)
    if number != int(number) or not -(2**31) <= number < 2**31:
        raise _WrongValue("a whole number")
    return int(number)


def _text(value: str | int | float) -> str:
    """Return a text, also of a number."""
    return str(value)


def _rate(value: str | int | float) -> Fraction:
    """Return frames a second as a fraction: 24, "24000/1001", and 23.976, which is 24000/1001."""
    expected = 'frames a second, such as 24 or "24000/1001"'
    try:
        rate = Fraction(value.strip()) if isinstance(value, str) else Fraction(value)
    except (ValueError, ZeroDivisionError):
        raise _WrongValue(expected) from None
    if not 0 < rate < 2**31:
        raise _WrongValue(expected)
    television = Fraction(round(rate * Fraction(1001, 1000)) * 1000, 1001)  # 24000/1001 is written as 23.976 and 23.98
    if rate.denominator not in (1, 1001) and television and abs(rate - television) < Fraction(5, 1000):
        return television
    return rate.limit_denominator(100_000)


def _timecode(value: str | int | float) -> OpenEXR.TimeCode:
    """Return the time code of "hours:minutes:seconds:frames"; ";" before the frames is drop frame."""
    found = re.fullmatch(r"(\d\d?):(\d\d?):(\d\d?)([:;.,])(\d\d?)", str(value).strip())
    if found is None:
        raise _WrongValue('a time code such as "01:00:00:00"')
    hours, minutes, seconds, frames = (int(found[i]) for i in (1, 2, 3, 5))
    if hours > 23 or minutes > 59 or seconds > 59 or frames > 59:
        raise _WrongValue('a time code such as "01:00:00:00", of at most 23:59:59:59')
    return OpenEXR.TimeCode(hours, minutes, seconds, frames, int(found[4] != ":"), *[0] * 5, *[0] * 8)


def _keycode(value: str | int | float) -> OpenEXR.KeyCode:
    """Return the key code of seven whole numbers."""
    numbers = re.findall(r"\d+", str(value))
    if len(numbers) != 7:
        raise _WrongValue("seven whole numbers, from film maker code to perforations per count")
    return OpenEXR.KeyCode(*(int(number) for number in numbers))


def _vector(value: str | int | float) -> Any:
    """Return two numbers of a text such as "0.3127, 0.329"."""
    return np.array(_numbers(value, 2), np.float32)


def _matrix(value: str | int | float) -> Any:
    """Return sixteen numbers of a text, row by row."""
    return np.array(_numbers(value, 16), np.float32).reshape(4, 4)


def _box(value: str | int | float) -> tuple[Any, Any]:
    """Return the first and the last pixel of a box: four whole numbers of a text."""
    x0, y0, x1, y1 = (_int(number) for number in _numbers(value, 4))
    return np.array([x0, y0], np.int32), np.array([x1, y1], np.int32)


def _numbers(value: str | int | float, count: int) -> list[float]:
    """Return so many numbers of a text, with spaces or commas between."""
    words = [word for word in re.split(r"[\s,]+", str(value)) if word]
    if len(words) != count:
        raise _WrongValue(f'{count} numbers in a text, such as "{" ".join(["0.5"] * min(count, 2))}"')
    return [_float(word) for word in words]


#: Names of standard attributes (OpenEXR's ImfStandardAttributes.h) -> what makes a value of their type.
_TYPES: dict[tuple[str, ...], Callable[[str | int | float], Any]] = {
    (
        *("whiteLuminance", "xDensity", "utcOffset", "longitude", "latitude", "altitude", "focus", "expTime"),
        *("aperture", "isoSpeed", "shutterAngle", "tStop", "nominalFocalLength", "pinholeFocalLength"),
        *("effectiveFocalLength", "entrancePupilOffset", "cameraCCTSetting", "cameraTintSetting", "imageRotation"),
    ): _float,
    ("imageCounter", "acesImageContainerFlag"): _int,
    ("framesPerSecond", "captureRate"): _rate,
    ("timeCode",): _timecode,
    ("keyCode",): _keycode,
    (
        *("adoptedNeutral", "sensorCenterOffset", "sensorOverallDimensions", "sensorPhotositePitch"),
        "cameraColorBalance",
    ): _vector,
    ("worldToCamera", "worldToNDC"): _matrix,
    ("originalDataWindow", "sensorAcquisitionRectangle"): _box,
    (
        *("owner", "comments", "capDate", "wrapmodes", "renderingTransform", "lookModTransform", "reelName"),
        *("cameraMake", "cameraModel", "cameraSerialNumber", "cameraFirmwareVersion", "cameraUuid", "cameraLabel"),
        *("lensMake", "lensModel", "lensSerialNumber", "lensFirmwareVersion", "ascFramingDecisionList"),
    ): _text,
}
