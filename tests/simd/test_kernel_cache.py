import logging
import os
import pickle
import shutil
import subprocess
import sys
import threading
import time
import zipfile
from pathlib import Path

import numba
import numpy as np
import pytest
from numba.core import event

import flowabs_nodes
from flowabs_nodes.simd import cache_folder, compile_turn, kernel_version
from flowabs_nodes.simd.cache_folder import Place
from flowabs_nodes.simd.jit import kernel
from flowabs_nodes.simd.kernel_cache import OneFileEach, _checksum
from flowabs_nodes.simd.target import PATH

PACKAGE = Path(flowabs_nodes.__file__).parent
ELSEWHERE = Path(__file__).parent  # a current folder from which no flowabs_nodes is to be seen
COLOR = """
import sys
import numpy as np
from numba.core import event
with event.install_recorder("numba:compile") as recorder:
    from flowabs_nodes import filters
    from flowabs_nodes.simd import kernel_version
    filters.flow_color(np.ones((3, 3, 2), np.float32))
compiled = len(recorder.buffer) // 2
assert compiled or not {"numba.np.arrayobj", "numba.np.linalg"} & set(sys.modules)  # nor SciPy with them
kept = [each.data["dispatcher"]._cache for _, each in recorder.buffer if each.is_start]
print(kernel_version.VERSION, compiled, *[each.name for each in kept if hasattr(each, "name")])
"""
SEVERAL = COLOR.replace(
    "import kernel_version\n", "import kernel_version\n    filters.blur(np.ones((3, 3), np.float32))\n"
)


def double(values, by=2.0):
    return values * by


inner = numba.njit(double)


def outer(values):
    return inner(values, 3.0)


def fresh(function=double):
    """What ``kernel`` makes of a function of the package, in a process that has never called it."""
    dispatcher = numba.njit(function)
    dispatcher._cache = OneFileEach(function)
    return dispatcher


def compiled(dispatcher, *arguments):
    """How many functions are compiled in a call."""
    with event.install_recorder("numba:compile") as recorder:
        dispatcher(*arguments)
    return len(recorder.buffer) // 2


@pytest.fixture
def folders(tmp_path, monkeypatch):
    places = [Place(named, named / "kernels-new") for named in (tmp_path / "package", tmp_path / "user")]
    monkeypatch.setattr(cache_folder, "places", lambda: places)
    cache_folder.warn.cache_clear()
    return [place.folder for place in places]


@pytest.fixture
def spoiled(folders):
    """Folders where nothing can be made."""

    def spoil(folder):
        folder.parent.write_text("not a folder")

    return spoil


def kernels(folder):
    return sorted(folder.glob("*.kernel"))


def color(**environment):
    """Version of the kernels, and how many one call of flow_color compiles, in a process of its own."""
    use = {**os.environ, "PYTHONPATH": str(PACKAGE.parent), **environment}
    command = [sys.executable, "-c", COLOR]
    done = subprocess.run(command, cwd=ELSEWHERE, env=use, capture_output=True, text=True, check=True)
    version, count = done.stdout.split()[:2]
    return version, int(count)


def test_a_kernel_is_compiled_once(folders):
    assert compiled(fresh(), 1.5) == 1
    again = fresh()
    assert compiled(again, 1.5) == 0
    assert again(1.5) == 3.0


def test_each_signature_is_a_kernel_of_its_own(folders):
    assert compiled(fresh(), 1.5) == 1
    assert compiled(fresh(), 1) == 1
    assert len(kernels(folders[0])) == 2
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


def other_kernel(whole):
    """A whole file, of another kernel."""
    data = pickle.dumps(("another signature", []))
    return _checksum(data) + data


@pytest.mark.parametrize(
    "damage",
    [
        pytest.param(lambda whole: b"", id="empty"),
        pytest.param(lambda whole: bytes(4), id="four zero bytes"),
        pytest.param(lambda whole: whole[:100], id="cut short"),
        pytest.param(lambda whole: whole[:200] + b"?" + whole[201:], id="one byte"),
        pytest.param(lambda whole: _checksum(b"nonsense") + b"nonsense", id="no pickle"),
        pytest.param(other_kernel, id="another kernel"),
    ],
)
def test_a_damaged_file_moves_all_away_and_everything_is_compiled_again(folders, caplog, damage):
    fresh()(1.5)
    (file,) = kernels(folders[0])
    fresh()(1)
    file.write_bytes(damage(file.read_bytes()))
    with caplog.at_level(logging.WARNING, "flowabs"):
        assert compiled(fresh(), 1.5) == 1
    (record,) = caplog.records
    assert record.message.startswith("a compiled kernel could not be loaded")
    (aside,) = folders[0].parent.glob("kernels-new-damaged-*")
    assert str(aside) in record.message
    assert len(kernels(aside)) == 2
    assert compiled(fresh(), 1.5) == 0
    assert compiled(fresh(), 1) == 1


def test_a_damaged_folder_that_cannot_be_moved_is_left_alone(folders, monkeypatch, caplog):
    fresh()(1.5)
    kernels(folders[0])[0].write_bytes(bytes(4))
    monkeypatch.setattr(cache_folder, "_left_alone", set())

    def refuse(self, to):
        raise PermissionError("read-only")

    monkeypatch.setattr(Path, "rename", refuse)
    assert compiled(fresh(), 1.5) == 1
    assert [record.message.partition(" (")[0] for record in caplog.records] == ["a compiled kernel could not be loaded"]
    assert compiled(fresh(), 1.5) == 0
    assert len(kernels(folders[1])) == 1


def test_where_the_package_is_read_only_the_user_s_folder_serves(folders, spoiled):
    spoiled(folders[0])
    assert compiled(fresh(), 1.5) == 1
    assert compiled(fresh(), 1.5) == 0
    assert len(kernels(folders[1])) == 1


def test_a_package_that_became_read_only_brings_its_kernels(folders):
    fresh()(1.5)
    folders.reverse()
    assert compiled(fresh(), 1.5) == 0


def test_where_nothing_can_be_written_kernels_work_and_the_log_says_so_once(folders, spoiled, caplog):
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
    assert cache_folder.user_folder() == tmp_path / "cache"
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    assert cache_folder.user_folder() == tmp_path / ".cache"
    monkeypatch.setattr(sys, "platform", "darwin")
    assert cache_folder.user_folder() == tmp_path / "Library" / "Caches"


def test_beside_the_package_and_then_the_user_s_or_where_numba_is_told(monkeypatch, tmp_path):
    def found():
        return [place.folder for place in cache_folder.places()]

    name = f"kernels-{kernel_version.VERSION}"
    monkeypatch.setattr(cache_folder.config, "CACHE_DIR", "")
    monkeypatch.setattr(cache_folder, "user_folder", lambda: tmp_path)
    assert found() == [PACKAGE / "__pycache__" / name, tmp_path / "flowabs" / name]
    monkeypatch.setattr(cache_folder, "user_folder", lambda: Path("~"))
    assert found() == [PACKAGE / "__pycache__" / name]
    monkeypatch.setattr(cache_folder.config, "CACHE_DIR", str(tmp_path / "told"))
    assert found() == [tmp_path / "told" / "flowabs" / name]


def test_several_first_runs_at_once_compile_each_kernel_once(tmp_path):
    use = {**os.environ, "PYTHONPATH": str(PACKAGE.parent), "NUMBA_CACHE_DIR": str(tmp_path)}
    command = [sys.executable, "-c", SEVERAL]
    several = [subprocess.Popen(command, cwd=ELSEWHERE, env=use, stdout=subprocess.PIPE, text=True) for _ in range(4)]
    said = [process.communicate()[0] for process in several]
    assert [process.returncode for process in several] == [0, 0, 0, 0]
    (folder,) = (tmp_path / "flowabs").iterdir()
    compiled = [name for each in said for name in each.split()[2:]]
    assert len(compiled) == len(kernels(folder)) > 1
    assert color(NUMBA_CACHE_DIR=str(tmp_path))[1] == 0
    assert not list(folder.glob("*.tmp"))


def test_the_portable_path_has_kernels_of_its_own(tmp_path):
    first, _ = color(NUMBA_CACHE_DIR=str(tmp_path), FLOWABS_SIMD="portable")
    again, count = color(NUMBA_CACHE_DIR=str(tmp_path), FLOWABS_SIMD="portable")
    assert (first, count) == (again, 0)
    if PATH != "portable":
        assert color(NUMBA_CACHE_DIR=str(tmp_path))[0] != first


def test_a_change_of_any_source_makes_another_version(tmp_path):
    versions = []
    for change in ("", "# a change"):
        archive = tmp_path / f"package{len(versions)}.zip"
        with zipfile.ZipFile(archive, "w") as package:  # read-only by nature
            for file in sorted(PACKAGE.rglob("*.py")):
                text = file.read_text(encoding="utf-8") + (change if file.name == "elementary.py" else "")
                package.writestr(str(file.relative_to(PACKAGE.parent)), text)
        use = {"PYTHONPATH": str(archive), "XDG_CACHE_HOME": str(tmp_path), "NUMBA_CACHE_DIR": ""}
        versions.append(color(**use)[0])
        assert color(**use) == (versions[-1], 0)
    assert versions[0] != versions[1]


def test_a_line_changed_in_a_kernel_s_file_or_in_one_it_is_made_of_is_compiled_anew(tmp_path):
    package = tmp_path / "flowabs_nodes"
    shutil.copytree(PACKAGE, package, ignore=shutil.ignore_patterns("__pycache__"))
    part, whole = package / "color" / "added_part.py", package / "filters" / "added_kernel.py"
    head = "from flowabs_nodes.simd.jit import inlined, kernel\n"
    part.write_text(head + "@inlined\ndef twice(x):\n    return 2 * x\n")
    head += "from flowabs_nodes.color.added_part import twice\n"
    whole.write_text(head + "@kernel\ndef calculate(x):\n    return twice(x) + 1\n")
    code = """
from numba.core import event
from flowabs_nodes.filters.added_kernel import calculate
with event.install_recorder("numba:compile") as recorder:
    result = calculate(10)
print(len(recorder.buffer) > 0, result)
"""
    use = {**os.environ, "PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path / "kernels")}

    def run():
        command = [sys.executable, "-c", code]
        return subprocess.run(command, cwd=ELSEWHERE, env=use, capture_output=True, text=True, check=True).stdout

    def change(file, old, new):
        later = file.stat().st_mtime + 2
        file.write_text(file.read_text().replace(old, new))
        os.utime(file, (later, later))  # Python knows its own bytecode by whole seconds, and by the size

    assert [run(), run()] == ["True 21\n", "False 21\n"]
    change(part, "2 * x", "3 * x")
    assert [run(), run()] == ["True 31\n", "False 31\n"]
    change(whole, "+ 1", "+ 5")
    assert [run(), run()] == ["True 35\n", "False 35\n"]
    change(part, "3 * x", "2 * x")
    change(whole, "+ 5", "+ 1")
    assert run() == "False 21\n"  # kernels of a few former versions stay


def test_version_knows_which_file_holds_what(tmp_path):
    def version(**contents):
        folder = tmp_path / str(len(list(tmp_path.iterdir())))
        for name, text in contents.items():
            file = folder / f"{name}.py"
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text)
        return list(kernel_version.sources(folder))

    assert version(**{"a/x": "1", "b/x": "2"}) == [("a/x.py", b"1"), ("b/x.py", b"2")]
    assert version(**{"a/x": "1", "b/x": "2"}) != version(**{"a/x": "2", "b/x": "1"})


def give_to(uid, *paths):
    try:
        for path in paths:
            os.chown(path, uid, -1)
    except PermissionError:
        pytest.skip("only root may give a folder away")


POSIX = pytest.mark.skipif(os.name == "nt", reason="no owners to be looked at")


@POSIX
@pytest.mark.parametrize("which", ["named", "kernels"])
def test_a_folder_of_another_user_is_not_read_and_not_written(folders, caplog, which):
    fresh()(1.5)
    give_to(4711, folders[0] if which == "kernels" else folders[0].parent)
    shutil.rmtree(folders[1].parent, ignore_errors=True)
    folders[1].parent.write_text("not a folder")
    before = sorted(folders[0].iterdir())
    assert compiled(fresh(), 1.5) == 1
    assert compiled(fresh(), 1) == 1
    assert sorted(folders[0].iterdir()) == before
    (record,) = caplog.records
    assert "belongs to another user" in record.message


@POSIX
@pytest.mark.parametrize("mode", [0o775, 0o757, 0o1777])
def test_a_folder_that_others_can_write_to_does_not_count(folders, mode):
    fresh()(1.5)
    folders[0].chmod(mode)
    assert compiled(fresh(), 1.5) == 1
    assert len(kernels(folders[1])) == 1


@POSIX
def test_nor_one_in_a_folder_where_anybody_could_replace_it(folders, tmp_path):
    fresh()(1.5)
    tmp_path.chmod(0o777)
    assert cache_folder.readable() == []
    tmp_path.chmod(0o1777)  # as /tmp: to all, but each only to their own
    assert cache_folder.readable() == [folders[0]]


@POSIX
def test_a_file_of_another_user_is_not_read(folders):
    fresh()(1.5)
    give_to(4711, *kernels(folders[0]))
    assert compiled(fresh(), 1.5) == 1


@POSIX
def test_what_is_made_belongs_to_the_user_alone_whatever_the_process_allows(folders):
    before = os.umask(0)
    try:
        fresh()(1.5)
    finally:
        os.umask(before)
    assert not any(path.stat().st_mode & 0o022 for path in (folders[0].parent, folders[0], *folders[0].iterdir()))


def test_the_turn_goes_with_the_process_that_holds_it(tmp_path):
    file = tmp_path / "a.turn"
    code = f"""
import sys, time
from pathlib import Path
from flowabs_nodes.simd import compile_turn
compile_turn.take(Path({str(file)!r}))
print("mine", flush=True)
time.sleep(600)
"""
    use = {**os.environ, "PYTHONPATH": str(PACKAGE.parent)}
    holder = subprocess.Popen([sys.executable, "-c", code], env=use, stdout=subprocess.PIPE, text=True)
    assert holder.stdout.readline() == "mine\n"
    threading.Timer(0.3, holder.kill).start()
    begin = time.monotonic()
    compile_turn.take(file)
    assert 0.2 < time.monotonic() - begin < 30
    assert holder.wait(60) != 0
    holder.stdout.close()
    compile_turn.give(file)


def test_nobody_waits_for_ever(tmp_path, monkeypatch):
    monkeypatch.setattr(compile_turn, "PATIENCE", 0.05)
    monkeypatch.setattr(compile_turn, "_lock", lambda fd: False)
    begin = time.monotonic()
    compile_turn.take(tmp_path / "a.turn")
    assert 0.05 <= time.monotonic() - begin < 30
    compile_turn.give(tmp_path / "a.turn")


NAMES_TAKEN = """
import sys
import numba.core.caching as caching, numba.core.compiler as compiler, numba.core.runtime as runtime
name = sys.argv[1]
whole, own = compiler.CompileResult, caching.CompileResultCacheImpl
if name == "_Cache":
    del caching._Cache
elif name == "initialize":
    runtime.rtsys = object()
elif name == "_rebuild":  # under another name from now on, which numba itself knows
    rebuild = whole._rebuild
    del whole._rebuild
    own.rebuild = lambda self, context, payload: rebuild(context, *payload)
elif name == "_reduce":
    reduce = whole._reduce
    del whole._reduce
    own.reduce = lambda self, compiled: reduce(compiled)
elif name == "both, and numba itself does not know":
    del whole._reduce, whole._rebuild
"""


@pytest.mark.parametrize("name", ["_Cache", "_rebuild", "_reduce", "initialize"])
def test_where_numba_has_changed_inside_its_own_cache_serves(tmp_path, name):
    use = {**os.environ, "PYTHONPATH": str(PACKAGE.parent), "NUMBA_CACHE_DIR": str(tmp_path)}
    code = NAMES_TAKEN + COLOR.replace("assert compiled or not", "True or not")

    def run():
        done = subprocess.run(
            [sys.executable, "-c", code, name], cwd=ELSEWHERE, env=use, capture_output=True, text=True
        )
        assert done.returncode == 0, done.stderr
        assert done.stderr == ""
        return int(done.stdout.split()[1])

    assert run() > 0
    assert run() == 0
    assert bool(list(tmp_path.rglob("*.nbi"))) == (name != "_Cache")
    if name == "_rebuild":
        next(tmp_path.rglob("*.nbi")).write_bytes(bytes(4))
        done = subprocess.run(
            [sys.executable, "-c", code, name], cwd=ELSEWHERE, env=use, capture_output=True, text=True
        )
        assert done.returncode == 0, done.stderr
        assert done.stderr.count("a compiled kernel could not be loaded") == 1
        run()  # what had been loaded before the damage was found
        assert run() == 0


def test_where_even_numba_s_own_cache_fails_kernels_still_run(tmp_path):
    use = {**os.environ, "PYTHONPATH": str(PACKAGE.parent), "NUMBA_CACHE_DIR": str(tmp_path)}
    code = NAMES_TAKEN + COLOR.replace("assert compiled or not", "True or not")
    command = [sys.executable, "-c", code, "both, and numba itself does not know"]
    for _ in range(2):
        done = subprocess.run(command, cwd=ELSEWHERE, env=use, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        assert done.stderr.count("\n") == 1
        assert "compiled kernels cannot be kept" in done.stderr
