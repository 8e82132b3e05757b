"""``flowabs_nodes.filters`` is lazy, and a name always means the function, never the module it is in."""

import subprocess
import sys
from pathlib import Path

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


def test_no_module_beside_the_functions_has_the_name_of_one():
    """Python binds a module that is imported to its name in the package, over the function."""
    folder = Path(filters.__file__).parent
    assert not {path.stem for path in folder.iterdir()} & set(filters.__all__)


def test_a_name_of_the_package_is_always_the_function():
    code = "import flowabs_nodes.filters.lines.threshold; from flowabs_nodes import filters;"
    assert run(code + "print(*{type(getattr(filters, name)).__name__ for name in filters.__all__})") == ["function"]
