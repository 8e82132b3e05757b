"""The options of a run: one declaration, from which the command line and the Python call are made."""

import dataclasses
import inspect
import pickle
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

import flowabs_nodes as fa
from flowabs_nodes import cli
from flowabs_nodes.engine.options import RunOptions, flag_of
from flowabs_nodes.errors import ArgumentError, CommandError
from flowabs_nodes.io.settings import Settings

FIELDS = {option.name: option for option in dataclasses.fields(RunOptions)}


def test_every_option_is_a_keyword_of_run_with_the_same_default():
    keywords = inspect.signature(fa.run).parameters
    assert {name: keywords[name].default for name in FIELDS} == {name: each.default for name, each in FIELDS.items()}
    assert keywords.keys() - FIELDS.keys() == {"graph", "settings", "profile", "on_event"}


def test_every_option_is_a_flag_of_the_command_line_with_the_same_default_and_choices():
    flags = {each.name: each for each in cli.run.params}
    assert flags.keys() - FIELDS.keys() == {
        "graph",
        "as_json",
        "profile",
        "view",
        "dry_run",
        "verbose",
        "quiet",
        "log_file",
    }
    for name, option in FIELDS.items():
        flag = flags[name]
        assert f"--{name.replace('_', '-')}" in flag.opts
        assert flag.help == flag_of(option).help
        assert flag.multiple or flag.default == option.default
        assert tuple(getattr(flag.type, "choices", ())) == flag_of(option).choices


def test_options_travel_to_other_processes():
    options = RunOptions(frames="1-10", scale=0.5, set={"stops": 1})
    assert pickle.loads(pickle.dumps(options)) == options


def test_what_chose_graph_and_frames_is_not_needed_for_a_frame():
    options = RunOptions(input="a.exr", output="b.exr", frames=[1], set={"stops": 1}, missing="hold", scale=0.5)
    assert options.for_frames() == RunOptions(missing="hold", scale=0.5)


def test_settings_are_the_options_that_files_depend_on():
    assert RunOptions().settings == Settings()
    assert RunOptions(max_pixels=100, ocio="a.ocio", root="b").settings == Settings(100, "a.ocio", "b")


@pytest.mark.parametrize(
    ("option", "value", "hint"),
    [
        ("existing", "overwrit", "did you mean 'overwrite'?"),
        ("existing", None, "known: error, overwrite, resume"),
        ("missing", "neerest", "did you mean 'nearest'?"),
    ],
)
def test_a_word_must_be_one_of_the_choices(option, value, hint):
    with pytest.raises(CommandError, match=f"{option}: expected one of .*, found {value!r}") as failure:
        RunOptions(**{option: value})
    assert (failure.value.code, failure.value.parameter, failure.value.hint) == ("bad-value", option, hint)


@pytest.mark.parametrize("scale", [0, -1, 1.5, float("nan"), True, "half", None])
def test_scale_must_be_a_share(scale):
    with pytest.raises(ArgumentError, match="above 0 up to 1"):
        RunOptions(scale=scale)


@pytest.mark.parametrize("scale", [np.array(0.5), np.float16(0.5), np.longdouble(0.5), Fraction(1, 2)])
def test_scale_is_any_real_number(scale):
    assert RunOptions(scale=scale).scale == 0.5
    assert type(RunOptions(scale=scale).scale) is float


@pytest.mark.parametrize("root", ["~", "~/shots", "$SHOT", Path("~/shots")])
def test_a_root_that_only_a_shell_understands_is_refused(root):
    with pytest.raises(CommandError) as caught:
        RunOptions(root=root)
    assert caught.value.code == "bad-path"
