"""What `import flowabs_nodes` promises."""

import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

import flowabs_nodes as fa
from tests.engine.sequences import pixels, plate


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


def test_a_shipped_graph_from_python():
    rgb = np.random.default_rng(1).random((40, 60, 3))
    graph = fa.load_graph("abstraction")
    out = graph.run(
        frame=1,
        given={"plate": fa.Image.from_array(rgb, colorspace="lin_rec709")},
        set={"line_width": 1.5},
        outputs=["comp", "lines.response"],
    )
    assert list(out) == ["comp", "lines.response"]
    assert out["comp"].pixels.shape == (40, 60, 3)
    assert out["lines.response"].type == "mono"


def test_a_shipped_graph_over_frames(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for frame in (1001, 1002):
        plate(tmp_path / f"shot.{frame}.exr", seed=frame)
    report = fa.run("abstraction", input="shot.####.exr", output="out.####.exr", frames="1001-1100")
    assert [frame.status for frame in report.frames[:3]] == ["done", "done", "failed"]
    assert report.exit_code == 1
    assert pixels("out.1002.exr").shape == (48, 64, 7)  # the picture, and its ink as a layer
    report = fa.run("abstraction", input="shot.####.exr", output="out.####.exr")
    assert (report.counts["skipped"], report.exit_code) == (2, 0)


def test_the_version_is_that_of_the_project():
    project = Path(fa.__file__).parent.parent / "pyproject.toml"
    if not project.exists():
        pytest.skip("installed without its project file")
    assert tomllib.loads(project.read_text())["project"]["version"] == fa.__version__
