"""From what is asked for to a job and its frames; what is wrong with the command is said before the first frame."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import TypeVar

from flowabs_nodes.choices import EXISTING, MISSING
from flowabs_nodes.color.config import config
from flowabs_nodes.engine.job import Job
from flowabs_nodes.engine.lengths import check_scale
from flowabs_nodes.engine.plan import file_role, make_plan, sinks
from flowabs_nodes.engine.sources import file_of
from flowabs_nodes.errors import CommandError, ReadError, WriteError, nearest
from flowabs_nodes.graph.model import Graph
from flowabs_nodes.graph.overrides import override
from flowabs_nodes.io import formats
from flowabs_nodes.io.frame_lock import check_writable
from flowabs_nodes.io.sequences import Sequence, parse_frames
from flowabs_nodes.io.settings import Settings, checked
from flowabs_nodes.nodes import catalogue as installed
from flowabs_nodes.nodes.declare import Node

PathLike = str | os.PathLike[str]
Word = TypeVar("Word", bound=str)


def prepare(
    graph: Graph,
    *,
    input: PathLike | None = None,
    output: PathLike | Iterable[PathLike] | None = None,
    frames: str | int | Iterable[int] | None = None,
    scale: float = 1.0,
    existing: str = "resume",
    missing: str | None = None,
    settings: Settings | None = None,
) -> tuple[Job, tuple[int, ...]]:
    """The job and the frames to make.

    Raises
    ------
    CommandError
        Where the command cannot be carried out at all; nothing has been written then.
    ColorError
        The OCIO config cannot be read.
    """
    settings = settings or Settings()
    if settings.ocio is not None:
        config(settings.ocio)
    how = _word("existing", existing, EXISTING)
    policy = None if missing is None else _word("missing", missing, MISSING)
    graph, further = _with_files(graph, input, _listed(output))
    values = graph.values(1)
    writes = sinks(graph)
    if not writes:
        hint = "graph.run(...) gives its images in Python"
        raise CommandError("the graph has no write node", code="no-write", hint=hint)
    steps = make_plan(graph, 1, sinks=writes)
    reads = [step.unit.node for step in steps if file_role(graph, step.unit.node) == "input"]
    with _as_command_errors():
        inputs = [Sequence(file_of(graph, name, values[name])) for name in reads]
        outputs = {name: (file_of(graph, name, values[name]), *further) for name in writes}
        for sequence in inputs:
            checked(sequence.pattern, settings)
        numbers = _numbers(frames, inputs)
        targets = _targets([Sequence(pattern) for patterns in outputs.values() for pattern in patterns], numbers)
        for path in targets:
            checked(path, settings)
    _refuse_inputs(targets, inputs, numbers)
    _check_folders(targets)
    return Job(graph.document, outputs, settings, check_scale(scale), how, policy, _catalogue(graph)), numbers


# ---------------------------------------------------------------------- what was asked for


def _word(name: str, value: str, words: tuple[Word, ...]) -> Word:
    for word in words:
        if value == word:
            return word
    expected = ", ".join(words)
    hint = nearest(value, words)
    raise CommandError(
        f"{name}: expected one of {expected}, found {value!r}", code="bad-value", hint=hint, parameter=name
    )


def _listed(output: PathLike | Iterable[PathLike] | None) -> list[str]:
    if output is None:
        return []
    return [os.fspath(each) for each in ([output] if isinstance(output, str | os.PathLike) else output)]


def _with_files(graph: Graph, input: PathLike | None, outputs: list[str]) -> tuple[Graph, tuple[str, ...]]:
    """The graph with the file of its only read and of its only write set, and the further outputs."""
    files = {}
    if input is not None:
        files[f"{_only(graph, 'read', '-i')}.file"] = os.fspath(input)
    if outputs:
        files[f"{_only(graph, 'write', '-o')}.file"] = outputs[0]
    return (override(graph, files) if files else graph), tuple(outputs[1:])


def _only(graph: Graph, type: str, option: str) -> str:
    """The name of the graph's only node of that type."""
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


def _numbers(frames: str | int | Iterable[int] | None, inputs: list[Sequence]) -> tuple[int, ...]:
    """The frames asked for; else every frame on disk of any input, so that one that is missing in another is seen."""
    if isinstance(frames, str):
        return parse_frames(frames)
    if frames is not None:
        numbers = tuple(dict.fromkeys([frames] if isinstance(frames, int) else frames))
        if not numbers or not all(isinstance(number, int) and not isinstance(number, bool) for number in numbers):
            raise CommandError(f"expected a range or whole numbers, found {frames!r}", code="bad-frames")
        return numbers
    numbered = [sequence for sequence in inputs if sequence.has_token]
    if not numbered:
        return (1,)
    on_disk = {number for sequence in numbered for number in sequence.frames_on_disk()}
    if not on_disk:
        patterns = ", ".join(sequence.pattern for sequence in numbered)
        raise CommandError("there are no frames of this sequence", code="no-frames", file=patterns)
    return tuple(sorted(on_disk))


# ---------------------------------------------------------------------- files


def _targets(outputs: list[Sequence], numbers: tuple[int, ...]) -> list[str]:
    """Every file that will be written, each once."""
    for sequence in outputs:
        formats.to_write(sequence.pattern)
        if len(numbers) > 1 and not sequence.has_token:
            raise CommandError(
                f"{len(numbers)} frames would go to one file",
                code="no-frame-token",
                hint="put #### where the frame number belongs",
                file=sequence.pattern,
            )
    paths = [sequence.path(number) for number in numbers for sequence in outputs]
    real = [os.path.realpath(path) for path in paths]
    if len(set(real)) < len(real):
        twice = next(path for path, each in zip(paths, real, strict=True) if real.count(each) > 1)
        raise CommandError("two outputs would be this one file", code="same-output", file=twice)
    return paths


def _refuse_inputs(targets: list[str], inputs: list[Sequence], numbers: tuple[int, ...]) -> None:
    """Raise where a file to write is, through any link, one that any frame may read."""
    sources = {
        os.path.realpath(sequence.path(number))
        for sequence in inputs
        for number in {*numbers, *(sequence.frames_on_disk() if sequence.has_token else ())}
    }
    identities = {identity for path in sources if (identity := _identity(path))}
    for path in targets:
        if os.path.realpath(path) in sources or _identity(path) in identities:
            raise CommandError("would be written over an input", code="output-is-input", file=path)


def _identity(path: str) -> tuple[int, int] | None:
    """What is the same for two names of one file; None where there is no file."""
    try:
        state = os.stat(path)
    except (OSError, ValueError):
        return None
    return state.st_dev, state.st_ino


def _check_folders(targets: list[str]) -> None:
    """Raise where files could not be made: in the folder of any target, or where it would have to be made."""
    for folder in sorted({os.path.dirname(path) or "." for path in targets}):
        try:
            check_writable(folder)
        except WriteError as error:
            if error.code != "disk-full":  # that is the frames' business: some may be there already
                raise CommandError(error.message, code="unwritable-folder", file=folder) from error


@contextmanager
def _as_command_errors() -> Iterator[None]:
    """A name that cannot be read or written at all is a wrong command."""
    try:
        yield
    except (ReadError, WriteError) as error:
        raise CommandError(error.message, code=error.code, hint=error.hint, file=error.file) from error


def _catalogue(graph: Graph) -> Mapping[str, Node] | None:
    """The graph's declarations, where another process would not find them installed."""
    used = {node.declaration.type: node.declaration for node in graph.nodes.values()}
    known = installed()
    return None if all(known.get(type) is declaration for type, declaration in used.items()) else used
