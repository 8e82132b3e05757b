"""The server behind the plug-in: missing, killed, silent, of another version; stopped renders; graphs that change."""

import json
import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import flowabs_nodes as fa
from flowabs_nodes.openfx import bundle
from tests.openfx.conftest import PANEL, instance_of, picture
from tests.openfx.host import FAILED, Host
from tests.openfx.images import Held
from tests.openfx.processes import children, kill, left_in_memory, open_files, wait_until

ROOT = Path(__file__).resolve().parents[2]

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="looks at /proc")

HELLO = 'say({"flowabs": "0", "protocol": 1})'
MAPS = """
def served(render):
    say({"flowabs": "0", "protocol": 1})
    while True:
        asked = hear()
        if asked["do"] == "render":
            render(asked)
        else:
            say({"id": asked["id"], "ok": True})
"""


@pytest.fixture(autouse=True)
def before():
    """Note the servers and the memory that another host of this process has, before a test."""
    BEFORE.clear()
    BEFORE.update(children(), mapped())


BEFORE = set()


def servers():
    """Return the servers that the test has started and that are still at work."""
    return [process for process in children() if process not in BEFORE]


def mapped():
    """Return the addresses of shared memory in this process."""
    lines = Path("/proc/self/maps").read_text().splitlines()
    return {line.split()[0] for line in lines if f"flowabs-{os.getpid()}-" in line}


def refused(library, *, expect=FAILED, **how):
    """Render a frame in a host of its own that has to fail, and return what it says."""
    host = Host(library, **how)
    instance = instance_of(host, "panel", picture())
    instance.render(expect=expect)
    said = instance.message or (host.messages[-1] if host.messages else None)
    instance.destroy()
    host.close()
    assert host.faults == []
    assert servers() == []
    assert left_in_memory() == []
    return said


def test_without_a_server_the_artist_reads_how_to_install_it(elsewhere):
    kind, text = refused(elsewhere("/no/such/python"))
    assert kind == "OfxMessageError"
    assert "/no/such/python -m flowabs_nodes serve: No such file or directory" in text
    assert "Install it with: /no/such/python -m pip install flowabs-nodes" in text


def test_a_python_without_flowabs_is_told_apart(elsewhere):
    _, text = refused(elsewhere(program="sys.exit(1)"))
    assert "it ended at once" in text


@pytest.mark.parametrize("without", [["OfxMessageSuite 2"], ["OfxMessageSuite"], ["OfxProgressSuite"]], ids=str)
def test_hosts_with_fewer_suites_hear_it_as_they_can(elsewhere, without, capfd):
    said = refused(elsewhere("/no/such/python"), without=without)
    assert "Install it with" in (said[1] if said else capfd.readouterr().err)


def test_a_server_of_another_protocol_is_refused(elsewhere):
    _, text = refused(elsewhere(program='say({"flowabs": "9", "protocol": 7}); hear()'))
    assert "it speaks protocol 7, this plug-in 1" in text


@pytest.mark.parametrize(
    "program",
    [
        'os.write(1, b"Traceback (most recent call last):\\n" * 9); time.sleep(60)',
        'say({"flowabs": "0", "protocol": 1}, magic=b"HTTP/1.1"); time.sleep(60)',
        'os.write(1, MAGIC + struct.pack("<II", 2**31, 0)); time.sleep(60)',
        'os.write(1, MAGIC + struct.pack("<II", 4, 0) + b"{{{{"); time.sleep(60)',
        'os.write(1, MAGIC + struct.pack("<II", 200000, 0) + b"[" * 200000); time.sleep(60)',
        "time.sleep(60)",
    ],
    ids=["text", "magic", "length", "json", "deep", "silence"],
)
def test_a_server_that_talks_nonsense_or_not_at_all_is_given_up(elsewhere, program, monkeypatch):
    monkeypatch.setenv("FLOWABS_OPENFX_PATIENCE", "0.5")
    begun = time.monotonic()
    _, text = refused(elsewhere(program=program))
    assert "cannot start it" in text
    assert time.monotonic() - begun < 10


@pytest.mark.parametrize(
    ("program", "words"),
    [
        (f"{MAPS}\nserved(lambda asked: os._exit(3))", "ended while it was at work"),
        (f"{MAPS}\nserved(lambda asked: time.sleep(60))", "ended while it was at work"),
        (f'{MAPS}\nserved(lambda asked: say({{"id": asked["id"], "ok": False}}))', "gave no reason"),
    ],
    ids=["dies", "hangs", "refuses without a word"],
)
def test_a_render_that_cannot_end_is_tried_once_more_and_then_fails(elsewhere, program, words, monkeypatch, capfd):
    monkeypatch.setenv("FLOWABS_OPENFX_PATIENCE", "1")
    count = 'open(__file__ + ".count", "a").write("x")\n'
    library = elsewhere(program=count + program)
    _, text = refused(library)
    assert words in text
    starts = len(next(library.parents[3].glob("*.count")).read_text())
    assert starts == (1 if "reason" in words else 2)


def test_a_server_that_is_busy_but_says_hello_is_waited_for(elsewhere, monkeypatch):
    monkeypatch.setenv("FLOWABS_OPENFX_PATIENCE", "1")
    program = f"""{MAPS}
import threading
def late(asked):
    def answer():
        time.sleep(3)
        say({{"id": asked["id"], "ok": True}})
    threading.Thread(target=answer).start()
served(late)"""
    host = Host(elsewhere(program=program))
    instance = instance_of(host, "panel", picture())
    instance.render()
    assert host.progress  # after a second a bar is shown
    assert host.progress_open == 0
    instance.destroy()
    host.close()
    assert host.faults == []


@pytest.mark.parametrize("by", ["abort", "bar"])
def test_a_host_that_wants_the_frame_no_more_has_it_cancelled(elsewhere, by):
    program = f"""{MAPS}
said = {{}}
def begin(asked):
    said["id"] = asked["id"]
def hear_cancel():
    say({{"flowabs": "0", "protocol": 1}})
    while True:
        asked = hear()
        if asked["do"] == "render":
            begin(asked)
            continue
        say({{"id": asked["id"], "ok": True}})
        if asked["do"] == "cancel":
            open(__file__ + ".cancelled", "w").write(str(asked["of"] == said["id"]))
            say({{"id": asked["of"], "ok": False, "error": {{"code": "cancelled", "message": "cancelled"}}}})
hear_cancel()"""
    library = elsewhere(program=program)
    host = Host(library)
    instance = instance_of(host, "panel", picture())
    begun = time.monotonic()
    if by == "abort":
        host.aborts = lambda: time.monotonic() - begun > 1.5
    else:
        host.cancel_bar = True
    instance.render()  # a frame that nobody wants is no failure
    assert instance.message is None
    assert next(library.parents[3].glob("*.cancelled")).read_text() == "True"
    instance.destroy()
    host.close()
    assert host.faults == []


def test_a_server_killed_between_and_during_frames_is_started_again(elsewhere):
    host = Host(elsewhere())
    source = picture(64, 64)
    instance = instance_of(host, "soft", source)
    first = instance.render().copy()
    (server,) = servers()
    kill(server)
    instance.set(sigma=5.0)
    assert not np.array_equal(instance.render(), first)
    (other,) = servers()
    assert other != server
    stopped = threading.Event()

    def kill_soon():
        time.sleep(0.01)
        kill(other)
        stopped.set()

    threading.Thread(target=kill_soon).start()
    instance.set(sigma=4.0)
    for _ in range(40):
        instance.set(sigma=4.0)
        instance.render()
        instance.set(sigma=6.0)
        instance.render()
    assert stopped.wait(5)
    instance.set(sigma=4.0)
    assert np.array_equal(instance.render(), first)
    assert instance.message is None
    instance.destroy()
    host.close()
    assert host.faults == []
    assert servers() == []
    assert left_in_memory() == []


def test_a_message_goes_when_all_is_well_again(host):
    instance = instance_of(host, "panel", picture())
    instance.set(stops=99.0)  # a slider ends at 8, a number that is typed need not
    instance.render(expect=FAILED)
    kind, text = instance.message
    assert kind == "OfxMessageError"
    assert text == "parameter stops: expected a number from -8 to 8 (stops), found 99"
    instance.set(stops=1.0)
    instance.render()
    assert instance.message is None
    for name, value, words in (
        ("how", 7, "parameter how: expected a choice of 0 to 2, found 7"),
        ("how", -1, "found -1"),
        ("output", 9, "output: no such choice"),
        ("colorspace", 5, "colorspace: expected the name of a colour space"),
        ("stops", float("nan"), "stops"),
    ):
        before = instance.params[name].value
        instance.set(**{name: value})
        instance.render(expect=FAILED)
        assert words in instance.message[1], instance.message
        instance.set(**{name: before})
    instance.set(colorspace=5, colorspace_name="ACESgc")
    instance.render(expect=FAILED)
    assert "ACEScg" in instance.message[1]  # the nearest right name
    instance.set(colorspace=0)
    instance.render()
    assert instance.message is None
    instance.destroy()


def test_a_graph_that_is_gone_broken_or_changed_between_two_frames(tmp_path):
    graphs = tmp_path / "graphs"
    graphs.mkdir()
    file = graphs / "mine.json"
    file.write_text(json.dumps(PANEL))
    made, _ = bundle.build(tmp_path / "ofx", [graphs])
    host = Host(next(made.glob("Contents/*/Flowabs.ofx")))
    source = picture()
    instance = instance_of(host, "mine", source)
    assert np.array_equal(instance.render(), source)
    file.unlink()
    instance.render(expect=FAILED)
    assert str(file) in instance.message[1]
    file.write_text("{")
    instance.render(expect=FAILED)
    assert str(file) in instance.message[1]
    changed = json.loads(json.dumps(PANEL))
    changed["nodes"]["pick"]["params"] = {"which": 1}
    changed["interface"]["which"]["default"] = 0
    file.write_text(json.dumps(changed))
    got = instance.render(expect=None).copy()
    wanted = fa.load_graph(changed).run(1, {"plate": fa.Image.from_array(source)}, {"which": 0}, ["pick"])["pick"]
    assert np.array_equal(got, wanted.to_array(channels="RGBA"))
    assert instance.message is None
    instance.destroy()
    host.close()
    assert host.faults == []


def test_two_hosts_at_once(library):
    program = (
        "import sys, numpy as np; from pathlib import Path\n"
        "from tests.openfx.host import Host; from tests.openfx.conftest import instance_of, picture\n"
        f"host = Host(Path({str(library)!r})); source = picture(32, 32)\n"
        "instance = instance_of(host, 'soft', source)\n"
        "for sigma in range(1, 9):\n"
        "    instance.set(sigma=float(sigma)); out = instance.render()\n"
        "instance.destroy(); host.close(); assert host.faults == [], host.faults\n"
        "print(float(out.astype(np.float64).sum()))\n"
    )
    started = [
        subprocess.Popen([sys.executable, "-c", program], cwd=ROOT, stdout=subprocess.PIPE, text=True) for _ in range(2)
    ]
    said = {process.communicate(timeout=120)[0] for process in started}
    assert len(said) == 1
    assert said != {""}
    assert [process.returncode for process in started] == [0, 0]
    assert all(left_in_memory(process.pid) == [] for process in started)


def test_a_host_that_dies_takes_its_server_with_it(library):
    program = (
        "import os, signal; from pathlib import Path\n"
        "from tests.openfx.host import Host; from tests.openfx.conftest import instance_of, picture\n"
        "from tests.openfx.processes import children\n"
        f"host = Host(Path({str(library)!r})); instance_of(host, 'panel', picture()).render()\n"
        "print(*children(), flush=True); os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=False)
    (server,) = map(int, done.stdout.split())
    assert wait_until(lambda: not Path(f"/proc/{server}").exists() or "Z" in Path(f"/proc/{server}/stat").read_text())


def test_the_hosts_own_python_and_libraries_do_not_reach_the_server(elsewhere, monkeypatch, tmp_path):
    for name in ("PYTHONHOME", "LD_LIBRARY_PATH", "LD_PRELOAD", "DYLD_INSERT_LIBRARIES"):
        monkeypatch.setenv(name, "/host/of/its/own")
    monkeypatch.setenv("FLOWABS_KEPT", "as it is")
    monkeypatch.setenv("PYTHONPATH", "/host/of/its/own")
    library = elsewhere(program=f'open(__file__ + ".env", "w").write(json.dumps(dict(os.environ)))\n{HELLO}')
    refused(library)
    seen = json.loads(next(library.parents[3].glob("*.env")).read_text())
    assert seen["FLOWABS_KEPT"] == "as it is"
    assert not {name for name in seen if "/host/of/its/own" in seen[name]}


def test_the_python_of_FLOWABS_PYTHON_goes_before_the_bundles(elsewhere, monkeypatch):
    monkeypatch.setenv("FLOWABS_PYTHON", "/another/python")
    assert "/another/python -m flowabs_nodes serve" in refused(elsewhere())[1]


def test_a_host_with_a_locale_of_commas_sends_points(elsewhere):
    import locale

    before = locale.setlocale(locale.LC_NUMERIC)
    for name in ("de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8"):
        try:
            locale.setlocale(locale.LC_NUMERIC, name)
            break
        except locale.Error:
            continue
    else:
        pytest.skip("no locale with a decimal comma is installed")
    try:
        host = Host(elsewhere())
        instance = instance_of(host, "panel", picture())
        instance.set(stops=0.1)
        wanted = fa.load_graph(PANEL).run(1, {"plate": fa.Image.from_array(picture())}, {"stops": 0.1}, ["pick"])[
            "pick"
        ]
        assert np.array_equal(instance.render(), wanted.to_array(channels="RGBA"))
        instance.destroy()
        host.close()
        assert host.faults == []
    finally:
        locale.setlocale(locale.LC_NUMERIC, before)


def test_nothing_is_left_of_many_frames_of_many_sizes(elsewhere):
    host = Host(elsewhere())
    counts = []
    for turn in range(12):
        instance = instance_of(host, "panel", picture(8 + 16 * turn, 16))
        instance.set(stops=float(turn % 4))
        instance.render()
        if turn == 6:
            instance.plugin.call("OfxActionPurgeCaches", instance.number)
        instance.clips["Source"].connect(Held(picture(8, 8)))
        instance.clips["Output"].connect(Held(picture(8, 8)))
        instance.render()
        instance.destroy()
        counts.append(open_files())
    assert counts[2] == counts[-1]
    assert left_in_memory() == []
    assert len(mapped() - BEFORE) <= 4
    host.close()
    assert host.faults == []
    assert mapped() <= BEFORE
