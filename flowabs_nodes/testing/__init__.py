"""Holds every node, ours or a plugin's, to what all nodes promise: the compliance suite.

::

    import pytest
    from flowabs_nodes.testing import compliance_checks
    from my_package import MY_NODE

    @pytest.mark.parametrize("check", compliance_checks(MY_NODE), ids=lambda check: check.name)
    def test_compliance(check):
        check()

Or, without pytest, ``check_node(MY_NODE)``. It asks of a node that

- it is documented, every port and parameter too, and its defaults and soft ranges lie inside the hard ones;
- it runs with its defaults on any picture: colour, noise, alpha, HDR, 1x1, 1xN, Nx1, and for each type its ports take;
- each parameter changes the key and, on some picture and perhaps with other parameters set, the result; one with
  ``enabled_when`` changes neither where that does not hold;
- where it declares a ``region``, filtering the crop to it and cutting to the window gives the bits of the whole result;
- windows, metadata and colour space are kept, and its inputs are left as they were;
- NaN and Inf give a clean error, or stay in the pixels where they were;
- an output comes out the same whether asked for alone or with others, a second time, and on any number of threads;
- a node that reads other frames asks for them by the rules, does without those beyond the ends of a sequence, and gives
  the same for a frame alone, in a run, and in another order, in which each frame of its inputs is computed once;
- a node that mixes gives the input where mask or mix is 0, the result where both are 1, and never a mean of ids.

Nodes that read or write files are held to what does not need a picture's content.
"""

from flowabs_nodes.testing.running import ComplianceError
from flowabs_nodes.testing.suite import Check, check_node, compliance_checks

__all__ = ["Check", "ComplianceError", "check_node", "compliance_checks"]
