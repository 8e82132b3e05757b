"""Lines against true edges: a ring whose width and place are known."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tools.passes.edges import SCALE, Truth, mean, table

SIZE, RADIUS = 96, 30.0
CENTRE = SIZE / 2


@pytest.fixture(scope="module")
def truth() -> Truth:
    """Return a disc in front of nothing, and a straight crease across it."""
    radius, y, x = _polar(SIZE * SCALE, SCALE)
    off = radius - RADIUS * SCALE
    silhouette = np.abs(off) < 0.6
    crease = (np.abs(y + 0.5) < 0.6) & (off < -8 * SCALE)
    at = np.nonzero(silhouette)
    return Truth(silhouette, crease, np.stack([x[at], y[at]], 1) / radius[at][:, None])


def _polar(size: int, scale: int = 1) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    y, x = np.indices((size, size)) + 0.5 - CENTRE * scale
    return np.hypot(x, y), y, x


def ring(inner: float, width: float) -> np.ndarray:
    """Return lines: an anti-aliased ring from a radius inwards by ``width`` pixels."""
    radius, _, _ = _polar(SIZE)
    depth = inner - radius
    return 1 - np.clip(np.minimum(depth, width - depth) + 0.5, 0, 1)


@pytest.mark.parametrize("width", [1.0, 2.0, 3.0])
def test_a_line_inside_of_the_silhouette(truth: Truth, width: float) -> None:
    found = truth.compare(ring(RADIUS, width))
    assert found.recall == 1
    assert found.crease == 0
    assert found.width == pytest.approx(width, abs=0.08)
    assert found.spread < 0.2
    assert found.inner > 0.9
    assert found.double == 0


def test_a_line_outside_is_not_on_the_surface_in_front(truth: Truth) -> None:
    assert truth.compare(ring(RADIUS + 2, 2)).inner < 0.25


def test_ink_far_from_any_edge_costs_precision(truth: Truth) -> None:
    lines = np.minimum(ring(RADIUS, 2), ring(RADIUS + 10, 2))
    found = truth.compare(lines)
    assert 0.3 < found.precision < 0.5
    assert truth.compare(ring(RADIUS, 2)).precision == pytest.approx(1, abs=0.05)


def test_two_lines_at_one_edge_are_double(truth: Truth) -> None:
    lines = np.minimum(ring(RADIUS, 1), ring(RADIUS + 3, 1))
    assert truth.compare(lines).double > 0.9


def test_the_crease(truth: Truth) -> None:
    lines = np.ones((SIZE, SIZE))
    lines[SIZE // 2 - 1 : SIZE // 2 + 1] = 0
    assert truth.compare(lines).crease == 1


def test_no_ink_has_no_width(truth: Truth) -> None:
    found = truth.compare(np.ones((SIZE, SIZE)))
    assert (found.recall, found.ink) == (0, 0)
    assert np.isnan([found.precision, found.width, found.double]).all()
    whole = truth.compare(ring(RADIUS, 2))
    assert mean([found, whole]).width == whole.width
    assert "0.000" in table({"7": found})


def test_a_file_of_truth(truth: Truth, tmp_path: Path) -> None:
    path = tmp_path / "edges.0007.npz"
    np.savez(
        path,
        silhouette=np.packbits(truth.silhouette),
        crease=np.packbits(truth.crease),
        shape=truth.crease.shape,
        outward=np.rint(truth.outward * 127).astype(np.int8),
    )
    read = Truth.load(path)
    np.testing.assert_array_equal(read.silhouette, truth.silhouette)
    np.testing.assert_array_equal(read.crease, truth.crease)
    assert np.abs(read.outward - truth.outward).max() < 0.01
