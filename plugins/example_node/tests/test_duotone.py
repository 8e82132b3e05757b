"""Every node should pass the compliance suite; what is special about yours comes after."""

import numpy as np
import pytest
from flowabs_duotone import DUOTONE

import flowabs_nodes as fa
from flowabs_nodes.testing import compliance_checks


@pytest.mark.parametrize("check", compliance_checks(DUOTONE), ids=lambda check: check.name)
def test_compliance(check):
    check()


def test_black_is_shadows_and_white_is_highlights():
    graph = fa.load_graph(
        {
            "format": "flowabs.graph/1",
            "nodes": {
                "plate": {"type": "read@1"},
                "print": {
                    "type": "duotone@1",
                    "inputs": {"image": "plate"},
                    "params": {"shadows": [0.1, 0, 0], "highlights": [0, 0, 2]},
                },
            },
        }
    )
    picture = np.stack([np.zeros((4, 4, 3)), np.ones((4, 4, 3))]).reshape(8, 4, 3)
    out = graph.run(given={"plate": fa.Image.from_array(picture)}, outputs=["print"])["print"].pixels
    np.testing.assert_allclose(out[0, 0], [0.1, 0, 0], atol=1e-5)
    np.testing.assert_allclose(out[-1, -1], [0, 0, 2], atol=1e-4)
