"""The node that merges two pictures by Nuke's formulas."""

from __future__ import annotations

from flowabs_nodes.choices import MERGE_OPERATIONS
from flowabs_nodes.comp.merging import merged
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Context, Node, Param, Port
from flowabs_nodes.nodes.regions import pixelwise


def run_merge(context: Context, B: Image, A: Image, *, operation: str) -> Image:
    return merged(A, B, operation)


MERGE = Node(
    type="merge",
    version=1,
    label="Merge",
    category="merge",
    help="Merges two pictures, premultiplied, by Nuke's operations: A over B and others.",
    doc=(
        "Pictures, monos and mattes go together: two mattes make a matte, which is kept within 0 to 1, else the "
        "result is of the wider type. So the drawings of two line nodes, 1 paper and 0 ink, are joined by `min` or "
        "`multiply`. Alpha goes by the formula of the colours, so that minus makes two opaque pictures transparent. "
        "A picture without alpha is opaque inside of its data window; a mono is too, and black beyond it. A matte is "
        "its own alpha in over, under, mask and stencil; in the others it is grey and opaque, so that multiply "
        "darkens a picture and makes no hole in it. The result has the data windows of both, the display window and "
        "the metadata of B; display windows must be of one size (`reformat`). A is brought to B's colour space. "
        "Nothing is clamped. mask and mix lay the result over B, as in Nuke."
    ),
    inputs=(
        Port("B", "color|mono|matte", "The background."),
        Port("A", "color|mono|matte", "What comes over it."),
    ),
    outputs=(Port("image", "=B|A", "Both merged."),),
    params=(
        Param.enum("operation", "over", MERGE_OPERATIONS, help="What is made of A and B, with their alphas a and b."),
    ),
    run=run_merge,
    over="B",
    windows="union",
    region=pixelwise("B", "A"),
)
