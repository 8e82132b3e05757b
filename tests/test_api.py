"""What `import flowabs_nodes` promises."""

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import flowabs_nodes as fa


def test_importing_is_quick_and_loads_no_kernel():
    code = "import sys, flowabs_nodes as fa; fa.load_graph, fa.Image, fa.run, fa.filters, fa.color; "
    code += "from flowabs_nodes.nodes import catalogue; catalogue(); "
    code += "print(sorted({'numba', 'colour', 'scipy', 'dask'} & set(sys.modules)))"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"


def test_every_public_name_is_there():
    for name in fa.__all__:
        assert getattr(fa, name) is not None
    assert set(dir(fa)) >= set(fa.__all__)
    with pytest.raises(AttributeError, match="no attribute 'grahp'"):
        _ = fa.grahp


def test_the_version_is_that_of_the_project():
    project = Path(fa.__file__).parent.parent / "pyproject.toml"
    if not project.exists():
        pytest.skip("installed without its project file")
    assert tomllib.loads(project.read_text())["project"]["version"] == fa.__version__
