"""Runs that begin in several threads at once: the compiler is imported by one of them."""

import subprocess
import sys

PROGRAM = """
import threading
import numpy as np
import flowabs_nodes as fa

def graph(node):
    nodes = {"plate": {"type": "read@1"}, "one": {"type": node, "inputs": {"image": "plate"}}}
    return {"format": "flowabs.graph/1", "nodes": {**nodes, "out": {"type": "write@1", "inputs": {"image": "one"}}}}

def run(node):
    try:
        with fa.Session(graph(node)) as session:
            session.given(plate=np.full((8, 8, 3), 0.2, np.float32))
            session.run("one")
    except fa.FlowabsError as error:
        print(error)

threads = [threading.Thread(target=run, args=(node,)) for node in ("exposure@1", "bilateral@1") * 2]
for thread in threads:
    thread.start()
for thread in threads:
    thread.join()
"""


def test_sessions_may_begin_in_several_threads_of_a_new_process_at_once():
    for _ in range(2):
        ended = subprocess.run(
            [sys.executable, "-c", PROGRAM], capture_output=True, text=True, timeout=300, check=False
        )
        assert (ended.returncode, ended.stdout) == (0, ""), ended.stderr
