"""Builds a job and its list of frames from what is asked for; a wrong command is refused before the first frame."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial

from flowabs_nodes.color.config import opened
from flowabs_nodes.engine.color_names import wrong_names
from flowabs_nodes.engine.display_names import wrong_views
from flowabs_nodes.engine.frame_numbers import frame_numbers
from flowabs_nodes.engine.job import Job
from flowabs_nodes.engine.options import PathLike, RunOptions
from flowabs_nodes.engine.plan import file_role, make_plan, sinks
from flowabs_nodes.engine.plate_file import with_plate_file
from flowabs_nodes.engine.sources import file_of, reads_pictures
from flowabs_nodes.engine.target_files import RealNames, check_folders, refuse_inputs, target_paths
from flowabs_nodes.engine.unit_params import UnitParams, inputs_on_any_frame
from flowabs_nodes.errors import CommandError, ReadError, WriteError
from flowabs_nodes.graph.missing_packages import refuse_missing_packages
from flowabs_nodes.graph.model import Graph
from flowabs_nodes.graph.overrides import override
from flowabs_nodes.graph.problems import GraphError
from flowabs_nodes.io import formats
from flowabs_nodes.io.sequences import Sequence
from flowabs_nodes.io.settings import checked
from flowabs_nodes.nodes import catalogue as installed
from flowabs_nodes.nodes.declare import Node


def build_job(graph: Graph, options: RunOptions, *, touch: bool = True) -> tuple[Job, tuple[int, ...]]:
    """Return the job, and the numbers of the frames to render.

    ``options.set`` has been applied to ``graph``; the files that ``options`` name are set here. Whether the folders of
    the outputs can be written to is tried by writing, unless ``touch`` is False.

    Raises
    ------
    GraphError
        missing-package, where a node that is to run needs one that is not installed.
    CommandError
        The command cannot be carried out at all; nothing has been written then.
    ColorError
        The OCIO config cannot be read.
    GraphError
        It does not know the name of a colour space, a display or a view.
    """
    settings = options.settings
    config = opened(settings.ocio)
    graph, further = set_files(graph, options)
    values = graph.values(1)
    writes = sinks(graph)
    if not writes:
        hint = "graph.run(...) gives its images in Python"
        raise CommandError("the graph has no write node", code="no-write", hint=hint)
    needs = partial(inputs_on_any_frame, graph, params=UnitParams(graph))
    steps = make_plan(graph, 1, sinks=writes, inputs_of=needs)
    refuse_missing_packages(graph, {step.unit.node for step in steps})
    used = {step.unit.node for step in steps}
    wrong = [*wrong_names(graph, config, used), *wrong_views(graph, config, used)]
    if wrong:
        raise GraphError(wrong, file=graph.source or None)
    reads = [step.unit.node for step in steps if file_role(graph, step.unit.node) == "input"]
    with as_command_errors():
        inputs = [Sequence.to_read(file_of(graph, name, values[name])) for name in reads]
        outputs = {name: (file_of(graph, name, values[name]), *further) for name in writes}
        for sequence in inputs:
            checked(sequence.pattern, settings)
        for sequence in (each for name, each in zip(reads, inputs, strict=True) if reads_pictures(graph, name)):
            check_format(sequence)
        numbers = frames_asked_for(options.frames, inputs)
        patterns = [Sequence(pattern) for patterns in outputs.values() for pattern in patterns]
        targets = target_paths(patterns, numbers, settings, real_names := RealNames())
    refuse_inputs(targets, inputs, numbers, (graph.source, options.ocio or ""), real_names)
    check_folders((each.pattern for each in patterns), touch=touch)
    return Job(graph.document, outputs, options.for_frames(), _foreign_nodes(graph)), numbers


# ---------------------------------------------------------------------- what was asked for


def set_files(graph: Graph, options: RunOptions) -> tuple[Graph, tuple[str, ...]]:
    """Set the file of the graph's only read and of its only write; return the graph and the further outputs.

    Nodes that read passes, and have no file, get that of the plate.
    """
    files = {}
    if options.input is not None:
        files[f"{_only(graph, 'read', '-i')}.file"] = os.fspath(options.input)
    outputs = as_list(options.output)
    if outputs:
        files[f"{_only(graph, 'write', '-o')}.file"] = outputs[0]
    return with_plate_file(override(graph, files) if files else graph), tuple(outputs[1:])


def as_list(output: PathLike | Iterable[PathLike] | None) -> list[str]:
    """Return the names of all outputs that are asked for, be it none, one or several."""
    if output is None:
        return []
    return [os.fspath(each) for each in ([output] if isinstance(output, str | os.PathLike) else output)]


def _only(graph: Graph, type: str, option: str) -> str:
    """Return the name of the graph's only node of a type; raise CommandError where it has none or several."""
    names = [name for name, node in graph.nodes.items() if node.declaration.type == type]
    if len(names) == 1:
        return names[0]
    if not names:
        raise CommandError(f"{option}: the graph has no {type} node", code=f"no-{type}")
    raise CommandError(
        f"{option}: the graph has {len(names)} {type} nodes, {', '.join(names)}",
        code=f"several-{type}s",
        hint=f"--set {names[0]}.file=FILE says which",
    )


def frames_asked_for(frames: str | int | Iterable[int] | None, inputs: list[Sequence]) -> tuple[int, ...]:
    """Return the numbers of the frames asked for, or else of every frame on disk.

    A single picture is frame 1, or the number in its name (``move.0004.exr``) if it has one. A frame that one input has
    on disk counts even where another input lacks it, so that its absence is told.
    """
    if frames is not None:
        return frame_numbers(frames)
    numbered = [sequence for sequence in inputs if sequence.has_token]
    if not numbered:
        return (next((number for each in inputs if (number := each.number_in_name) is not None), 1),)
    on_disk = {number for sequence in numbered for number in sequence.frames_on_disk()}
    if not on_disk:
        patterns = ", ".join(sequence.pattern for sequence in numbered)
        raise CommandError("there are no frames of this sequence", code="no-frames", file=patterns)
    return tuple(sorted(on_disk))


# ---------------------------------------------------------------------- files


def check_format(sequence: Sequence) -> None:
    """Raise ReadError where what is to be read can be no picture of the format that its name says.

    A single file is looked at: a folder or a device, or a file that begins as one of another format, is a wrong
    command. Whatever else is wrong with a file is its frame's business.
    """
    if not sequence.has_token:
        formats.check_kind(sequence.pattern)
    expected = formats.check_extension(sequence.pattern)
    if not sequence.has_token and formats.found_in(sequence.pattern) not in (None, expected):
        formats.to_read(sequence.pattern)


@contextmanager
def as_command_errors() -> Iterator[None]:
    """Raise ReadError and WriteError inside as CommandError: a name that no file can have is a wrong command."""
    try:
        yield
    except (ReadError, WriteError) as error:
        raise CommandError(error.message, code=error.code, hint=error.hint, file=error.file) from error


def _foreign_nodes(graph: Graph) -> Mapping[str, Node] | None:
    """Return the graph's declarations by type; None where another process finds them all installed."""
    used = {node.declaration.type: node.declaration for node in graph.nodes.values()}
    known = installed()
    return None if all(known.get(type) is declaration for type, declaration in used.items()) else used
