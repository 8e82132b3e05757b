"""The command that makes frames again comes back through a shell as it was."""

import shlex
import shutil
import subprocess

import pytest

from flowabs_nodes.cli.rerun import command, command_for


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["toon", "-i", "a.exr"], ["toon", "-i", "a.exr", "--frames", "5,9-12"]),
        (["toon", "--frames", "1-20", "-q"], ["toon", "-q", "--frames", "5,9-12"]),
        (["--frames=1-20", "toon"], ["toon", "--frames", "5,9-12"]),
        (["toon", "--set", "comp.ink=[1, 0, 0]"], ["toon", "--set", "comp.ink=[1, 0, 0]", "--frames", "5,9-12"]),
        (["it's", "-o", "a b.####.exr"], ["it's", "-o", "a b.####.exr", "--frames", "5,9-12"]),
    ],
)
def test_only_the_frames_are_others(arguments, expected):
    assert shlex.split(command_for(arguments, "5,9-12")) == ["flowabs", "run", *expected]


@pytest.mark.skipif(not shutil.which("bash"), reason="needs bash")
@pytest.mark.parametrize("word", ["a\nb", "\x1b[31m", "caf\udce9.exr", "it's\\\x07", "ünïcode \x7f", "-5-5"])
def test_a_shell_gives_back_every_word(word):
    line = command([word])
    assert line.isprintable()
    words = subprocess.run(["bash", "-c", f"printf '%s\\0' {line}"], capture_output=True, check=True).stdout
    assert [each.decode("utf-8", "surrogateescape") for each in words.split(b"\0")[:-1]] == ["flowabs", "run", word]
