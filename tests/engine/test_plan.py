import pytest

from flowabs_nodes.engine.plan import Result, Unit, make_plan, named_result, unit_inputs
from flowabs_nodes.errors import CommandError
from tests.engine.fakes import ADD, SPLIT, graph, node

DIAMOND = graph(
    node("a", ADD),
    node("left", ADD, {"image": "a"}),
    node("right", ADD, {"image": "a"}),
    node("both", ADD, {"image": "left", "mask": "right"}),
    node("tones", SPLIT, {"image": "both"}),
    node("unused", ADD, {"image": "a"}),
)


def names(steps):
    return [step.unit.node for step in steps]


def test_only_what_is_needed_runs_once_and_after_what_it_needs():
    steps = make_plan(DIAMOND, 7, results=[Result("tones", "mono", 7)])
    assert names(steps) == ["a", "left", "right", "both", "tones"]
    assert all(step.unit.frame == 7 for step in steps)


def test_each_node_knows_which_of_its_outputs_are_asked_for():
    steps = make_plan(DIAMOND, 1, results=[Result("tones", "mono", 1)])
    assert steps[-1].wanted == {"mono"}
    assert steps[0].wanted == {"image"}


def test_results_are_dropped_after_their_last_use_but_not_those_asked_for():
    steps = make_plan(DIAMOND, 1, results=[Result("tones", "matte", 1), Result("left", "image", 1)])
    drops = {step.unit.node: {each.node for each in step.drops} for step in steps}
    assert drops == {"a": set(), "left": set(), "right": {"a"}, "both": {"right"}, "tones": {"both"}}


def test_a_branch_is_finished_before_the_next_begins():
    wide = graph(
        node("a", ADD),
        node("b1", ADD, {"image": "a"}),
        node("b2", ADD, {"image": "b1"}),
        node("c1", ADD, {"image": "a"}),
        node("c2", ADD, {"image": "c1"}),
        node("end", ADD, {"image": "b2", "mask": "c2"}),
    )
    assert names(make_plan(wide, 1, results=[Result("end", "image", 1)])) == ["a", "b1", "b2", "c1", "c2", "end"]


def test_the_branch_whose_result_is_held_in_less_memory_comes_first():
    drawing = graph(
        node("plate", ADD),
        node("smooth", ADD, {"image": "plate"}),
        node("tones", SPLIT, {"image": "plate"}),
        node("comp", ADD, {"image": "smooth", "mask": "tones.matte"}),
    )
    assert names(make_plan(drawing, 1, results=[Result("comp", "image", 1)])) == ["plate", "tones", "smooth", "comp"]


def test_what_is_given_is_not_computed_nor_what_only_it_needs():
    given = {Result("both", "image", 1)}
    assert names(make_plan(DIAMOND, 1, results=[Result("tones", "mono", 1)], given=given)) == ["tones"]
    assert make_plan(DIAMOND, 1, results=[Result("both", "image", 1)], given=given) == ()


def test_a_node_with_one_output_given_still_makes_the_others():
    results = [Result("tones", "mono", 1), Result("tones", "matte", 1)]
    (*_, last) = make_plan(DIAMOND, 1, results=results, given={results[0]})
    assert last.unit == Unit("tones", 1)
    assert last.wanted == {"matte"}


def test_a_chain_of_ten_thousand_nodes():
    chain = graph(node("n0", ADD), *(node(f"n{i}", ADD, {"image": f"n{i - 1}"}) for i in range(1, 10_000)))
    steps = make_plan(chain, 1, results=[Result("n9999", "image", 1)])
    assert len(steps) == 10_000
    assert steps[-1].drops == {Result("n9998", "image", 1)}


def planned(window, results, given=()):
    """Plan the last result of a chain in which nodes named in ``window`` read the frames at these offsets."""
    chain = graph(node("a", ADD), node("b", ADD, {"image": "a"}), node("c", ADD, {"image": "b"}))

    def inputs_of(unit):
        return unit_inputs(chain, unit, {"image": window[unit.node]} if unit.node in window else {})

    return make_plan(chain, 5, results=results, given=given, inputs_of=inputs_of)


def test_a_window_of_frames_is_computed_a_frame_at_a_time():
    steps = planned({"c": (-1, 0, 1)}, [Result("c", "image", 5)])
    assert [step.unit for step in steps] == [
        *(Unit("a", 4), Unit("b", 4), Unit("a", 5), Unit("b", 5), Unit("a", 6), Unit("b", 6)),
        Unit("c", 5),
    ]
    assert steps[-1].inputs == {"image": {offset: Result("b", "image", 5 + offset) for offset in (-1, 0, 1)}}
    assert steps[-1].drops == set(steps[-1].needs) == {Result("b", "image", frame) for frame in (4, 5, 6)}
    assert steps[1].drops == {Result("a", "image", 4)}
    assert steps[-1].makes == (Result("c", "image", 5),)


def test_windows_along_a_chain_add_up_and_each_frame_is_computed_once():
    steps = planned({"c": (-1, 0, 1), "b": (0, 2)}, [Result("c", "image", 5)])
    frames = [step.unit.frame for step in steps if step.unit.node == "a"]
    assert sorted(frames) == [4, 5, 6, 7, 8]
    assert len(steps) == len({step.unit for step in steps})


def test_frames_that_are_given_are_not_computed():
    given = {Result("b", "image", 4), Result("a", "image", 6)}
    steps = planned({"c": (-1, 0, 1)}, [Result("c", "image", 5)], given)
    assert [step.unit for step in steps] == [Unit("a", 5), Unit("b", 5), Unit("b", 6), Unit("c", 5)]


def test_names_of_results():
    assert named_result(DIAMOND, "tones", 3) == Result("tones", "matte", 3)
    assert named_result(DIAMOND, "tones.mono", 3) == Result("tones", "mono", 3)


@pytest.mark.parametrize(
    ("name", "code", "words"),
    [
        ("tone", "unknown-node", "did you mean 'tones'"),
        ("tones.mon", "unknown-output", "did you mean 'mono'"),
        ("", "unknown-node", "no node ''"),
    ],
)
def test_names_that_do_not_exist(name, code, words):
    with pytest.raises(CommandError, match=words) as failure:
        named_result(DIAMOND, name, 1)
    assert failure.value.code == code
