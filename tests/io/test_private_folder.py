"""A folder for temporary files that is full, or that there is not, is named as what it is."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from flowabs_nodes.errors import WriteError
from flowabs_nodes.image import Image
from flowabs_nodes.io.private_folder import is_full, private_folder
from flowabs_nodes.io.write import build_picture, save

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("extension", ["png", "tif"])
def test_every_shortfall_is_told_with_the_name_of_the_output(tmp_path, extension):
    """A limit on the size of files stands for a full disk: it is reached in the folder for temporary files first."""
    pytest.importorskip("resource")
    code = """
import os, resource, signal, sys
import numpy as np
from flowabs_nodes.errors import WriteError
from flowabs_nodes.image import Image
from flowabs_nodes.io.write import build_picture, save
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
picture = build_picture(Image.from_array(np.random.default_rng(0).random((40, 60, 3), np.float32)))
path = sys.argv[1]
save(picture, path)
size = os.path.getsize(path)
os.unlink(path)
for short in (1, 8, 50, 400, size // 2, size - 400):  # with less not even a claim can be written
    resource.setrlimit(resource.RLIMIT_FSIZE, (size - short, resource.RLIM_INFINITY))
    try:
        save(picture, path)
        print("silent", short)
    except WriteError as error:
        if error.code != "disk-full" or error.file != path or "flowabs-" in str(error):
            print(short, error)
    for folder in (os.path.dirname(path), os.environ["TMPDIR"]):
        if os.listdir(folder):
            print("left", short, os.listdir(folder))
print("done")
"""
    for folder in ("out", "tmp"):
        (tmp_path / folder).mkdir()
    use = {"PYTHONPATH": str(ROOT), "TMPDIR": str(tmp_path / "tmp"), "PATH": ""}
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / "out" / f"a.{extension}")],
        capture_output=True,
        text=True,
        timeout=60,
        env=use,
        check=False,
    )
    assert done.stdout == "done\n", done.stdout + done.stderr


def test_no_folder_for_temporary_files(tmp_path, monkeypatch):
    def refuse(**options):
        raise FileNotFoundError(2, "No usable temporary directory found")

    monkeypatch.setattr("tempfile.TemporaryDirectory", refuse)
    picture = build_picture(Image.from_array(np.zeros((4, 4, 3), np.float32)))
    with pytest.raises(WriteError, match="no temporary file can be made") as caught:
        save(picture, tmp_path / "a.png")
    assert caught.value.file == str(tmp_path / "a.png")
    assert "TMPDIR" in caught.value.hint


def test_a_disk_with_space_is_not_full():
    with private_folder() as folder:
        assert not is_full(f"{folder}/a")
    assert not Path(folder).exists()
