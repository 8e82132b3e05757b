import os
import sys

import pytest

from flowabs_nodes import stopping
from flowabs_nodes.simd import compile_turn

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="locks and forks of Unix")


@pytest.fixture
def turn(tmp_path):
    file = tmp_path / "kernel.turn"
    compile_turn.take(file)
    yield file
    compile_turn.give(file)


def is_free(file):
    fd = os.open(file, os.O_RDWR)
    try:
        return compile_turn._lock(fd)
    finally:
        os.close(fd)


def test_a_turn_is_one_process_s_at_a_time(turn):
    assert not is_free(turn)
    compile_turn.give(turn)
    assert is_free(turn)


def test_a_turn_that_is_given_is_free_where_a_fork_has_a_copy_of_its_file(turn):
    copy = os.dup(compile_turn._held[turn])
    compile_turn.give(turn)
    assert is_free(turn)
    os.close(copy)


def test_a_child_has_no_turn_and_leaves_the_parent_its_own(turn):
    child = os.fork()
    if child == 0:
        compile_turn.give(turn)
        os._exit(len(compile_turn._held))
    assert os.waitpid(child, 0)[1] == 0
    assert not is_free(turn)


def test_who_has_a_turn_may_be_broken_off(turn):
    assert any(may() for may in stopping.may_be_broken_off)
    compile_turn.give(turn)
    assert not any(may() for may in stopping.may_be_broken_off)
