"""Transfer functions that picture files name: powers, curves of ICC profiles, and those of video (ITU-T H.273)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flowabs_nodes.array_types import Float64


@dataclass(frozen=True)
class Power:
    """linear = codes to the power of ``gamma``; mirrored below 0."""

    gamma: float

    def linear(self, codes: Float64) -> Float64:
        return np.copysign(np.abs(codes) ** self.gamma, codes)

    def codes(self, linear: Float64) -> Float64:
        return np.copysign(np.abs(linear) ** (1 / self.gamma), linear)


@dataclass(frozen=True)
class Parametric:
    """linear = (a codes + b)^g + e where codes >= d, else c codes + f (ICC.1:2022, 10.18)."""

    g: float
    a: float = 1.0
    b: float = 0.0
    c: float = 0.0
    d: float = 0.0
    e: float = 0.0
    f: float = 0.0

    def linear(self, codes: Float64) -> Float64:
        curve = np.maximum(self.a * codes + self.b, 0) ** self.g + self.e
        return np.where(codes >= self.d, curve, self.c * codes + self.f)

    def codes(self, linear: Float64) -> Float64:
        start = max(self.a * self.d + self.b, 0) ** self.g + self.e
        curve = (np.maximum(linear - self.e, 0) ** (1 / self.g) - self.b) / self.a
        line = (linear - self.f) / self.c if self.c else np.full_like(linear, self.d)
        return np.where(linear >= start, curve, line)


#: sRGB (IEC 61966-2-1).
SRGB = Parametric(2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045)


@dataclass(frozen=True)
class Sampled:
    """Linear light at equal steps of codes 0..1, straight lines between; the last lines go on beyond 0 and 1."""

    values: tuple[float, ...]

    def linear(self, codes: Float64) -> Float64:
        return _through(codes, np.linspace(0, 1, len(self.values)), np.array(self.values))

    def codes(self, linear: Float64) -> Float64:
        values = np.array(self.values)
        rising = np.concatenate([[True], np.diff(np.maximum.accumulate(values)) > 0])  # no step back, no level part
        return _through(linear, values[rising], np.linspace(0, 1, len(values))[rising])


def _through(at: Float64, x: Float64, y: Float64) -> Float64:
    """Interpolate the points (x, y), and extrapolate by the first and the last line."""
    result = np.interp(at, x, y)
    first, last = (y[1] - y[0]) / (x[1] - x[0]), (y[-1] - y[-2]) / (x[-1] - x[-2])
    result = np.where(at < x[0], y[0] + (at - x[0]) * first, result)
    return np.asarray(np.where(at > x[-1], y[-1] + (at - x[-1]) * last, result))


#: Luminance of diffuse white in PQ pictures, cd/m2, and the HLG code of diffuse white (ITU-R BT.2408): both become 1.
PQ_WHITE, HLG_WHITE = 203.0, 0.75


@dataclass(frozen=True)
class Pq:
    """SMPTE ST 2084, of ITU-R BT.2100: 203 cd/m2 is 1."""

    def linear(self, codes: Float64) -> Float64:
        e = np.maximum(codes, 0) ** (1 / _M2)
        return 10000 / PQ_WHITE * (np.maximum(e - _C1, 0) / (_C2 - _C3 * e)) ** (1 / _M1)

    def codes(self, linear: Float64) -> Float64:
        y = np.clip(linear * (PQ_WHITE / 10000), 0, 1) ** _M1
        return ((_C1 + _C2 * y) / (1 + _C3 * y)) ** _M2


_M1, _M2 = 2610 / 16384, 2523 / 4096 * 128
_C1, _C2, _C3 = 3424 / 4096, 2413 / 4096 * 32, 2392 / 4096 * 32


@dataclass(frozen=True)
class Hlg:
    """Hybrid log-gamma of ITU-R BT.2100, without its display's curve: scene light, 1 at the code .75."""

    def linear(self, codes: Float64) -> Float64:
        return np.asarray(_hlg_scene(codes) / _HLG_WHITE_SCENE)

    def codes(self, linear: Float64) -> Float64:
        e = np.maximum(linear, 0) * _HLG_WHITE_SCENE
        return np.where(e <= 1 / 12, np.sqrt(3 * e), _A * np.log(np.maximum(12 * e - _B, 1e-9)) + _C)


_A = 0.17883277
_B = 1 - 4 * _A
_C = 0.5 - _A * math.log(4 * _A)
_HLG_WHITE_SCENE = (math.exp((HLG_WHITE - _C) / _A) + _B) / 12


def _hlg_scene(codes: Float64) -> Float64:
    """Return scene light, 0..1, of HLG codes 0..1."""
    codes = np.maximum(codes, 0)
    return np.where(codes <= 0.5, codes**2 / 3, (np.exp((codes - _C) / _A) + _B) / 12)
