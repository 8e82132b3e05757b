"""An option that takes one value is refused when it is given twice."""

import click
import pytest

from flowabs_nodes import cli

SINGLE = [
    option
    for option in cli.run.params
    if isinstance(option, click.Option) and not option.is_flag and not option.multiple
]


def test_the_options_are_those_one_thinks_of():
    names = {option.name for option in SINGLE}
    assert names >= {"input", "frames", "scale", "existing", "missing", "root", "max_pixels", "ocio", "log_file"}
    assert not names & {"output", "set"}


@pytest.mark.parametrize("option", SINGLE, ids=lambda option: option.name)
def test_twice_is_an_error(option, flowabs, fake_run):
    value = option.type.choices[0] if isinstance(option.type, click.Choice) else "1"
    given = [word for name in (option.opts[0], option.opts[-1]) for word in (name, value)]
    code, out, err = flowabs("run", "lines", *given)
    assert (code, out) == (2, "")
    assert f"{min(option.opts, key=len)} is given 2 times, but takes one value: {value}, {value}" in err
    assert not fake_run


def test_once_is_none(flowabs, fake_run):
    flowabs("run", "lines", "-i", "a.exr", "--frames=1-3", "--scale", "0.5")
    (_, options, _), *_ = fake_run
    assert (options.input, options.frames, options.scale) == ("a.exr", "1-3", 0.5)


def test_a_flag_may_be_said_twice(flowabs, fake_run):
    assert flowabs("run", "lines", "--profile", "--profile", "-q", "--quiet")[0] == 1
