import ast
import copy
import pickle
from pathlib import Path

import pytest

import flowabs_nodes
from flowabs_nodes import choices, file_choices
from flowabs_nodes.choices import Choices

LISTS = {name: value for name, value in (vars(choices) | vars(file_choices)).items() if isinstance(value, Choices)}
PACKAGE = Path(flowabs_nodes.__file__).parent


@pytest.mark.parametrize("name", LISTS)
def test_each_word_says_in_a_line_what_it_does(name):
    words = LISTS[name]
    assert len(words) >= 2
    assert tuple(words.meaning) == words
    assert all(0 < len(meaning) <= 80 for meaning in words.meaning.values())


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda words: pickle.loads(pickle.dumps(words))])
def test_a_copy_keeps_the_meanings(copied):
    again = copied(choices.SPACES)
    assert again == choices.SPACES
    assert again.meaning == choices.SPACES.meaning
    assert again.label == choices.SPACES.label


@pytest.mark.parametrize("name", LISTS)
def test_each_word_has_a_label_of_its_own(name):
    words = LISTS[name]
    assert tuple(words.label) == words
    assert len(set(words.label.values())) == len(words)
    assert all(label[0].isupper() or label[0].isdigit() for label in words.label.values())


@pytest.mark.parametrize(("name", "label"), [("pre_blur", "Pre blur"), ("x", "X"), ("fdogIterative", "FdogIterative")])
def test_a_name_of_code_is_made_readable(name, label):
    assert choices.readable(name) == label


def test_no_list_is_written_a_second_time():
    again = []
    for path in PACKAGE.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Tuple | ast.List | ast.Set):
                words = [item.value for item in node.elts if isinstance(item, ast.Constant)]
                if len(words) == len(node.elts) and any(set(words) == set(each) for each in LISTS.values()):
                    again.append(f"{path.relative_to(PACKAGE)}:{node.lineno}: {words}")
    assert again == []
