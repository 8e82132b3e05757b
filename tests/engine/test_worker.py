"""The process that renders frames for a run, and processes that a node forks off it."""

import os
import select
import sys

import pytest

from flowabs_nodes.engine import worker

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="forks of Unix")


def test_the_end_of_a_worker_is_seen_where_a_child_of_it_lives_on():
    reading, writing = os.pipe()
    replies = os.fdopen(writing, "wb")
    waiting, over = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(over)
        worker._leave(replies)
        os.read(waiting, 1)  # until the other side has seen the end
        os._exit(0)
    replies.close()
    assert select.select([reading], [], [], 10)[0]
    assert os.read(reading, 1) == b""
    os.close(over)
    assert os.waitpid(child, 0)[1] == 0
    os.close(reading)
    os.close(waiting)
