import pickle

import pytest

from flowabs_nodes.image import Window
from flowabs_nodes.nodes.regions import pixelwise, within
from flowabs_nodes.nodes.registry import builtin

NODES = {node.type: node for node in builtin()}
WINDOW = Window(-3, 5, 7, 2)


def halo_of_size(params):
    return params["size"]


def test_a_halo_is_added_to_every_side_of_each_input():
    region = within(halo_of_size, "image", "flow")
    assert region({"size": 4}, WINDOW) == dict.fromkeys(("image", "flow"), Window(-7, 1, 15, 10))


def test_a_pixelwise_node_reads_the_window_itself():
    assert pixelwise("image")({}, WINDOW) == {"image": WINDOW}


def test_a_halo_of_none_is_the_whole_picture():
    assert within(halo_of_size, "image")({"size": None}, WINDOW) == {}


def test_a_region_can_be_sent_to_another_process():
    region = pickle.loads(pickle.dumps(within(halo_of_size, "image")))
    assert region({"size": 1}, WINDOW) == {"image": Window(-4, 4, 9, 4)}


def region_of(type, **params):
    node = NODES[type]
    return node.region(node.defaults() | params, WINDOW)


def test_a_flow_needs_the_whole_picture_for_statistics_and_fill():
    local = {"gradient_reference": 16.0, "fill": None}
    around = Window(-3 - 13, 5 - 13, 7 + 26, 2 + 26)
    assert region_of("etf", **local) == dict.fromkeys(("image", "mask", "edge_strength", "edge_flow"), around)
    for change in ({"gradient_reference": "max"}, {"gradient_reference": "p99"}, {"fill": 0.0}, {"adaptive": True}):
        assert region_of("etf", **local | change) == {}


def test_nodes_that_look_at_the_whole_picture_have_no_region():
    without = {type for type, node in NODES.items() if node.inputs and node.outputs and node.region is None}
    assert without == {"lic", "canny", "mean_shift", "reformat", "aov_lines", "optical_flow", "motion_window"}


@pytest.mark.parametrize("type", ["fdog", "fdog_iterative"])
def test_evidence_reads_further_along_the_flow(type):
    plain, further = (region_of(type, sigma_m=2.0, evidence=e)["image"].width for e in (0.0, 0.5))
    assert further == plain + 2 * (3 * 3 * 2 + 1)
