"""``flowabs run --dry-run``: what is printed, and the exit code."""

import json

from tests.cli.test_run import run, shot  # noqa: F401 - fixtures

FILES = ("-i", "in.####.exr", "-o", "out/b.####.exr", "--dry-run")


def test_a_summary(run, shot):  # noqa: F811
    code, out, err = run(*FILES)
    assert code == 0
    assert not err
    assert out.splitlines()[:3] == [
        "reads   in.####.exr",
        "writes  out/b.####.exr",
        "     3  to make: frames 1001-1003",
    ]
    assert "names, times and headers alone" in out
    assert not (shot / "out").exists()


def test_a_frame_that_will_fail(run):  # noqa: F811
    code, out, err = run(*FILES, "--frames", "1002-1005")
    assert code == 1
    assert "     2  will fail, node plate: no such file: frames 1004-1005" in err
    assert "     2  to make: frames 1002-1003" in out
    assert run(*FILES, "--frames", "1004", "-q")[1] == ""


def test_a_line_or_an_event_a_frame(run):  # noqa: F811
    _, out, _ = run(*FILES, "-v")
    assert out.splitlines()[0] == "frame 1001  make      reads in.1001.exr  writes out/b.1001.exr"
    _, out, _ = run(*FILES, "--json")
    *frames, end = map(json.loads, out.splitlines())
    assert (frames[0]["frame"], frames[0]["state"], frames[0]["reads"]) == (1001, "make", ["in.1001.exr"])
    assert (end["event"], end["make"], end["fail"]) == ("dry-run", 3, 0)


def test_a_wrong_command(run):  # noqa: F811
    assert run(*FILES, "--view", "plate")[0] == 2
    assert run(*FILES, "--frames", "1-")[0] == 2
    assert run("-i", "in.####.exr", "-o", "in.####.exr", "--dry-run")[0] == 2


def test_a_graph_named_as_a_picture_is_not_written_over(run, shot):  # noqa: F811
    graph = (shot / "brighter.json").rename(shot / "named.exr")
    before = graph.read_bytes()
    for more in ((), ("--dry-run",)):
        code, _, err = run("-i", "in.1001.exr", "-o", "named.exr", *more, graph="./named.exr")
        assert code == 2
        assert "would be written over an input" in err
    assert run("-i", "in.1001.exr", "-o", "named.png", "--view", "plate", graph="./named.exr")[0] == 0
    assert graph.read_bytes() == before
