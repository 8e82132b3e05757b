import json
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from flowabs_nodes.filters.flow.gradient import measure_reference
from tools.bench import scaling
from tools.bench.__main__ import main
from tools.bench.cases import PIPELINES, STAGES, Plate
from tools.bench.memory import peak
from tools.bench.peers import PEERS
from tools.bench.report import FORMAT, Row, from_json, table, to_json
from tools.bench.scene import scene
from tools.bench.timing import Case, Spread, measure

FEW = "encode-lab,gradient,etf-full,threshold,dog,P"
QUICK = ["--size", "40x32", "--seconds", "0", "--stages", FEW]


def test_a_run_writes_every_figure_as_json_and_as_a_table(tmp_path, capsys):
    file = tmp_path / "first.json"
    assert main([*QUICK, "--json", str(file)]) == 0
    found = json.loads(file.read_text(encoding="utf-8"))
    assert found["format"] == FORMAT
    assert {"processor", "cores", "numba", "when"} <= set(found["machine"])
    rows = [Row(**row) for row in found["rows"]]
    timed = [row for row in rows if row.section != "memory"]
    assert {row.name for row in timed} == set(FEW.split(","))
    assert {(row.width, row.height) for row in rows} == {(40, 32)}
    assert {row.unit for row in timed} == {"ns/px", "ms"}
    assert all(row.low <= row.median <= row.high and row.rounds >= 3 for row in timed)
    assert all(row.threads >= 1 for row in rows)
    shown = capsys.readouterr().out
    assert all(name in shown for name in FEW.split(","))
    assert "share of P" in shown
    assert "the rest of P" in shown

    assert main(["--size", "40x32", "--seconds", "0", "--stages", "gradient,dog", "--against", str(file)]) == 0
    shown = capsys.readouterr().out
    assert "ratio" in shown
    assert "the earlier time" in shown
    assert "other processes" in shown


@pytest.mark.parametrize(
    ("arguments", "hint"),
    [
        (["--stages", "gradiant"], "did you mean 'gradient'"),
        (["--stages", "fbl-nearest,p1"], "no stage 'p1'"),
        (["--size", "108p"], "did you mean '1080p'"),
        (["--size", "0x10"], "0x10"),
        (["--seconds", "-1"], "--seconds"),
        (["--seconds", "nan"], "--seconds"),
        (["--against", "nowhere.json"], "nowhere.json"),
        (["--json", "nowhere/out.json"], "no such folder"),
    ],
)
def test_a_wrong_command_says_so_before_anything_is_measured(arguments, hint, capsys):
    assert main(arguments) == 2
    told = capsys.readouterr()
    assert hint in told.err
    assert told.out == ""


@pytest.mark.parametrize("content", ["", "[]", '{"format": "flowabs.graph/1"}', '{"format": "flowabs.bench/1"}'])
def test_against_something_else_is_a_wrong_command(content, tmp_path, capsys):
    file = tmp_path / "other.json"
    file.write_text(content, encoding="utf-8")
    assert main(["--against", str(file)]) == 2
    assert "other.json" in capsys.readouterr().err


def test_help_imports_nothing_heavy():
    code = (
        "import sys\nfrom tools.bench.__main__ import main\n"
        "try:\n    main(['--help'])\nexcept SystemExit as end:\n    assert end.code == 0\n"
        "heavy = {'numba', 'numpy', 'colour', 'cv2', 'OpenImageIO'} & set(sys.modules)\nassert not heavy, heavy"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "fbl-nearest" in done.stdout


def test_every_case_runs():
    pytest.importorskip("cv2")
    plate = Plate(scene(40, 32))
    makers = {**{name: stage.case for name, stage in STAGES.items()}, **PIPELINES, **PEERS}
    for maker in makers.values():
        case = maker(plate)
        result = case.run(case.fresh())
        first = result[0] if isinstance(result, tuple) else result
        assert first.shape[:2] == (32, 40)
        assert np.isfinite(first).all()


def test_what_is_common_is_subtracted_and_iterations_are_counted(monkeypatch):
    clock = iter([0.0, 7.0, 10.0, 11.0])
    monkeypatch.setattr("tools.bench.timing.time.perf_counter", lambda: next(clock))
    assert Case(lambda _: None, less=lambda _: None, per=3).seconds() == (7.0, 1.0)


def test_each_case_gets_a_fresh_input_on_each_number_of_threads():
    made = []
    cases = {"one": Case(made.remove, fresh=lambda: made.append(len(made)) or made[-1]), "other": Case(lambda _: None)}
    taken = measure(cases, (1, 1), 0)
    assert set(taken) == {("one", 1), ("other", 1)}
    assert made == []
    assert all(spread.rounds >= 3 for spread in taken.values())


def test_the_least_is_of_what_ran_and_not_of_differences():
    case = Case(lambda _: None, less=lambda _: None, per=2)
    assert case.spread([(7.0, 1.0), (8.0, 6.0), (6.0, 2.0)]) == Spread(2.0, 1.5, 2.5, 2.5, 3)


def test_spread():
    assert Spread.of([5.0, 1.0, 2.0, 4.0, 3.0]) == Spread(3.0, 2.0, 4.0, 1.0, 5)
    assert Spread.of([2.0]).times(10) == Spread(20.0, 20.0, 20.0, 20.0, 1)


def test_ratios_are_of_the_same_figures_only(tmp_path):
    row = Row.of("stage", "fdog", (40, 32), 1, "ns/px", Spread(10.0, 9.0, 11.0, 8.0, 3))
    other = Row.of("stage", "fill", (40, 32), 1, "ns/px", Spread(10.0, 9.0, 11.0, 8.0, 3))
    file = tmp_path / "earlier.json"
    file.write_text(to_json([replace(row, least=16.0), replace(other, width=41)]), encoding="utf-8")
    shown = table([row, other], {}, from_json(file)).splitlines()
    assert next(line for line in shown if line.startswith("fdog")).endswith("10.00  20%    8.00  0.50x")
    assert next(line for line in shown if line.startswith("fill")).endswith("-")
    assert shown[-1].startswith("stages and pipelines: 0.50x the earlier time (1 figures")


def test_shares_are_of_the_pipeline():
    size = (1000, 1000)
    stage = Row.of("stage", "etf-full", size, 1, "ns/px", Spread.of([5.0]))
    whole = Row.of("pipeline", "P", size, 1, "ms", Spread.of([60.0]))
    shown = table([stage, whole], {"etf-full": 3})
    assert "25.0%" in shown
    assert "75.0%" in shown


def test_scaling_measures_every_value_and_fits_a_line(monkeypatch):
    monkeypatch.setattr(scaling, "SWEEPS", {"blur sigma": ((1, 2, 4), scaling.SWEEPS["blur sigma"][1])})
    rows = [*scaling.sweeps((40, 32), 0), *scaling.pixels(0, sides=(24, 40)), *scaling.threads((40, 32), 1, 0)]
    found = [(row.name, row.value) for row in rows]
    assert found == [
        ("blur sigma", 1),
        ("blur sigma", 2),
        ("blur sigma", 4),
        ("P width", 24),
        ("P width", 40),
        ("P threads", 1),
    ]
    shown = table(rows, {})
    assert "per px, R^2" in shown
    assert len({row.key for row in rows}) == len(rows)


def test_the_picture_is_the_same_each_time_and_like_a_photograph():
    picture = scene(128, 96)
    assert picture.shape == (96, 128, 3)
    assert picture.dtype == np.float32
    np.testing.assert_array_equal(picture, scene(128, 96))
    assert picture.min() > 0
    assert (picture > 1).any()
    plate = Plate(picture)
    assert measure_reference(plate.code, "p99") > 4 * measure_reference(plate.code, "p50")


def test_memory_is_that_of_the_pipeline_alone():
    found = peak("P", scene(700, 500))
    if found is None:
        pytest.skip("this system does not tell")
    assert 20 < found < 2000
