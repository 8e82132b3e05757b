"""Filters that are made ready ahead, and programs that fork: before, while and after another thread compiles."""

import functools
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from flowabs_nodes import filters
from flowabs_nodes.errors import ArgumentError, FlowabsError
from flowabs_nodes.filters import warming

CHECKOUT = Path(__file__).parents[2]


def test_every_filter_can_be_warmed_up():
    pictures = warming._pictures()
    filters.warm_up()
    for name in ("etf", "fdog", "xdog_rho"):
        filters.warm_up(name)
    assert {picture.shape[:2] for picture in pictures.values() if hasattr(picture, "shape")} == {(24, 40)}


@pytest.mark.parametrize(
    ("name", "option"),
    [
        ("fdog", "evidence"),
        ("fdog", "soft_lines"),
        ("fdog", "thin_lines"),
        ("fdog", "lone_lines"),
        ("quantize", "by_gradient"),
        ("stroke", "min_length"),
        ("motion_window", "depths"),
    ],
)
def test_what_is_off_by_default_is_made_ready_too(name, option, monkeypatch):
    filter, given = getattr(filters, name), {}

    @functools.wraps(filter)
    def noted(*arguments, **parameters):
        given.update(parameters)
        return filter(*arguments, **parameters)

    monkeypatch.setattr(filters, name, noted)
    filters.warm_up(name)
    assert np.all(given[option][0] if option == "depths" else given[option] > 0)


def test_a_name_that_is_no_filter_is_refused():
    with pytest.raises(ArgumentError, match=r"there is no filter .etff.*did you mean .etf."):
        filters.warm_up("etf", "etff")
    with pytest.raises(ArgumentError, match="no filter 'warm_up'"):
        filters.warm_up("warm_up")


def test_a_filter_that_cannot_run_fails_only_where_it_is_named(monkeypatch):
    def missing(code):
        raise FlowabsError("needs OpenCV", code="missing-package")

    monkeypatch.setattr(filters, "canny", missing)
    filters.warm_up()
    with pytest.raises(FlowabsError, match="needs OpenCV"):
        filters.warm_up("canny")


BEGIN = """
import os, signal, sys, threading, time
import numpy as np
import flowabs_nodes
code = np.random.default_rng(1).random((32, 48)).astype(np.float32) * 255

def work():
    from flowabs_nodes import filters
    return filters.threshold(filters.dog(code))
"""
FORK = """
children = []
for moment in range(3):
    child = os.fork()
    if child == 0:
        signal.alarm(60)
        os._exit(0 if np.array_equal(work(), work()) else 1)
    children.append(child)
    time.sleep(0.2)
sys.exit(max(os.waitpid(child, 0)[1] for child in children) and 1)
"""
#: What another thread is doing when the process forks.
MEANWHILE = {
    "nothing": "",
    "importing": "threading.Thread(target=work, daemon=True).start(); time.sleep(0.1)",
    "compiling": "flowabs_nodes.filters.dog; threading.Thread(target=work, daemon=True).start(); time.sleep(0.5)",
    "done": "work()",
    "warmed up": "from flowabs_nodes import filters; filters.warm_up('dog', 'threshold')",
}


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
@pytest.mark.parametrize("meanwhile", MEANWHILE)
def test_a_child_of_a_fork_filters_too(tmp_path, meanwhile):
    kernels = {"NUMBA_CACHE_DIR": str(tmp_path)} if meanwhile == "compiling" else {}
    environment = {**os.environ, "PYTHONPATH": str(CHECKOUT), **kernels}
    program = [sys.executable, "-W", "ignore", "-c", BEGIN + MEANWHILE[meanwhile] + FORK]
    assert subprocess.run(program, env=environment, timeout=150, check=False).returncode == 0


def test_what_numba_imports_without_its_lock_is_there_before_the_first_call():
    program = "import sys; from flowabs_nodes import filters; filters.dog; sys.exit('numpy.ma' not in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program], timeout=150, check=False).returncode == 0
