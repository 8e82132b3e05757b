"""The node in docs/add-a-node.md: it is whole, it complies, and its file alone adds it to the package."""

import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

import flowabs_nodes
from flowabs_nodes.image import Image
from flowabs_nodes.nodes import catalogue
from flowabs_nodes.nodes.declare import Context, Node, Param, Port
from flowabs_nodes.nodes.registry import GROUP
from flowabs_nodes.testing import check_node, compliance_checks

PACKAGE = Path(flowabs_nodes.__file__).parent
PAGE = (Path(__file__).resolve().parents[2] / "docs" / "add-a-node.md").read_text(encoding="utf-8")
EXAMPLE, OPERATION, COMPLIANCE = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
(ENTRY_POINT,) = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
NAMES = {}
exec(compile(EXAMPLE, "add-a-node.md", "exec"), NAMES)
NODE = NAMES["HALFTONE"]


@pytest.fixture
def extended(tmp_path):
    """Copy the package into a folder, and drop the example's file into its ``nodes/``."""
    shutil.copytree(PACKAGE, tmp_path / "flowabs_nodes", ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / "flowabs_nodes" / "nodes" / "halftone.py").write_text(EXAMPLE, encoding="utf-8")
    return tmp_path


def python(path, *arguments):
    """Run Python where ``path``, a folder or a zip, is the first place of packages; return what it printed."""
    environment = os.environ | {"PYTHONPATH": str(path), "PYTHONDONTWRITEBYTECODE": "1"}
    result = subprocess.run(
        [sys.executable, *arguments], env=environment, cwd=path.parent, capture_output=True, text=True, check=True
    )
    return result.stdout


@pytest.mark.parametrize("check", compliance_checks(NODE), ids=lambda check: check.name)
def test_it_complies(check):
    check()


def test_dots_are_as_large_as_the_picture_is_dark():
    shares = [NAMES["halftone"](np.full((80, 80), code, np.float32)).mean() for code in (0, 64, 128, 191, 255)]
    assert shares == sorted(shares)
    assert shares[0] < 0.05
    assert shares[-1] == 1


def test_the_operation_tints_what_is_decoded_and_complies():
    names = dict(NAMES)
    exec(compile(OPERATION, "add-a-node.md", "exec"), names)
    port, ink = Port("image", "color", "The picture."), Param.color("ink", (1.0, 0.5, 0.2), help="Its colour.")
    check_node(Node("tint", 1, "Tints.", (port,), (port,), (ink,), names["run_tint"]))
    image = Image.from_array(np.random.default_rng(3).random((9, 7, 3), np.float32))
    smooth = image.with_codes(image.encoded("lab"), "lab")
    found = names["run_tint"](Context(), smooth, ink=(1.0, 0.5, 0.2))
    assert found.deferred is not None
    np.testing.assert_array_equal(found.pixels, smooth.pixels * np.float32((1.0, 0.5, 0.2)))


def test_its_file_alone_adds_it_to_the_package(extended):
    listing = python(extended, "-m", "flowabs_nodes", "nodes").splitlines()
    assert [line.split("@")[0] for line in listing][-1] == "halftone"
    assert NODE.help in listing[-1]
    assert len(listing) == 1 + sum(node.run.__module__.startswith("flowabs_nodes.") for node in catalogue().values())
    assert "size: a number from 1 to 500 (px)" in python(extended, "-m", "flowabs_nodes", "nodes", "halftone")
    schema = json.loads(python(extended, "-m", "flowabs_nodes", "schema"))
    assert "halftone@1" in schema["$defs"]["node"]["properties"]["type"]["enum"]
    assert schema["$defs"]["node.halftone"]["description"] == NODE.help


def test_the_package_in_a_zip_has_it_too(extended):
    archive = shutil.make_archive(str(extended / "zipped"), "zip", extended, "flowabs_nodes")
    found = python(Path(archive), "-c", "from flowabs_nodes.nodes import catalogue; print(*catalogue())").split()
    assert found[0] == "read"
    assert "halftone" in found


def test_a_second_declaration_of_a_type_is_an_error(extended):
    (extended / "flowabs_nodes" / "nodes" / "raster.py").write_text(EXAMPLE, encoding="utf-8")
    with pytest.raises(subprocess.CalledProcessError) as caught:
        python(extended, "-m", "flowabs_nodes", "nodes")
    assert "'halftone' is declared a second time, in flowabs_nodes.nodes.raster" in caught.value.stderr


def test_the_entry_point_and_the_compliance_test_name_the_node(monkeypatch):
    points = tomllib.loads(ENTRY_POINT)["project"]["entry-points"][GROUP]
    module, _, name = points[NODE.type].partition(":")
    assert NAMES[name] is NODE
    assert f"from {module} import {name}" in COMPLIANCE
    monkeypatch.setitem(sys.modules, module.partition(".")[0], type(sys)(module.partition(".")[0]))
    monkeypatch.setitem(sys.modules, module, type(sys)(module))
    vars(sys.modules[module])[name] = NODE
    made = {}
    exec(compile(COMPLIANCE, "add-a-node.md", "exec"), made)
    assert [mark.name for mark in made["test_compliance"].pytestmark] == ["parametrize"]
