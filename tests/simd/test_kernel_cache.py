import logging
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import numba
import numpy as np
import pytest
from numba.core import event

import flowabs_nodes
from flowabs_nodes.simd import kernel_cache
from flowabs_nodes.simd.jit import kernel
from flowabs_nodes.simd.kernel_cache import KernelCache

PACKAGE = Path(flowabs_nodes.__file__).parent
ELSEWHERE = Path(__file__).parent  # a current folder from which no flowabs_nodes is to be seen
COLOR = """
import sys
import numpy as np
from numba.core import event
with event.install_recorder("numba:compile") as recorder:
    from flowabs_nodes import filters
    from flowabs_nodes.simd import kernel_cache
    filters.flow_color(np.ones((3, 3, 2), np.float32))
    filters.blur(np.ones((3, 3), np.float32))
compiled = len(recorder.buffer) // 2
assert compiled or not {"numba.np.arrayobj", "numba.np.linalg"} & set(sys.modules)  # nor SciPy with them
print(kernel_cache.VERSION, compiled)
"""


def double(values, by=2.0):
    return values * by


inner = numba.njit(double)


def outer(values):
    return inner(values, 3.0)


def fresh(function=double):
    """What ``kernel`` makes of a function of the package, in a process that has never called it."""
    dispatcher = numba.njit(function)
    dispatcher._cache = KernelCache(function)
    return dispatcher


def compiled(dispatcher, *arguments):
    """How many functions are compiled in a call."""
    with event.install_recorder("numba:compile") as recorder:
        dispatcher(*arguments)
    return len(recorder.buffer) // 2


@pytest.fixture
def folders(tmp_path, monkeypatch):
    places = [tmp_path / "package" / "kernels-new", tmp_path / "user" / "kernels-new"]
    monkeypatch.setattr(kernel_cache, "folders", lambda: places)
    return places


@pytest.fixture
def spoiled(folders):
    """Folders where nothing can be made."""

    def spoil(folder):
        folder.parent.write_text("not a folder")

    return spoil


def color(**environment):
    """Version of the kernels, and how many one call of flow_color compiles, in a process of its own."""
    use = {**os.environ, "PYTHONPATH": str(PACKAGE.parent), **environment}
    command = [sys.executable, "-c", COLOR]
    done = subprocess.run(command, cwd=ELSEWHERE, env=use, capture_output=True, text=True, check=True)
    version, count = done.stdout.split()
    return version, int(count)


def test_a_kernel_is_compiled_once(folders):
    assert compiled(fresh(), 1.5) == 1
    again = fresh()
    assert compiled(again, 1.5) == 0
    assert again(1.5) == 3.0


def test_each_signature_is_a_kernel_of_its_own(folders):
    assert compiled(fresh(), 1.5) == 1
    assert compiled(fresh(), 1) == 1
    assert len(list(folders[0].iterdir())) == 2
    assert fresh()(1.5) == 3.0
    assert fresh()(1) == 2


def test_what_a_function_encloses_belongs_to_it(folders):
    def made(by):
        def multiply(value):
            return value * by

        return fresh(multiply)

    assert [made(2.0)(1.5), made(3.0)(1.5)] == [3.0, 4.5]
    assert compiled(made(2.0), 1.5) == 0


def test_arrays_and_what_is_called_come_back(folders):
    values = np.ones(4, np.float32)
    fresh(outer)(values)
    again = fresh(outer)
    assert compiled(again, values) == 0
    np.testing.assert_array_equal(again(values), [3, 3, 3, 3])


def test_a_damaged_file_is_compiled_again(folders):
    fresh()(1.5)
    (file,) = folders[0].iterdir()
    whole = file.read_bytes()
    for content in (b"", whole[:100], whole[:200] + b"?" + whole[201:]):
        file.write_bytes(content)
        assert compiled(fresh(), 1.5) == 1
        assert compiled(fresh(), 1.5) == 0


def test_where_the_package_is_read_only_the_user_s_folder_serves(folders, spoiled):
    spoiled(folders[0])
    assert compiled(fresh(), 1.5) == 1
    assert compiled(fresh(), 1.5) == 0
    assert len(list(folders[1].iterdir())) == 1


def test_a_package_that_became_read_only_brings_its_kernels(folders):
    fresh()(1.5)
    folders.reverse()
    assert compiled(fresh(), 1.5) == 0


def test_where_nothing_can_be_written_kernels_work_and_the_log_says_so_once(folders, spoiled, caplog):
    kernel_cache._warn.cache_clear()
    for folder in folders:
        spoiled(folder)
    with caplog.at_level(logging.WARNING, "flowabs"):
        assert fresh()(1.5) == 3.0
        assert fresh()(1) == 2
    assert [record.message.partition(",")[0] for record in caplog.records] == ["compiled kernels cannot be kept"]


def test_former_versions_are_swept_but_for_the_latest(folders):
    for age in range(6):
        old = folders[0].parent / f"kernels-{age}"
        old.mkdir(parents=True)
        os.utime(old, (10_000 - age, 10_000 - age))
    (folders[0].parent / "module.pyc").touch()
    fresh()(1.5)
    left = {path.name for path in folders[0].parent.iterdir()}
    assert left == {"kernels-0", "kernels-1", "kernels-2", "kernels-3", "kernels-new", "module.pyc"}


def test_functions_elsewhere_are_not_kept(folders):
    @kernel
    def triple(value):
        return 3 * value

    assert triple(2) == 6
    assert not folders[0].exists()


def test_the_user_s_folder(monkeypatch, tmp_path):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    assert kernel_cache.user_folder() == tmp_path / "cache"
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    assert kernel_cache.user_folder() == tmp_path / ".cache"
    monkeypatch.setattr(sys, "platform", "darwin")
    assert kernel_cache.user_folder() == tmp_path / "Library" / "Caches"


def test_beside_the_package_and_then_the_user_s_or_where_numba_is_told(monkeypatch, tmp_path):
    name = f"kernels-{kernel_cache.VERSION}"
    monkeypatch.setattr(kernel_cache.config, "CACHE_DIR", "")
    monkeypatch.setattr(kernel_cache, "user_folder", lambda: tmp_path)
    assert kernel_cache.folders() == [PACKAGE / "__pycache__" / name, tmp_path / "flowabs" / name]
    monkeypatch.setattr(kernel_cache, "user_folder", lambda: Path("~"))
    assert kernel_cache.folders() == [PACKAGE / "__pycache__" / name]
    monkeypatch.setattr(kernel_cache.config, "CACHE_DIR", str(tmp_path / "told"))
    assert kernel_cache.folders() == [tmp_path / "told" / "flowabs" / name]


def test_processes_share_kernels_and_may_write_at_once(tmp_path):
    use = {**os.environ, "PYTHONPATH": str(PACKAGE.parent), "NUMBA_CACHE_DIR": str(tmp_path)}
    command = [sys.executable, "-c", COLOR]
    several = [subprocess.Popen(command, cwd=ELSEWHERE, env=use, stdout=subprocess.PIPE, text=True) for _ in range(3)]
    for process in several:
        process.communicate()
        assert process.returncode == 0
    assert color(NUMBA_CACHE_DIR=str(tmp_path))[1] == 0
    assert not list(tmp_path.rglob("*.tmp"))


def test_the_portable_path_has_kernels_of_its_own(tmp_path):
    first, _ = color(NUMBA_CACHE_DIR=str(tmp_path), FLOWABS_SIMD="portable")
    again, count = color(NUMBA_CACHE_DIR=str(tmp_path), FLOWABS_SIMD="portable")
    assert (first, count) == (again, 0)
    if kernel_cache.PATH != "portable":
        assert color(NUMBA_CACHE_DIR=str(tmp_path))[0] != first


def test_a_change_of_any_source_makes_another_version(tmp_path):
    versions = []
    for change in ("", "# a change"):
        archive = tmp_path / f"package{len(versions)}.zip"
        with zipfile.ZipFile(archive, "w") as package:  # read-only by nature
            for file in sorted(PACKAGE.rglob("*.py")):
                text = file.read_text(encoding="utf-8") + (change if file.name == "exponential.py" else "")
                package.writestr(str(file.relative_to(PACKAGE.parent)), text)
        use = {"PYTHONPATH": str(archive), "XDG_CACHE_HOME": str(tmp_path), "NUMBA_CACHE_DIR": ""}
        versions.append(color(**use)[0])
        assert color(**use) == (versions[-1], 0)
    assert versions[0] != versions[1]
