"""Completion in the shells themselves; bash is run where there is one."""

import os
import shutil
import subprocess
import sys

import pytest

from flowabs_nodes.cli import cli
from flowabs_nodes.cli.shells import VARIABLE, Bash, Fish, Zsh


def completed(shell, monkeypatch, words, index):
    monkeypatch.setenv("COMP_WORDS", "\n".join(words))
    monkeypatch.setenv("COMP_CWORD", str(index))
    return shell(cli, {}, "flowabs", VARIABLE).complete().splitlines()


@pytest.mark.parametrize(
    ("words", "lines"),
    [
        (["flowabs", "run", "lines", "--set", "line_w"], ["plain,line_width="]),
        (["flowabs", "run", "lines", "--set", "flow.kernel", "="], ["plain,full", "plain,separable"]),
        (["flowabs", "run", "lines", "--set", "flow.kernel", "=", "s"], ["plain,separable"]),
        (["flowabs", "run", "lines", "--set", "line_width", "=", "2", "--set", "simp"], ["plain,simplify="]),
        (["flowabs", "run", "lines", "--existing", "=", "o"], ["plain,overwrite"]),
        (["flowabs", "run", "lines", "-i", "a=b"], ["file,b"]),
    ],
)
def test_bash_splits_words_at_the_equals_sign(monkeypatch, words, lines):
    assert completed(Bash, monkeypatch, words, len(words) - 1) == lines


def test_in_bash_a_new_word_is_no_value_of_the_word_before(monkeypatch):
    words = ["flowabs", "run", "lines", "--set", "line_width", "="]
    assert "plain,--set" not in completed(Bash, monkeypatch, words, 6)
    assert completed(Bash, monkeypatch, [*words, "1", "--se"], 7) == ["plain,--set"]


def test_zsh_and_fish_keep_the_whole_word(monkeypatch):
    words = ["flowabs", "run", "lines", "--set", "flow.kernel=s"]
    assert completed(Zsh, monkeypatch, words, 4)[:2] == ["plain", "flow.kernel=separable"]
    monkeypatch.setenv("COMP_WORDS", " ".join(words))
    monkeypatch.setenv("COMP_CWORD", words[-1])
    (line,) = Fish(cli, {}, "flowabs", VARIABLE).complete().splitlines()
    assert line.startswith("plain,flow.kernel=separable")


def test_no_space_follows_an_open_word_and_fish_gets_whole_help_texts():
    """They change click's scripts, so that a new click with other scripts is noticed here."""
    assert "[[ $value == *[=./] ]] && compopt -o nospace" in Bash.source_template
    assert '[[ "$key" == *[=./] ]]' in Zsh.source_template
    assert '_describe -V unsorted open -U -S ""' in Zsh.source_template
    assert "local -a open" in Zsh.source_template
    assert 'string split --max 1 "," $completion' in Fish.source_template


@pytest.mark.skipif(shutil.which("bash") is None or sys.platform == "win32", reason="there is no bash")
def test_in_bash_itself(tmp_path):
    script = tmp_path / "flowabs"
    script.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m flowabs_nodes "$@"\n')
    script.chmod(0o755)
    code = """
eval "$(_FLOWABS_COMPLETE=bash_source flowabs)"
complete -p flowabs
COMP_WORDS=(flowabs run lines --set flow.kernel = s); COMP_CWORD=6
_flowabs_completion flowabs
echo "${COMPREPLY[@]}"
"""
    path = f"{tmp_path}{os.pathsep}{os.environ['PATH']}"
    env = {**os.environ, "PATH": path, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    ended = subprocess.run(["bash", "--norc", "-c", code], env=env, capture_output=True, text=True, check=True)
    assert ended.stdout.splitlines() == ["complete -o nosort -F _flowabs_completion flowabs", "separable"], ended.stderr
