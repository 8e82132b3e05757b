"""Small pictures for the tests of comps: light below 0 and above 1, soft alpha."""

import numpy as np

from flowabs_nodes.engine.call_node import call_node
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Context


def noise(*shape, seed=1, low=-0.5, high=3.0):
    """Return random float32 numbers, of which many lie below 0 and above 1."""
    return np.random.default_rng(seed).uniform(low, high, shape).astype(np.float32)


def rgba(height=5, width=7, seed=1):
    """Return pixels whose alpha is 0 in the first column, 1 in the second, and anything between elsewhere."""
    pixels = noise(height, width, 4, seed=seed)
    pixels[..., 3] = np.random.default_rng(seed + 100).random((height, width), np.float32)
    pixels[:, 0, 3], pixels[:, 1, 3] = 0, 1
    return pixels


def at(image, x, y, width=20, height=16):
    """Return the image with its data window at (x, y) of a display window of ``width`` x ``height``."""
    spec = image.spec
    spec.x, spec.y = x, y
    spec.full_x, spec.full_y, spec.full_width, spec.full_height = 0, 0, width, height
    return Image(image.pixels, spec, image.type, colorspace=image.colorspace, origin=image.origin)


def run(node, inputs, **params):
    """Return a node's first output."""
    return next(iter(call_node(node, Context(), inputs, params).values()))
