"""The graphs in graphs/paper carry the values that the paper prints."""

import numpy as np
import pytest

from flowabs_nodes import graph
from flowabs_nodes.engine import load_graph
from flowabs_nodes.graph.shipped import paper
from flowabs_nodes.image import Image

FIGURES = "01 03 04 05 07 08 09 10 11_13 14 16 17 18 19 20 21 24 25"
MEAN_SHIFT = {"spatial": 10, "range": 5, "min_region": 20}


def bilateral(iterations):
    return {"sigma_d": 2, "sigma_r": 10, "iterations": iterations, "kernel": "full"}


def fbl(sigma_e, r_e, sigma_g, r_g, iterations):
    return {"sigma_e": sigma_e, "r_e": r_e, "sigma_g": sigma_g, "r_g": r_g, "iterations": iterations}


#: By figure and node: what captions and text print.
PRINTED = {
    "fig07": {
        "fdog": {"sigma_m": 3.0, "sigma_c": 1.0, "rho": 0.99},
        "sigma_m_1": {"sigma_m": 1.0, "sigma_c": 1.0, "rho": 0.99},
        "sigma_c_2": {"sigma_m": 3.0, "sigma_c": 2.0, "rho": 0.99},
        "rho_997": {"sigma_m": 3.0, "sigma_c": 1.0, "rho": 0.997},
    },
    "fig09": {"dog_low": {"tau": 0.2}, "dog_high": {"tau": 0.7}, "fdog": {"tau": 0.2}},
    "fig10": {"flow_3": {"radius": 3}, "flow_5": {"radius": 5}},
    "fig11_13": {"first": {"iterations": 1}, "third": {"iterations": 3}},
    "fig16": {"bilateral": bilateral(5), "fbl": fbl(2, 50, 2, 10, 5)},
    "fig17": {"bilateral": bilateral(3), "fbl": fbl(2, 50, 0.3, 10, 3)},
    "fig18": {"bilateral": bilateral(3), "fbl": fbl(2, 10, 0.3, 10, 5)},
    "fig19": {
        "bilateral": bilateral(3),
        "xy": {**bilateral(3), "kernel": "xy"},
        "fbl": fbl(2, 10, 2, 10, 3),
        **{f"{name}_flat": {"levels": 4} for name in ("bilateral", "xy", "fbl")},
    },
    "fig21": {"mean_shift": MEAN_SHIFT, "bilateral": bilateral(3), "fbl": fbl(2, 50, 0.3, 10, 5)},
}
#: Section 5 and the text: what a node has wherever the figure prints nothing else.
DEFAULTS = {
    "etf": {"radius": 5, "iterations": 3, "kernel": "full", "gradient_reference": "max", "fill": 0, "adaptive": False},
    "dog": {"sigma_c": 1, "rho": 0.99, "tau": 0.5},
    "fdog": {"sigma_m": 3, "sigma_c": 1, "rho": 0.99, "tau": 0.5},
    "fdog_iterative": {"sigma_m": 3, "sigma_c": 1, "rho": 0.99, "tau": 0.5},
    "fbl": {"sigma_e": 2, "r_e": 10, "sigma_g": 0.5, "r_g": 10, "iterations": 5},
    "mean_shift": MEAN_SHIFT,
}
#: Figures that print nothing and show what they show with values of their own.
OWN = {
    ("fig04", "flow_1"),
    ("fig04", "flow_2"),
    ("fig05", "flow_separable"),
    ("fig08", "flow"),
    ("fig08", "dog"),
    ("fig08", "fdog"),
    ("fig08", "third"),
    ("fig09", "flow"),
    ("fig09", "dog_low"),
    ("fig09", "dog_high"),
    ("fig09", "dog_best"),
    ("fig09", "fdog"),
    ("fig10", "flow_adaptive"),
    ("fig20", "curve"),
}


def test_there_is_a_graph_for_each_figure():
    assert {f"fig{name}" for name in FIGURES.split()} <= set(paper())


@pytest.mark.parametrize("name", sorted(paper()))
def test_each_is_valid_and_described(name):
    assert graph.check(paper()[name]) == []
    loaded = graph.load(name)
    assert loaded.name == name
    assert loaded.description.endswith(".")
    assert loaded.reference_size is None  # lengths are as printed


@pytest.mark.parametrize(("name", "node"), [(name, node) for name in PRINTED for node in PRINTED[name]])
def test_values_are_the_printed_ones(name, node):
    values = graph.load(name).values(1)[node]
    assert {key: values[key] for key in PRINTED[name][node]} == PRINTED[name][node]


@pytest.mark.parametrize("name", [f"fig{name}" for name in FIGURES.split()])
def test_all_else_has_the_default_values(name):
    loaded = graph.load(name)
    for node, values in loaded.values(1).items():
        printed = PRINTED.get(name, {}).get(node, {})
        for key, value in DEFAULTS.get(loaded.nodes[node].declaration.type, {}).items():
            if key not in printed and (name, node) not in OWN:
                assert values[key] == value, (node, key)


@pytest.mark.parametrize("name", sorted(paper()))
def test_each_runs_on_any_plate(name):
    runnable = load_graph(name)
    if {"canny", "mean_shift"} & {node.declaration.type for node in runnable.nodes.values()}:
        pytest.importorskip("cv2")
    y, x = np.mgrid[:36, :52] / 8
    plate = Image.from_array(np.stack([np.sin(x) + 1.1, np.cos(y) + 1.1, np.sin(x + y) + 1.1], 2).astype(np.float32))
    made = runnable.run(given={"plate": plate}, on_event=lambda event: None)
    assert len(made) == len(runnable.nodes["out"].inputs)
    for image in made.values():
        assert image.data_window == plate.data_window
        assert np.isfinite(image.pixels).all()
