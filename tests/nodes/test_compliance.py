"""Every installed node passes the compliance suite."""

import pytest

from flowabs_nodes.nodes import catalogue
from flowabs_nodes.testing import compliance_checks

CHECKS = [
    pytest.param(check, id=f"{node.type}-{check.name}")
    for node in catalogue().values()
    for check in compliance_checks(node)
]


@pytest.mark.parametrize("check", CHECKS)
def test_compliance(check):
    check()
