"""``flowabs_nodes.filters`` is lazy, and a name always means the function, never the module it is in."""

import subprocess
import sys

import pytest

from flowabs_nodes import filters


@pytest.mark.parametrize("name", filters.__all__)
def test_every_name_is_a_documented_function(name):
    function = getattr(filters, name)
    assert callable(function)
    assert function.__name__ == name
    assert function.__doc__
    assert name in dir(filters)


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'etff'"):
        _ = filters.etff


def run(code):
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()


def test_importing_the_package_does_not_import_numba():
    assert run("import sys; from flowabs_nodes import filters; print('numba' in sys.modules)") == ["False"]


def test_importing_a_module_first_does_not_hide_its_function():
    code = "import flowabs_nodes.filters.gaussian, flowabs_nodes.filters.threshold; from flowabs_nodes import filters;"
    assert run(code + "print(type(filters.threshold).__name__, type(filters.gaussian).__name__)") == [
        "function",
        "module",
    ]
