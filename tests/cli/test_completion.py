"""What Tab offers, asked for through click's own completion."""

import os
import subprocess
import sys

import pytest
from click.shell_completion import ShellComplete

from flowabs_nodes.cli import cli


def offered(*words):
    """Return the completions of the last word, by value."""
    completion = ShellComplete(cli, {}, "flowabs", "_FLOWABS_COMPLETE")
    return {item.value: item for item in completion.get_completions(list(words[:-1]), words[-1])}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Work in a folder that holds a graph, a picture and a folder with another graph."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "shots").mkdir()
    for name in ("lily.json", "plate.exr", "shots/night.json"):
        (tmp_path / name).write_text("{}")
    return tmp_path


@pytest.mark.parametrize("command", ["run", "check"])
def test_a_graph_is_a_name_or_a_json_file(folder, command):
    assert list(offered(command, "li")) == ["lines", "lily.json"]
    assert offered(command, "lin")["lines"].help.startswith("A line drawing")
    assert list(offered(command, "fig2")) == ["fig20", "fig21", "fig24", "fig25"]
    assert {"abstraction", "lily.json", "shots/"} <= set(offered(command, ""))
    assert list(offered(command, "shots/")) == ["shots/night.json"]
    assert list(offered(command, "./l")) == ["./lily.json"]


def test_where_there_are_only_folders_the_shell_completes_them(folder):
    (item,) = offered("run", "sho").values()
    assert (item.type, item.value) == ("file", "sho")
    (item,) = offered("run", "no/such/").values()
    assert item.type == "file"


def test_set_knows_the_knobs_and_nodes_of_the_graph_on_the_line():
    assert list(offered("run", "lines", "--set", "line")) == ["line_width=", "line_amount=", "lines."]
    assert offered("run", "lines", "--set", "line_w")["line_width="].help == "Width of the ink."
    assert "levels=" in offered("run", "abstraction", "-i", "a.exr", "--set", "simplify=1", "--set", "")
    assert "levels=" not in offered("run", "lines", "--set", "")


def test_set_knows_a_nodes_parameters_mix_included():
    assert list(offered("run", "lines", "--set", "flow.r")) == ["flow.radius="]
    assert "flat.mix=" in offered("run", "flat", "--set", "flat.")
    assert offered("run", "lines", "--set", "nosuch.") == {}


@pytest.mark.parametrize(
    ("typed", "values"),
    [
        ("lines.space=", ["lines.space=lab", "lines.space=acescct"]),
        ("flow.kernel=s", ["flow.kernel=separable"]),
        ("flow.color=", ["flow.color=true", "flow.color=false"]),
        ("line_width=", ["line_width=1.0"]),
        ("lines.contrast=", []),  # null is the default, which says nothing about numbers
        ("nosuch=", []),
    ],
)
def test_set_knows_values(typed, values):
    assert list(offered("run", "lines", "--set", typed)) == values


def test_a_graph_of_ones_own_and_one_that_is_broken(folder, tmp_path):
    text = (
        '{"format": "flowabs.graph/1", "interface": {"hue": {"type": "enum", "default": "a", "choices": ["a", "b"]}}, '
    )
    (tmp_path / "own.json").write_text(text + '"nodes": {"plate": {"type": "read@1"}}}')
    assert list(offered("run", "own.json", "--set", "")) == ["hue=", "plate."]
    assert list(offered("run", "own.json", "--set", "hue=")) == ["hue=a", "hue=b"]
    for broken in ("lily.json", "gone.json", "nosuch"):
        assert offered("run", broken, "--set", "") == {}
    assert offered("run", "--set", "") == {}


@pytest.mark.parametrize(("option", "kind"), [("-i", "file"), ("-o", "file"), ("--ocio", "file"), ("--root", "dir")])
def test_the_shell_completes_files(option, kind):
    (item,) = offered("run", "lines", option, "pla").values()
    assert (item.type, item.value) == (kind, "pla")


def test_words_to_choose_from():
    assert list(offered("run", "lines", "--existing", "")) == ["resume", "overwrite", "error"]
    assert "hold" in offered("run", "lines", "--missing", "h")


def test_nodes_and_graphs():
    assert list(offered("nodes", "fd")) == ["fdog", "fdog_iterative"]
    assert list(offered("graphs", "port")) == ["portrait"]
    assert "fig07" in offered("graphs", "")


def test_it_needs_no_numba_and_no_colour_science():
    """Those take longer to import than a person waits for a completion."""
    words = {"COMP_WORDS": "flowabs run lines --set lines.s", "COMP_CWORD": "4", "_FLOWABS_COMPLETE": "zsh_complete"}
    code = "import atexit, sys; from flowabs_nodes import cli; heavy = {'numba', 'colour', 'scipy', 'cv2'}; "
    code += "atexit.register(lambda: print(sorted(heavy & set(sys.modules)))); cli.main()"
    ended = subprocess.run(
        [sys.executable, "-c", code], env={**os.environ, **words}, capture_output=True, text=True, check=True
    )
    assert "lines.sigma_c=" in ended.stdout
    assert ended.stdout.splitlines()[-1] == "[]"
