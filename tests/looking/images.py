"""Makes small images of any type to look at."""

import numpy as np

from flowabs_nodes.image import Image


def image(values, kind, channels=None):
    """Return an image of a type, of rows of pixels, each a number or several."""
    dtype = np.uint32 if kind == "id" else np.float32
    array = np.array(values, dtype)
    return Image.from_array(array if array.ndim == 3 else array[..., None], type=kind, channels=channels)
