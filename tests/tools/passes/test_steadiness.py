"""Boil, change along the motion and ghosts of pictures that move by a known distance."""

from __future__ import annotations

import numpy as np
import pytest

from tools.passes.steadiness import Step, boil

HEIGHT, WIDTH, X, Y = 40, 60, 3, 2  # what is seen moves right and down


def noise(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).uniform(0, 1, (HEIGHT, WIDTH))


def moved(picture: np.ndarray) -> np.ndarray:
    return np.roll(picture, (Y, X), (0, 1))


@pytest.fixture(scope="module")
def step() -> Step:
    """Return the step between two frames of a plate of which a part becomes brighter."""
    motion = np.broadcast_to(np.float32([-X, Y, -X, Y]), (HEIGHT, WIDTH, 4))  # y up
    depth = np.full((HEIGHT, WIDTH), 5.0)
    plate = np.full((HEIGHT, WIDTH), 100.0)
    brighter = plate.copy()
    brighter[20:, 40:] = 130
    return Step.between((motion, motion), (depth, depth), (plate, brighter))


def test_boil_is_relative_to_the_ink() -> None:
    ink = np.zeros((10, 10))
    ink[5] = 1
    assert boil(ink, ink) == 0
    assert boil(ink, np.roll(ink, 3, 0)) == 2
    assert boil(ink, ink * 0.5) == pytest.approx(2 / 3)
    assert boil(ink * 0, ink * 0) == 0


def test_what_moves_along_does_not_change(step: Step) -> None:
    picture = noise(1)
    assert step.change(picture, moved(picture)) < 0.005  # the blur repeats the border, which moves
    assert step.change(picture, picture) > 0.05
    assert step.difference(picture, moved(picture)).max() < 1e-12


def test_what_comes_in_at_the_edge_is_not_compared(step: Step) -> None:
    assert not step.still[:Y].any()
    assert not step.still[:, :X].any()
    assert step.still[Y + 1 : 10, X + 1 : 30].all()


def test_what_became_brighter_is_a_change_of_the_scene(step: Step) -> None:
    assert step.changed[24:, 44:].all()
    assert not step.changed[:14, :34].any()
    assert not (step.still & step.changed).any()


def test_a_ghost_counts_where_the_scene_changed_alone(step: Step) -> None:
    alone = noise(2)
    lagging = np.where(step.changed, 0, alone)
    assert step.ghost(alone, alone) == 0
    assert step.ghost(lagging, alone) > 0.4
    assert step.ghost(np.where(step.changed | np.roll(step.changed, -6, 1), alone, 0), alone) < 0.05


def test_what_was_hidden_is_not_compared() -> None:
    still = np.zeros((HEIGHT, WIDTH, 4), np.float32)
    plate, depth, nearer = np.ones((HEIGHT, WIDTH)), np.full((HEIGHT, WIDTH), 9.0), np.full((HEIGHT, WIDTH), 9.0)
    nearer[10:20, 10:20] = 3
    step = Step.between((still, still), (nearer, depth), (plate, plate))
    assert not step.still[9:21, 9:21].any()
    assert step.still[:, 30:].all()
