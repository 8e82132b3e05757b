import pytest

from flowabs_nodes.engine.error_boundary import InternalError, error_boundary
from flowabs_nodes.errors import FlowabsError, ReadError
from flowabs_nodes.signals import stop_on_signals
from flowabs_nodes.stopping import StopFlag, Stopped, stopped_by


def test_what_was_foreseen_stays_the_same_error_and_learns_its_place():
    error = ReadError("is cut short", file="a.exr")
    with pytest.raises(ReadError) as failure, error_boundary("plate", 7):
        raise error
    assert failure.value is error
    assert str(error) == "a.exr: frame 7: node plate: is cut short"


def test_the_innermost_place_stays():
    with pytest.raises(FlowabsError) as failure, error_boundary("outer", 1), error_boundary("inner", 2):
        raise FlowabsError("no")
    assert (failure.value.node, failure.value.frame) == ("inner", 2)


@pytest.mark.parametrize(
    ("error", "code", "message"),
    [
        (ZeroDivisionError("one\ntwo"), "internal", "ZeroDivisionError: one"),
        (ValueError(), "internal", "ValueError: "),
        (MemoryError(), "out-of-memory", "not enough memory"),
        (MemoryError("8 GB"), "out-of-memory", "not enough memory (8 GB)"),
    ],
)
def test_what_nobody_foresaw_becomes_an_internal_error_with_its_cause(error, code, message):
    with pytest.raises(InternalError) as failure, error_boundary("flow", 3):
        raise error
    assert (failure.value.code, failure.value.message) == (code, message)
    assert (failure.value.node, failure.value.frame) == ("flow", 3)
    assert failure.value.__cause__ is error


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (SystemExit(3), "SystemExit: 3"),
        (SystemExit(), "SystemExit"),
        (GeneratorExit(), "GeneratorExit"),
        (BaseException("one\ntwo"), "BaseException: one"),
    ],
)
def test_what_would_end_the_process_ends_the_frame_alone(error, said):
    with pytest.raises(InternalError) as failure, error_boundary("flow", 3):
        raise error
    assert failure.value.message == f"it tried to end the whole process ({said})"
    assert (failure.value.node, failure.value.frame) == ("flow", 3)
    assert failure.value.__cause__ is error


def test_a_keyboard_interrupt_that_is_no_ctrl_c_ends_the_frame_alone():
    with stop_on_signals(), pytest.raises(InternalError, match="KeyboardInterrupt"), error_boundary("flow", 3):
        raise KeyboardInterrupt


def test_what_stops_the_run_passes():
    with pytest.raises(KeyboardInterrupt), error_boundary("flow", 3):
        raise KeyboardInterrupt  # Python's own handler raises it on Ctrl-C
    with stop_on_signals(), pytest.raises(Stopped), error_boundary("flow", 3):
        raise Stopped
    flag = StopFlag()
    flag.set()
    with stopped_by(flag), stop_on_signals(), pytest.raises(KeyboardInterrupt), error_boundary("flow", 3):
        raise KeyboardInterrupt  # of the second Ctrl-C
