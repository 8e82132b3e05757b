"""The node that makes a picture of channels from anywhere."""

from __future__ import annotations

from flowabs_nodes.comp.shuffling import EXPECTED, Channels, shuffled, wrong_channels
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Context, Node, Param, Port
from flowabs_nodes.nodes.regions import pixelwise

_TYPES = "color|data|depth|normal|motion|flow|mono|matte"


def run_shuffle(context: Context, image: Image, other: Image | None, *, channels: Channels) -> Image:
    return shuffled(image, other, channels)


SHUFFLE = Node(
    type="shuffle",
    version=1,
    label="Shuffle",
    category="utility",
    help="Makes a picture of any channels of one image or two, and of numbers.",
    doc=(
        'As oiiotool --ch: `{"R": "Z", "G": "Z", "B": 0, "A": "other.A"}`. A name is a channel of `image`; '
        "`other.NAME` is one of `other`, `image.NAME` one of `image` whatever it is called. What is not named stays: "
        "R, G, B and A of `image`, of a mono or a matte its one channel in R, G and B. R, G and B that `image` has "
        "not are 0. Colours are not multiplied by an alpha that comes from elsewhere: `merge`, operation mask, does "
        "that. Data stays as it is: it counts as light of the image's colour space."
    ),
    inputs=(
        Port("image", _TYPES, "What to take channels from."),
        Port("other", _TYPES, "What else to take channels from.", optional=True, cut=True),
    ),
    outputs=(Port("image", "color", "R, G, B, and A where there is one."),),
    params=(
        Param.custom(
            "channels",
            {},
            schema={
                "description": EXPECTED,
                "type": "object",
                "propertyNames": {"enum": ["R", "G", "B", "A"]},
                "additionalProperties": {"type": ["string", "number"]},
                "examples": [{"R": 0}, {"A": 1}, {"R": "G", "B": "other.R"}],
            },
            parse=wrong_channels,
            help='Where R, G, B and A come from: names of channels, or numbers, such as {"A": "other.A"}.',
        ),
    ),
    run=run_shuffle,
    region=pixelwise("image", "other"),
)
