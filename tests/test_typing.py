"""What a type checker knows of the public API, in a script of somebody who has installed the package."""

import os
import subprocess
import sys
import venv
from pathlib import Path

import pytest

import flowabs_nodes as fa

pytest.importorskip("mypy")
pytestmark = pytest.mark.slow

SCRIPT = """\
import numpy as np
import flowabs_nodes as fa
from flowabs_nodes import filters

graph = fa.load_graph("abstraction")
plate = fa.Image.from_array(np.zeros((8, 8, 3)), colorspace="lin_rec709")
out = graph.run(given={"plate": plate, "flow": np.zeros((8, 8, 2))}, set={"line_width": 1.5}, outputs=["comp"])
report = fa.run("abstraction", input="shot.####.exr", output="out.####.exr", frames="1001-1100")
drawn = fa.lines(np.zeros((8, 8, 3), np.uint8), line_width=1.5)
smooth = filters.fbl(fa.color.encode(out["comp"].pixels), filters.etf(np.zeros((8, 8))))
"""

#: What each expression is, as mypy says it.
KNOWN = {
    "graph": "RunnableGraph",
    "plate": "Image",
    "plate.spec": "OpenImageIO.ImageSpec",
    "out": "dict[str, flowabs_nodes.image.image.Image]",
    "report": "Report",
    "report.frames[0].error": "FlowabsError | None",
    "report.counts": "dict[str, int]",
    "graph.with_set({})": "RunnableGraph",
    "fa.__version__": "str",
    "plate.to_array(out=bytearray(768))": "bytearray",
}
#: Expressions that are arrays of one dtype, by its name in mypy's answer.
ARRAYS = {"out['comp'].pixels": "32", "np.asarray(plate)": "32", "drawn": "8", "fa.flat(drawn)": "8", "smooth": "32"}

WRONG = """\
fa.grahp
filters.etff
fa.color.encoed
fa.load_graph(3)
fa.Image.from_array(np.zeros(3), colorspce="sRGB")
fa.Image.from_array(b"", shape=(1, 1, 4)).to_array(rows=1)
graph.run(given={"plate": "plate.exr"})
fa.lines("plate.exr")
"""


@pytest.fixture(scope="module")
def mypy(tmp_path_factory):
    """Return a function that checks a script; the package, and all others, are found as they are when installed."""
    folder = tmp_path_factory.mktemp("user")
    venv.create(folder / "venv", with_pip=False)
    (site,) = (folder / "venv").rglob("site-packages")
    installed = [path for path in sys.path if Path(path).name in ("site-packages", "dist-packages")]
    (site / "installed.pth").write_text("\n".join([str(Path(fa.__file__).parents[1]), *installed]))
    python = next(path for path in (folder / "venv").rglob("python*") if path.stem == "python")

    env = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "MYPYPATH")}

    def check(script):
        (folder / "script.py").write_text(script)
        command = [sys.executable, "-m", "mypy", "--strict", "--python-executable", str(python), "script.py"]
        ended = subprocess.run(command, cwd=folder, capture_output=True, text=True, env=env)
        return ended.stdout

    return check


def test_a_users_script_passes_the_strictest_check(mypy):
    assert mypy(SCRIPT) == "Success: no issues found in 1 source file\n"


def test_what_comes_back_has_a_type(mypy):
    said = mypy(SCRIPT + "".join(f"reveal_type({each})\n" for each in (*KNOWN, *ARRAYS)))
    revealed = [line.partition('Revealed type is "')[2] for line in said.splitlines() if "Revealed" in line]
    assert len(revealed) == len(KNOWN) + len(ARRAYS), said
    for (expression, expected), found in zip((KNOWN | ARRAYS).items(), revealed, strict=True):
        assert expected in found, (expression, found)
        assert "dtype[Any]" not in found.replace(" ", ""), (expression, found)


def test_names_that_do_not_exist_are_errors(mypy):
    said = mypy(SCRIPT + WRONG)
    first = len(SCRIPT.splitlines()) + 1
    wrong = {int(line.split(":")[1]) for line in said.splitlines() if ": error:" in line}
    assert wrong == set(range(first, first + len(WRONG.splitlines()))), said


def test_the_package_says_that_it_has_types():
    assert (Path(fa.__file__).parent / "py.typed").is_file()
