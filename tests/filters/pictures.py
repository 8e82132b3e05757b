"""Pictures that the filters are tested on, as float32 code values 0 to 255."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio

DATA = Path(__file__).parent.parent / "data"


def photo() -> npt.NDArray[np.float32]:
    """Return a photograph of a cat's eye, (64, 64, 3)."""
    pixels = oiio.ImageInput.open(str(DATA / "chelsea_eye.png")).read_image("uint8")
    return np.asarray(pixels, np.float32)


def noise(height: int = 60, width: int = 41, seed: int = 0) -> npt.NDArray[np.float32]:
    """Return white noise, (H, W)."""
    return np.random.default_rng(seed).uniform(0, 255, (height, width)).astype(np.float32)
