"""Knobs as a panel shows them."""

from flowabs_nodes.engine.knob_states import knob_states
from flowabs_nodes.graph import load, override


def graph(**knobs):
    """Return a graph whose knobs drive a switch between drawings, and what each drawing has."""
    return load(
        {
            "format": "flowabs.graph/1",
            "interface": {
                "form": {"type": "enum", "default": "paper", "choices": ["paper", "xdog"], "group": "Lines"},
                "phi": {"type": "float", "default": 2, "min": 0.1, "max": 9, "label": "Sharpness", "unit": ""},
                "amount": {"type": "float", "default": {"curve": {"1": 1, "11": 2}}, "min": 0, "max": 5},
                "which": {"type": "int", "default": 0, "min": 0, "max": 1},
                **knobs,
            },
            "nodes": {
                "plate": {"type": "read@1"},
                "dog": {
                    "type": "dog@1",
                    "inputs": {"image": "plate"},
                    "params": {"form": {"from": "form"}, "phi": {"from": "phi"}},
                },
                "bright": {"type": "exposure@1", "inputs": {"image": "plate"}, "params": {"stops": {"from": "amount"}}},
                "chosen": {
                    "type": "switch@1",
                    "inputs": {"a": "plate", "b": "bright"},
                    "params": {"which": {"from": "which"}},
                },
                "out": {"type": "write@1", "inputs": {"image": "chosen", "ink": "dog"}},
            },
        }
    )


def states(changed=None, frame=1):
    loaded = graph()
    return {state.name: state for state in knob_states(loaded, override(loaded, changed or {}), frame)}


def test_label_group_range_and_value():
    found = states({"phi": 3})
    assert (found["phi"].label, found["phi"].group, found["phi"].value, found["phi"].default) == ("Sharpness", "", 3, 2)
    assert (found["form"].label, found["form"].group, found["form"].choices) == ("Form", "Lines", ("paper", "xdog"))
    assert (found["phi"].min, found["phi"].max) == (0.1, 9)


def test_the_value_is_that_of_the_frame():
    assert states(frame=6)["amount"].value == 1.5
    assert states()["amount"].animated
    assert not states()["phi"].animated
    assert not states({"amount": 2})["amount"].animated


def test_a_knob_is_enabled_where_turning_it_changes_something():
    def on(changed):
        return {name for name, state in states(changed).items() if state.enabled}

    assert on({}) == {"form", "which"}  # phi does nothing beside the paper's form; bright is not chosen
    assert on({"form": "xdog"}) == {"form", "phi", "which"}
    assert on({"which": 1}) == {"amount", "form", "which"}
