"""The bundle that flowabs openfx build makes, and its command."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from flowabs_nodes.cli import main
from flowabs_nodes.cli.openfx import openfx
from flowabs_nodes.errors import CommandError
from flowabs_nodes.graph.shipped import shipped
from flowabs_nodes.openfx import bundle
from tests.openfx.conftest import PANEL, compiler

ROOT = Path(__file__).resolve().parents[2]

needs_compiler = pytest.mark.skipif(not compiler(), reason="there is no C compiler (CC, cc or gcc)")


def test_what_is_in_a_bundle(library):
    contents = library.parents[1]
    assert library.parent.name == bundle.ARCHITECTURES.get(sys.platform, ("?",))[0] or sys.platform == "linux"
    assert json.loads((contents / "Resources" / "effects.json").read_text())["format"] == "flowabs.openfx/1"
    python, *place = (contents / "Resources" / "server.txt").read_text().splitlines()
    clean = {name: value for name, value in os.environ.items() if name not in bundle.HOST_VARIABLES}
    clean |= {"PYTHONPATH": place[0]} if place else {}
    words = [python, "-P", "-c", "import flowabs_nodes; print(flowabs_nodes.__file__)"]
    found = subprocess.run(words, env=clean, capture_output=True, text=True, check=True).stdout.strip()
    assert Path(found).parent == Path(bundle.flowabs_nodes.__file__).parent
    left = sorted(path.relative_to(contents).as_posix() for path in contents.rglob("*") if path.is_file())
    assert left == sorted([f"{library.parent.name}/Flowabs.ofx", "Resources/effects.json", "Resources/server.txt"])


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads the symbols of ELF")
def test_the_library_gives_hosts_two_functions_and_no_more(library):
    nm = subprocess.run(["nm", "-D", "--defined-only", str(library)], capture_output=True, text=True, check=True).stdout
    assert re.findall(r" T (\w+)", nm) == ["OfxGetNumberOfPlugins", "OfxGetPlugin"]


@needs_compiler
@pytest.mark.parametrize("standard", ["-std=c99", "-std=c11"])
def test_the_source_compiles_without_a_warning(standard, tmp_path):
    flags = ["-Wall", "-Wextra", "-Wshadow", "-Wconversion", "-Werror", standard]
    assert bundle.build(tmp_path, [], flags)[1] == []


def test_every_function_of_the_source_says_what_it_does():
    silent = []
    for path in sorted(bundle.source_folder().glob("*.c")):
        lines = path.read_text(encoding="utf-8").splitlines()
        for number, line in enumerate(lines[1:], start=1):
            defines = re.match(r"(?:static |OfxExport )?[\w *]+\b(\w+)\([^;]*$", line) and not line.startswith(
                (" ", "#", "/")
            )
            if defines and not lines[number - 1].rstrip().endswith("*/"):
                silent.append(f"{path.name}:{number + 1}: {line}")
    assert silent == []


@needs_compiler
def test_refresh_describes_new_graphs_and_touches_the_library(tmp_path, monkeypatch):
    made, _ = bundle.build(tmp_path / "plugins", [])
    library = next(made.glob("Contents/*/Flowabs.ofx"))
    os.utime(library, (1, 1))
    graphs = tmp_path / "graphs"
    graphs.mkdir()
    (graphs / "panel.json").write_text(json.dumps(PANEL))
    monkeypatch.setenv("FLOWABS_GRAPHS", str(graphs))
    done = CliRunner().invoke(openfx, ["refresh", "--out", str(tmp_path / "plugins")])
    assert (done.exit_code, done.output) == (0, f"{made}\n")
    effects = json.loads((made / "Contents" / "Resources" / "effects.json").read_text())["effects"]
    assert len(effects) == len(shipped()) + 1
    assert library.stat().st_mtime > 1e9


def test_refresh_without_a_bundle_says_what_makes_one(tmp_path):
    with pytest.raises(CommandError, match="no bundle is there") as error:
        bundle.refresh(tmp_path)
    assert "flowabs openfx build" in error.value.hint


def test_without_a_compiler_one_sentence_says_so(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("CC", "no-such-cc")
    assert main(["openfx", "build", "--out", str(tmp_path)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("flowabs: no C compiler: no-such-cc is not found (install one")


def test_a_compiler_that_fails_is_quoted(tmp_path, monkeypatch):
    script = tmp_path / "cc"
    script.write_text("#!/bin/sh\necho 'flowabs_ofx.c:1: error: of its own' >&2\nexit 1\n")
    script.chmod(0o755)
    monkeypatch.setenv("CC", f"{script} -m64")
    with pytest.raises(CommandError, match="error: of its own"):
        bundle.build(tmp_path / "out", [])
    assert not list((tmp_path / "out").rglob("*.ofx"))


@needs_compiler
def test_a_folder_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    assert main(["openfx", "build", "--out", str(tmp_path / "file")]) == 1


def test_path_is_where_bundles_are_built(monkeypatch, tmp_path):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("USERPROFILE", str(tmp_path))
    assert CliRunner().invoke(openfx, ["path"]).output == f"{tmp_path / 'OFX' / 'Plugins'}\n"


def test_the_source_travels_in_the_wheel():
    import tomllib

    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    included = settings["tool"]["hatch"]["build"]["targets"]["wheel"]["force-include"]
    assert included["plugins/openfx"] == "flowabs_nodes/openfx/source"
    assert (ROOT / "plugins" / "openfx" / "flowabs_ofx.c").is_file()
