"""The graphs of the paper's figures, run on drawings and on the photographs of the documentation."""

from __future__ import annotations

import flowabs_nodes as fa
from flowabs_nodes.io.read import read_image
from flowabs_nodes.io.settings import Settings
from tools.gallery import drawings, inputs

PHOTOGRAPHS = ("chelsea.png", "coffee.exr", "astronaut.jpg")


def run(name, plate, *outputs):
    """Outputs of a shipped graph, by name; ``plate`` is a drawing or an Image."""
    if not isinstance(plate, fa.Image):
        plate = fa.Image.from_array(drawings.scene_linear(plate), colorspace="lin_rec709")
    results = fa.load_graph(name).run(given={"plate": plate}, outputs=list(outputs))
    return {output: results[output].pixels.squeeze() for output in outputs}


def photograph(name):
    return read_image(inputs.pictures() / name, settings=Settings(), note=str, warn=str)


def code(name):
    """Lightness of a photograph in code values."""
    return photograph(name).encoded_mono("lab", ground=1.0)
