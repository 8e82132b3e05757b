"""What JSON itself gets wrong, and files made to do harm."""

import json
import subprocess
import sys
import time

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flowabs_nodes import graph
from flowabs_nodes.graph.problems import CODES, Problems
from flowabs_nodes.graph.safe_json import MOST_BYTES, parse
from tests.graph.fakes import CATALOGUE, document

HEAD = b'{"format": "flowabs.graph/1", "nodes": {}, '


def found(data: bytes) -> list[tuple[str, str]]:
    return [(problem.code, problem.pointer) for problem in graph.check(data, CATALOGUE)]


@pytest.mark.parametrize(
    ("data", "code", "pointer"),
    [
        (b"", "bad-json", ""),
        (b"{", "bad-json", ""),
        (b'{"a": 1,}', "bad-json", ""),
        (b"\xff\xfe", "bad-json", ""),
        (b"{'a': 1}", "bad-json", ""),
        (b"[]", "wrong-type", ""),
        (b"null", "wrong-type", ""),
        (b'"text"', "wrong-type", ""),
        (HEAD + b'"reference_height": NaN}', "bad-json", "/reference_height"),
        (HEAD + b'"reference_height": -Infinity}', "bad-json", "/reference_height"),
        (HEAD + b'"reference_height": 1e999}', "bad-json", "/reference_height"),
        (HEAD + b'"reference_height": ' + b"9" * 5000 + b"}", "bad-json", "/reference_height"),
        (HEAD + b'"name": "a", "name": "b"}', "duplicate-key", "/name"),
        (HEAD + b'"ui": {"a": [1, {"b": 1, "b": 2}]}}', "duplicate-key", "/ui/a/1/b"),
        (HEAD + b'"ui": {"a/b": {"c~": 1, "c~": 2}}}', "duplicate-key", "/ui/a~1b/c~0"),
        (HEAD + b'"name": "\\ud800"}', "bad-json", "/name"),
        (HEAD + b'"name": "a\\u0000b"}', "bad-json", "/name"),
        (HEAD + b'"ui": {"\\udfff": 1}}', "bad-json", "/ui"),
    ],
)
def test_one_problem_at_its_place(data, code, pointer):
    assert found(data) == [(code, pointer)]


def test_a_pair_of_surrogates_is_a_letter():
    assert found(HEAD + b'"name": "\\ud83d\\ude00"}') == []


def test_what_is_not_finite_is_said_once_and_the_rest_is_checked():
    data = b'{"format": "flowabs.graph/1", "nodes": {"a": {"type": "flow@1", "params": {"radius": NaN, "kernel": 1}}}}'
    assert found(data) == [
        ("bad-json", "/nodes/a/params/radius"),
        ("wrong-type", "/nodes/a/params/kernel"),
        ("missing-input", "/nodes/a/inputs/image"),
    ]


def test_every_repeated_key_is_reported():
    data = HEAD + b'"nodes": {"a": {"type": "read@1", "type": "read@1"}}}'
    assert sorted(found(data)) == [("duplicate-key", "/nodes"), ("duplicate-key", "/nodes/a/type")]


def test_nesting_up_to_the_limit():
    assert found(HEAD + b'"ui": {"a": ' + b"[" * 62 + b"]" * 62 + b"}}") == []
    assert found(HEAD + b'"ui": {"a": ' + b"[" * 63 + b"]" * 63 + b"}}") == [("too-big", "")]
    assert found(HEAD + b'"name": "' + b"[{" * 1000 + b'"}') == []


def test_size_up_to_the_limit(tmp_path):
    data = HEAD + b'"description": "' + b"x" * (MOST_BYTES - len(HEAD) - 18) + b'"}'
    assert len(data) == MOST_BYTES
    path = tmp_path / "big.json"
    path.write_bytes(data)
    assert graph.check(path, CATALOGUE) == []
    path.write_bytes(data + b" ")
    assert [problem.code for problem in graph.check(path, CATALOGUE)] == ["too-big"]


def _entries(count, entry):
    return json.dumps({"format": "flowabs.graph/1", "nodes": {f"n{i}": entry(i) for i in range(count)}}).encode()


HOSTILE = {
    "nested": lambda: b"[" * 200_000,
    "nested objects": lambda: b'{"a":' * 200_000,
    "closing": lambda: b"]" * MOST_BYTES,
    "lists": lambda: b"[" + b"[]," * 2_700_000 + b"1]",
    "texts": lambda: b'["",' + b'"",1,' * 1_500_000 + b"1]",
    "escapes": lambda: b'"' + b'\\"' * 4_000_000,
    "unknown keys": lambda: HEAD + b",".join(b'"%d":0' % i for i in range(390_000)) + b"}",
    "repeated keys": lambda: HEAD + b'"ui":{' + b",".join([b'"a":0'] * 390_000) + b"}}",
    "repeated in each": lambda: HEAD + b'"ui":{"x":[' + b",".join([b'{"a":1,"a":1}'] * 160_000) + b"]}}",
    "infinite": lambda: HEAD + b'"ui":{"x":[' + b",".join([b"1e999"] * 390_000) + b"]}}",
    "surrogates": lambda: HEAD + b'"ui":{"x":[' + b",".join([b'"\\ud800"'] * 390_000) + b"]}}",
    "digits": lambda: HEAD + b'"reference_height":' + b"9" * 7_000_000 + b"}",
    "unknown types": lambda: _entries(10_000, lambda i: {"type": "flou@1"}),
    "broken links": lambda: _entries(10_000, lambda i: {"type": "blur@1", "inputs": {"image": f"m{i}"}}),
    "one long cycle": lambda: _entries(
        10_000, lambda i: {"type": "blur@1", "inputs": {"image": f"n{(i + 1) % 10_000}"}}
    ),
    "short cycles": lambda: _entries(10_000, lambda i: {"type": "blur@1", "inputs": {"image": f"n{i ^ 1}"}}),
    "unknown parameters": lambda: _entries(
        10_000, lambda i: {"type": "flow@1", "params": {f"p{j}": 0 for j in range(20)}}
    ),
    "too many nodes": lambda: _entries(10_001, lambda i: {"type": "read@1"}),
    "long name": lambda: json.dumps(
        {"format": "flowabs.graph/1", "nodes": {"n" * 4_000_000: {"type": "flow@1", "params": dict.fromkeys("abc", 0)}}}
    ).encode(),
}

MEASURE = """
import re, sys, time
from flowabs_nodes import graph
from tests.graph.fakes import CATALOGUE
data = open(sys.argv[1], "rb").read()
start = time.process_time()
problems = graph.check(data, CATALOGUE)
seconds = time.process_time() - start
# The peak of this program alone: getrusage would count the process that started it as well.
peak = re.search(r"VmHWM:\\s+(\\d+) kB", open("/proc/self/status").read())
print(len(problems), seconds, int(peak[1]) / 1024)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="measures memory as Linux counts it")
@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_file_is_refused_at_once_and_in_200_mb(name, tmp_path):
    path = tmp_path / "hostile.json"
    path.write_bytes(HOSTILE[name]())
    run = subprocess.run([sys.executable, "-c", MEASURE, str(path)], capture_output=True, text=True, check=True)
    count, seconds, megabytes = map(float, run.stdout.split())
    assert count >= 1
    assert seconds < 3  # at most half a second when alone
    assert megabytes < 200


def test_a_chain_of_ten_thousand_nodes_is_no_problem():
    chain = {f"n{i}": {"type": "blur@1", "inputs": {"image": f"n{i + 1}"}} for i in range(9_999)}
    chain["n9999"] = {"type": "read@1"}
    start = time.process_time()
    loaded = graph.load({"format": "flowabs.graph/1", "nodes": chain}, CATALOGUE)
    assert next(iter(loaded.nodes)) == "n9999"
    assert time.process_time() - start < 10


# ---------------------------------------------------------------------- anything at all

json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=10), inner, max_size=4),
    max_leaves=20,
)


def check_anything(data: bytes) -> None:
    for problem in graph.check(data, CATALOGUE):
        assert problem.code in CODES
        assert problem.pointer == "" or problem.pointer.startswith("/")
        str(problem).encode()
        json.dumps(problem.to_dict())


@given(st.binary(max_size=200) | st.text(max_size=200).map(lambda text: text.encode("utf-8", "surrogatepass")))
def test_any_bytes(data):
    check_anything(data)


@given(json_values)
def test_any_json(value):
    check_anything(json.dumps(value).encode())


@given(json_values.filter(lambda value: "NaN" not in (text := json.dumps(value)) and "Infinity" not in text))
def test_what_is_not_refused_is_read_as_it_is(value):
    problems = Problems()
    result = parse(json.dumps(value).encode(), problems)
    assert problems.found or result == value


def places(value, place=()):
    yield place
    for key, item in value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ():
        yield from places(item, (*place, key))


PLACES = [place for place in places(document()) if place]


@settings(max_examples=300)
@given(
    st.sampled_from(PLACES),
    json_values | st.sampled_from([{"from": "calm"}, {"curve": {"1": 2}}, "plate", "flow@1"]),
)
def test_a_good_graph_with_anything_anywhere(place, value):
    changed = document()
    owner = changed
    for key in place[:-1]:
        owner = owner[key]
    owner[place[-1]] = value
    check_anything(json.dumps(changed).encode())


@given(st.sampled_from(PLACES))
def test_a_good_graph_with_anything_left_out(place):
    changed = document()
    owner = changed
    for key in place[:-1]:
        owner = owner[key]
    del owner[place[-1]]
    check_anything(json.dumps(changed).encode())
