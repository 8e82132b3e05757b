import numpy as np
import pytest

from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.nodes.frame_offsets import frame_offsets
from tests.engine.fakes import ADD
from tests.engine.windows import MEAN, asking


def test_offsets_follow_from_parameters():
    assert frame_offsets(MEAN, {"radius": 2, "mix": 1.0}) == {"image": (-2, -1, 0, 1, 2)}
    assert frame_offsets(MEAN, {"radius": 64})["image"][0] == -64


def test_a_node_without_frames_has_none():
    assert frame_offsets(ADD, {}) == {}


@pytest.mark.parametrize(
    "asked", [{"image": [1, 0, -3]}, {"image": tuple(np.array([1, 0, -3]))}, {"image": (0, 1, -3)}]
)
def test_offsets_come_in_order_as_ints(asked):
    found = frame_offsets(asking(asked), {})["image"]
    assert found == (-3, 0, 1)
    assert {type(each) for each in found} == {int}


def test_a_node_cannot_change_its_parameters_while_it_says_what_it_reads():
    params = {"radius": 1}
    frame_offsets(asking(lambda given: given.clear() or {"image": (0,)}), params)
    assert params == {"radius": 1}


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"image": range(-1000, 1001)}, "asks for 2001 frames for input 'image': at most 64 frames before and after"),
        ({"image": range(-(10**15), 10**15)}, "at most 64 frames"),
        ({"image": (0, 1000)}, "asks for offset 1000 for input 'image': at most 64"),
        ({"image": (-65, 0)}, "offset -65"),
        ({"image": (-1, 1)}, "0 must be among the offsets"),
        ({"image": ()}, "0 must be among the offsets"),
        ({"image": (0, 1.0)}, "offset 1.0 for input 'image': offsets must be whole numbers"),
        ({"image": (0, "1")}, "offset '1'"),
        ({"image": (0, True)}, "offset True"),
        ({"image": (0, float("nan"))}, "offset nan"),
        ({"image": (0, 1, 1)}, "offset 1 twice"),
        ({"image": 0}, "must return a tuple of frame offsets for input 'image', not int"),
        ({"image": "012"}, "not str"),
        ({"imgae": (0,)}, "names 'imgae', which is no input of the node.*did you mean 'image'"),
        ({"mask": (0,)}, "names 'mask'"),
        ((0, 1), "must return a dict from input to frame offsets, not tuple"),
        (None, "not NoneType"),
    ],
)
def test_a_wrong_answer_names_the_node_and_the_rule(asked, words):
    with pytest.raises(FlowabsError, match=rf"frames\(\) of mean@1 .*{words}") as failure:
        frame_offsets(asking(asked), {})
    assert failure.value.code == "wrong-frames"
