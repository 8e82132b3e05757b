"""What pip installs is what a run imports: not SciPy and colour-science, which are large, and no package in secret."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "flowabs_nodes"
#: Modules whose package has another name on the registry.
PACKAGES = {"cv2": "opencv-python-headless", "dask": "distributed"}


def names(requirements: list[str]) -> set[str]:
    return {re.split(r"[^A-Za-z0-9._-]", each)[0].lower() for each in requirements}


def test_every_import_is_a_dependency() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    installed = names(project["dependencies"])
    allowed = installed | names(extras["compare"]) | names(extras["dask"]) | {"llvmlite"}  # numba's own part
    imported: set[str] = set()
    for file in PACKAGE.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                imported |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                imported.add(node.module.partition(".")[0])
    foreign = imported - set(sys.stdlib_module_names) - {"flowabs_nodes"}
    needed = {PACKAGES.get(name, name).lower() for name in foreign}
    assert needed <= allowed, f"imported, and not in pyproject.toml: {needed - allowed}"
    assert installed <= needed, f"in pyproject.toml, and never imported: {installed - needed}"
    assert not {"scipy", "colour-science"} & allowed


@pytest.mark.slow
def test_a_cartoon_without_scipy_and_colour_science() -> None:
    code = (
        "import sys; sys.modules['scipy'] = sys.modules['colour'] = None\n"
        "import numpy as np, flowabs_nodes as fa\n"
        "print(fa.abstraction(np.full((24, 32, 3), 0.18, np.float32)).shape)\n"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    assert found.stdout.strip() == "(24, 32, 3)"
