"""A numba that does not fit is named, with those that do; and what the package leans on is written down."""

import ast
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import flowabs_nodes
from flowabs_nodes.simd import compatible

PACKAGE = Path(flowabs_nodes.__file__).parent
ROOT = PACKAGE.parent
PAGE = ROOT / "docs" / "simd.md"
LOW_LEVEL = ("lanes", "memory", "avx512")

CHANGED = """
import sys
import llvmlite.ir
import numba.extending
change = sys.argv.pop(1)
if change == "a name is missing":
    del numba.extending.lower_cast
elif change == "an attribute is missing":
    del llvmlite.ir.VectorType
elif change == "what is only used while compiling is missing":
    del llvmlite.ir.IRBuilder.shuffle_vector
elif change == "a call has changed":
    numba.extending.register_model = lambda: None
"""


@pytest.mark.parametrize(
    "change",
    [
        "a name is missing",
        "an attribute is missing",
        "a call has changed",
        "what is only used while compiling is missing",
    ],
)
def test_a_numba_that_does_not_fit_is_named_with_those_that_do(change, tmp_path):
    plate = ROOT / "docs" / "pictures" / "chelsea.png"
    run = ["run", "lines", "-i", str(plate), "-o", str(tmp_path / "lines.png")]
    use = {**os.environ, "PYTHONPATH": str(ROOT), "NUMBA_CACHE_DIR": str(tmp_path), "NUMBA_NUM_THREADS": "1"}
    done = subprocess.run(
        [sys.executable, "-c", CHANGED + "from flowabs_nodes.__main__ import script; script()", change, *run],
        env=use,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 1
    assert "Traceback" not in done.stderr
    assert re.search(r"kernels cannot be built with numba [\d.]+ and llvmlite [\d.]+ \(", done.stderr)
    assert f"works with numba{compatible.NUMBA}" in done.stderr


def test_a_stand_in_for_scipy_is_named():
    """colour-science makes one where SciPy is not installed; what is imported before does not mind."""
    code = (
        "import sys, unittest.mock as mock; sys.modules['scipy'] = mock.MagicMock()\n"
        "from flowabs_nodes import filters\n"
        "from flowabs_nodes.errors import FlowabsError\n"
        "try: filters.etf\n"
        "except FlowabsError as error: print(error.code, error.hint)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True)
    assert done.stdout.startswith("numba-misfit a package, such as colour-science, put a stand-in for SciPy")
    assert "pip install scipy" in done.stdout


@pytest.mark.parametrize("change", ["a name is missing", "an attribute is missing", "a call has changed"])
def test_so_it_is_for_who_asks_for_a_filter(change):
    code = (
        CHANGED
        + """
from flowabs_nodes import FlowabsError, filters
try:
    filters.etf
except FlowabsError as error:
    print(error)
"""
    )
    use = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, "-c", code, change], env=use, capture_output=True, text=True)
    assert re.search(r"kernels cannot be built with numba [\d.]+ and llvmlite [\d.]+ \(", done.stdout), done.stderr
    assert f"works with numba{compatible.NUMBA}" in done.stdout


def test_an_error_from_elsewhere_is_not_numba_s():
    with pytest.raises(AttributeError) as caught:
        _ = compatible.none
    assert compatible.misfit(caught.value) is None
    assert compatible.misfit(ValueError()) is None


def test_pyproject_says_the_same():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert f"numba{compatible.NUMBA}" in project["dependencies"]


def _trees():
    for file in sorted(PACKAGE.rglob("*.py")):
        yield file.relative_to(PACKAGE).as_posix(), ast.parse(file.read_text(encoding="utf-8"))


def _imports():
    """File, module and name of everything that is taken from numba and llvmlite."""
    for file, tree in _trees():
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom):
                found = [(node.module or "", alias.name) for alias in node.names]
            elif isinstance(node, ast.Import):
                found = [(alias.name, "") for alias in node.names]
            else:
                continue
            yield from ((file, *each) for each in found if re.match(r"(numba|llvmlite)\b", each[0]))


def test_numba_and_llvmlite_are_imported_by_simd_alone_and_what_is_private_by_one_file():
    assert {file.rpartition("/")[0] for file, _, _ in _imports()} == {"simd"}
    public = {"numba", "numba.extending", "llvmlite"}
    assert {file for file, module, _ in _imports() if module not in public} == {"simd/numba_internals.py"}


def _leaned_on():
    """Every name of numba and llvmlite that the package uses, as docs/simd.md has to write it."""
    for _, module, name in _imports():
        yield f"{module}.{name}".strip(".")
    for file, tree in _trees():
        folder, _, name = file.rpartition("/")
        if folder == "simd":
            yield from _options(tree) if name == "jit.py" else ()
            yield from _of_llvm(tree) if Path(name).stem in LOW_LEVEL else ()
            yield from _attributes(tree) if name == "numba_internals.py" else ()


def _options(tree):
    for node in ast.walk(tree):
        if isinstance(node, ast.Dict):
            yield from (f"{key.value}=" for key in node.keys)
        if isinstance(node, ast.Call):
            yield from (f"{keyword.arg}=" for keyword in node.keywords if keyword.arg)


def _of_llvm(tree):
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and re.match(r"llvm\.\w", str(node.value)):
            yield node.value
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            owner = {"b": "builder"}.get(node.value.id, node.value.id)
            if owner in ("context", "builder", "manager", "ir"):
                yield f"{owner}.{node.attr}"


def _attributes(tree):
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and node.attr not in ("__closure__", "cell_contents", "append"):  # Python's
            yield node.attr
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in ("hasattr", "getattr"):
            yield node.args[1].value


def test_the_page_lists_every_name_that_is_leaned_on():
    named = set(re.findall(r"`([^`]+)`", PAGE.read_text(encoding="utf-8")))
    missing = {name for name in _leaned_on() if name not in named}
    assert not missing
