"""The nodes that come with the package, in the order the catalogue shows them."""

from __future__ import annotations

from flowabs_nodes.nodes.baselines import BILATERAL, BILATERAL_ORIENTED, CANNY, MEAN_SHIFT
from flowabs_nodes.nodes.composite import COMPOSITE
from flowabs_nodes.nodes.declare import Node
from flowabs_nodes.nodes.flow import ETF, FLOW_BLUR, FLOW_COLOR, LIC
from flowabs_nodes.nodes.lines import DOG, FDOG, FDOG_ITERATIVE
from flowabs_nodes.nodes.matte import MATTE
from flowabs_nodes.nodes.read import READ, READ_AOV
from flowabs_nodes.nodes.smooth import BLUR, FBL
from flowabs_nodes.nodes.tone import EXPOSURE, QUANTIZE
from flowabs_nodes.nodes.write import WRITE

NODES: tuple[Node, ...] = (
    READ,
    READ_AOV,
    WRITE,
    MATTE,
    EXPOSURE,
    ETF,
    LIC,
    FLOW_COLOR,
    FLOW_BLUR,
    DOG,
    FDOG,
    FDOG_ITERATIVE,
    CANNY,
    FBL,
    BILATERAL,
    BILATERAL_ORIENTED,
    MEAN_SHIFT,
    QUANTIZE,
    COMPOSITE,
    BLUR,
)
