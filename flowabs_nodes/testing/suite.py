"""Lists all checks of a node, and runs them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.nodes.declare import MASK, Node
from flowabs_nodes.testing import checks, frame_windows, parameters, regions
from flowabs_nodes.testing.running import ComplianceError, require


@dataclass(frozen=True)
class Check:
    """Checks one thing of a node: calling it raises :class:`ComplianceError` if the node fails."""

    name: str
    run: Callable[[], None]

    def __call__(self) -> None:
        self.run()


def compliance_checks(node: Node) -> list[Check]:
    """Return all checks of ``node``."""
    found: dict[str, Callable[[], None]] = {"is_documented": partial(checks.is_documented, node)}
    for param in node.all_params.values():
        if param.kind != "file":  # a file counts by its content
            found[f"{param.name}_changes_the_key"] = partial(parameters.changes_the_key, node, param)
        if param.enabled_when:
            found[f"{param.name}_does_nothing_where_disabled"] = partial(parameters.nothing_where_disabled, node, param)
    if node.file_param is not None:
        found["reads_or_takes_a_picture"] = partial(checks.reads_or_takes_a_picture, node, node.file_param)
    else:
        found |= {
            "runs_with_defaults": partial(checks.runs_with_defaults, node),
            "takes_small_pictures": partial(checks.takes_small_pictures, node),
            "takes_every_type_it_declares": partial(checks.takes_every_type, node),
            "keeps_windows_and_metadata": partial(checks.keeps_windows_and_metadata, node),
            "leaves_inputs_alone": partial(checks.leaves_inputs_alone, node),
            "survives_nan_and_inf": partial(checks.survives_nan_and_inf, node),
            "gives_the_same_again": partial(checks.gives_the_same_again, node),
            "owes_to_the_frame_what_it_says": partial(checks.owes_to_the_frame_what_it_says, node),
            "gives_the_same_bits_on_any_number_of_threads": partial(checks.same_on_any_number_of_threads, node),
        }
        if node.region is not None:
            found["works_on_a_region"] = partial(regions.works_on_a_region, node)
        if node.frames is not None:
            found |= {
                "asks_for_frames_by_the_rules": partial(frame_windows.asks_by_the_rules, node),
                "takes_windows_that_are_cut": partial(frame_windows.takes_windows_that_are_cut, node),
                "gives_the_same_alone_in_a_run_and_in_another_order": partial(frame_windows.same_in_any_order, node),
            }
        if any(port.name == MASK.name for port in node.inputs):
            found["mask_of_one_is_no_mask"] = partial(checks.mask_of_one_is_no_mask, node)
        if node.mixes:
            found["mixes"] = partial(checks.mixes, node)
        for param in node.all_params.values():
            if param.in_key:
                found[f"{param.name}_changes_the_picture"] = partial(parameters.changes_the_picture, node, param)
    return [Check(name, run) for name, run in found.items()]


def check_node(node: Node) -> None:
    """Run all checks of ``node``; raise one :class:`ComplianceError` that names every failure."""
    failures = []
    for check in compliance_checks(node):
        try:
            check()
        except (ComplianceError, FlowabsError) as error:
            failures.append(f"{check.name}: {error}")
    require(not failures, f"{node.name}:\n" + "\n".join(failures))
