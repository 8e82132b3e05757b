"""The content of a config: what it and its tables hold, wherever they lie; and edits within one process."""

import os
import zipfile

import numpy as np
import OpenImageIO as oiio
import pytest

from flowabs_nodes import color
from flowabs_nodes.color import config, config_files
from flowabs_nodes.errors import ColorError
from tests.studio import STUDIO, studio, table


def content(path):
    return config.opened(str(path)).content


def film(path):
    """Return what the table makes of 0.5."""
    return float(color.ocio.linearize(np.full((1, 1, 3), 0.5, np.float32), "show_film", path)[0][0, 0, 0])


def test_the_same_content_at_another_path(tmp_path):
    assert content(studio(tmp_path / "a")) == content(studio(tmp_path / "b", name="other.ocio"))


@pytest.mark.parametrize(
    "edit",
    [
        lambda folder: studio(folder, text=STUDIO + "# a word\n"),
        lambda folder: table(folder, 1.5),
        lambda folder: (folder / "luts/film.cube").unlink(),
    ],
)
def test_an_edit_is_another_content(tmp_path, edit):
    path = studio(tmp_path)
    before = content(path)
    edit(tmp_path)
    assert content(path) != before


def test_other_files_beside_it_do_not_matter(tmp_path):
    path = studio(tmp_path)
    before = content(path)
    (tmp_path / "luts/other.cube").write_text("nobody names it")
    assert content(path) == before


def test_an_edited_table_is_read_again_in_the_same_process(tmp_path):
    path = studio(tmp_path, gain=1.0)
    assert film(path) == pytest.approx(0.5)
    table(tmp_path, 2.0)
    assert film(path) == pytest.approx(1.0)
    table(tmp_path, 4.0)
    assert film(path) == pytest.approx(2.0)
    table(tmp_path, 1.0)
    assert film(path) == pytest.approx(0.5)


def test_a_table_that_was_missing_is_found_once_it_is_there_and_gone_once_it_is_not(tmp_path):
    path = studio(tmp_path, gain=None)
    with pytest.raises(ColorError, match=r"film\.cube") as caught:
        film(path)
    assert "show_film" in str(caught.value)
    assert path in str(caught.value)
    table(tmp_path, 2.0)
    assert film(path) == pytest.approx(1.0)
    (tmp_path / "luts/film.cube").unlink()
    with pytest.raises(ColorError, match=r"film\.cube"):
        film(path)


def test_an_edited_config_is_read_again_in_the_same_process(tmp_path):
    path = studio(tmp_path)
    codes = np.full((1, 1, 3), 1.0, np.float32)
    assert color.ocio.linearize(codes, "show_log", path)[0][0, 0, 0] == pytest.approx(10, rel=1e-3)
    studio(tmp_path, text=STUDIO.replace("base: 10", "base: 2"))
    assert color.ocio.linearize(codes, "show_log", path)[0][0, 0, 0] == pytest.approx(2, rel=1e-3)


SEARCH = {
    "a list": "search_path: [none, luts]",
    "lines": "search_path:\n  - none\n  - luts",
    "colons": 'search_path: "none:luts"  # two',
    "above": "search_path: ../{folder}/luts",
    "a variable": "search_path: $TABLES",
    "absolute": "search_path: {here}/luts",
}


@pytest.mark.parametrize("search", SEARCH.values(), ids=SEARCH)
def test_search_paths(tmp_path, monkeypatch, search):
    monkeypatch.setenv("TABLES", "luts")
    search = search.format(folder=tmp_path.name, here=tmp_path)
    path = studio(tmp_path, text=STUDIO.replace("search_path: luts", search))
    assert film(path) == pytest.approx(0.5)
    before = content(path)
    table(tmp_path, 2.0)
    assert content(path) != before
    assert film(path) == pytest.approx(1.0)


def test_tables_of_many_spellings(tmp_path):
    (tmp_path / "my luts").mkdir(parents=True)
    for name in ("a b.cube", "c,d.cube", "e.cube"):
        (tmp_path / "my luts" / name).write_text(name)
    text = (
        "search_path: my luts\n"
        '- !<FileTransform> {src: "a b.cube", direction: inverse}\n'
        "- !<FileTransform>\n  src: c,d.cube  # this\n"
        "- !<FileTransform> {interpolation: linear, src: e.cube}\n"
    )
    for name in ("a b.cube", "c,d.cube", "e.cube"):
        path = studio(tmp_path, text=text, gain=None)
        before = config_files.edition(path)[0]
        (tmp_path / "my luts" / name).write_text("changed")
        assert config_files.edition(path)[0] != before


def test_an_absolute_table_that_changed_asks_for_a_new_process(tmp_path):
    path = studio(tmp_path, text=STUDIO.replace("film.cube", f"{tmp_path}/luts/film.cube"))
    assert film(path) == pytest.approx(0.5)
    table(tmp_path, 2.0)
    with pytest.raises(ColorError, match=r"film\.cube.*has changed") as caught:
        film(path)
    assert caught.value.hint == "begin a new process"


def test_variables_count_where_they_are_used(tmp_path, monkeypatch):
    path = studio(tmp_path)
    monkeypatch.delenv("SHOW", raising=False)
    before = content(path)
    monkeypatch.setenv("OTHER", "x")
    assert content(path) == before
    monkeypatch.setenv("SHOW", "x")
    assert content(path) != before


@pytest.mark.skipif(oiio.VERSION < 30100, reason="OpenImageIO 3.0 ends the process")
def test_an_archive_holds_its_tables(tmp_path):
    studio(tmp_path)
    path = tmp_path / "show.ocioz"
    with zipfile.ZipFile(path, "w") as archive:
        for name in ("config.ocio", "luts/film.cube"):
            archive.write(tmp_path / name, name)
    assert film(str(path)) == pytest.approx(0.5)
    assert content(path)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes")
def test_what_never_ends_is_not_read(tmp_path):
    os.mkfifo(tmp_path / "config.ocio")
    for path in (tmp_path / "config.ocio", "/dev/zero"):
        with pytest.raises(ColorError, match="not a file"):
            config.opened(str(path))
    path = studio(tmp_path / "a", gain=None)
    (tmp_path / "a/luts").mkdir()
    os.mkfifo(tmp_path / "a/luts/film.cube")
    assert content(path)
