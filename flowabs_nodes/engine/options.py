"""Declares the options of a run, each once; they travel from the command line down as one object.

``flowabs run`` makes its flags and its help from :class:`RunOptions`, and ``fa.run`` its keywords; whatever they call
is handed the object. A new option is one more field here, and the code that reads it.
"""

from __future__ import annotations

import inspect
import os
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import Field, dataclass, field, fields, replace
from numbers import Integral, Real
from pathlib import Path
from typing import Any, TypeVar

from flowabs_nodes.engine.memory import parse_memory
from flowabs_nodes.errors import ArgumentError, CommandError, nearest
from flowabs_nodes.file_choices import EXISTING, MISSING
from flowabs_nodes.io.settings import Settings, refuse_shell_words

PathLike = str | os.PathLike[str]

_DECLARED = "flag"
_SCHEDULER = re.compile(r"local|tcp://(\[[0-9A-Fa-f:.%\w]+\]|[^\s:/\[\]]+):\d{1,5}")
Function = TypeVar("Function", bound=Callable[..., Any])


@dataclass(frozen=True)
class Flag:
    """How an option is given on the command line.

    Attributes
    ----------
    help
        What ``flowabs run --help`` says about it.
    short
        A second spelling of one letter, such as ``"-i"``; the long one is the field's name.
    metavar
        What stands for the value in the help.
    type
        Makes the value from its text; ``bool`` for a flag without a value.
    choices
        The only values that are accepted, from Python too.
    min
        The least whole number that is accepted.
    repeats
        The flag may be given several times: the field gets all values.
    show_default
        The help says the default.
    """

    help: str
    short: str = ""
    metavar: str | None = None
    type: Callable[[str], Any] = str
    choices: tuple[str, ...] = ()
    min: int | None = None
    repeats: bool = False
    show_default: bool = False


def _flag(help: str, **how: Any) -> dict[str, Flag]:
    """Return the metadata of a field that is given on the command line by ``Flag(help, **how)``."""
    return {_DECLARED: Flag(help, **how)}


def flag_of(option: Field[Any]) -> Flag:
    """Return how a field of :class:`RunOptions` is given on the command line."""
    declared: Flag = option.metadata[_DECLARED]
    return declared


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """What one run is asked to do: with which files and frames, by which rules. It can be pickled.

    Parameters
    ----------
    input
        File or pattern (``shot.####.exr``) of the graph's only ``read``.
    output
        File or pattern of the graph's only ``write``; of several, each further one gets the same image in its format.
    frames
        A range such as ``"1001-1100x2,1200"``, or numbers. Without it every frame that is on disk; a single picture is
        frame 1.
    set
        Values of knobs and parameters: ``{"line_width": 1.5, "lines.softness": 2}``.
    existing
        What happens to files that are there: "resume" keeps what is whole and has the right key, and makes again what
        the same graph made at the same scale; any other file fails its frame. "overwrite" makes all again, "error"
        fails those frames.
    missing
        What happens on missing input frames, before the nodes' own policy: error, hold, nearest, black, skip.
    jobs
        How many frames are rendered at once, each in a process of its own. Without it, frames are rendered in this
        process until it is known that others pay, and then as many at once as the processors and ``memory`` allow.
    threads
        How many threads the kernels of all jobs use together. Without it, as many as there are processors.
    memory
        What all jobs together may take: bytes, or a text such as "16GB" or "50%" of what there is; 80 % without it.
        A single frame that needs more is rendered alone.
    timeout
        Seconds that one frame may take; after that its process is ended.
    retries
        How often a frame is tried again whose process was lost or late, or for which a disk or the network failed for
        a moment.
    scheduler
        Where frames are rendered: "tcp://host:port" is a scheduler of Dask, whose workers see the same files; "local"
        starts one on this machine. ``jobs`` is then how many frames are at work on all workers, and ``memory`` what
        each worker may take (with "local": all of them). Without it, frames are rendered by processes of this run.
    scale
        Above 0 up to 1: filters and writes a smaller picture, with lengths to match.
    root
        Nothing outside this folder is read or written, symbolic links included.
    max_pixels
        The most pixels that a frame may have; a larger one is refused.
    ocio
        An OpenColorIO config (a path, or "ocio://..."). Without it, what ``$OCIO`` says when the run begins, else the
        built-in one.

    Raises
    ------
    CommandError
        bad-value, where an option is none of its choices.
    ArgumentError
        bad-value, where a number or a size is out of range.
    """

    input: PathLike | None = field(
        default=None,
        metadata=_flag("File or sequence of the graph's only read: shot.####.exr.", short="-i", metavar="FILE"),
    )
    output: PathLike | Iterable[PathLike] | None = field(
        default=None,
        metadata=_flag(
            "File or sequence of the graph's only write. Again: the same image in that file's format too.",
            short="-o",
            metavar="FILE",
            repeats=True,
        ),
    )
    frames: str | int | Iterable[int] | None = field(
        default=None, metadata=_flag("1001-1100x2,1200. Without it: every frame on disk.", metavar="RANGE")
    )
    set: Mapping[str, Any] | None = field(
        default=None,
        metadata=_flag(
            "Set a knob, or any parameter as node.parameter. JSON if it parses, else a text.",
            metavar="NAME=VALUE",
            repeats=True,
        ),
    )
    existing: str = field(
        default="resume",
        metadata=_flag(
            "About files that are there: resume keeps what is whole and was made from the same.",
            choices=EXISTING,
            show_default=True,
        ),
    )
    missing: str | None = field(
        default=None,
        metadata=_flag("About frames of the plate that are not there; else as the graph says.", choices=MISSING),
    )
    jobs: int | None = field(
        default=None,
        metadata=_flag("Render N frames at once. Without it: as many as pay and fit.", metavar="N", type=int, min=1),
    )
    threads: int | None = field(
        default=None,
        metadata=_flag("Kernel threads of all jobs together. Without it: all.", metavar="N", type=int, min=1),
    )
    memory: str | int | None = field(
        default=None, metadata=_flag("What all jobs may take: 16GB, 50%. Without it: 80%.", metavar="SIZE")
    )
    timeout: float | None = field(
        default=None,
        metadata=_flag("A frame that takes longer has failed.", metavar="SECONDS", type=float),
    )
    retries: int = field(
        default=1,
        metadata=_flag(
            "How often a frame is tried again whose process was lost, or whose disk failed for a moment.",
            metavar="N",
            type=int,
            min=0,
        ),
    )
    scheduler: str | None = field(
        default=None,
        metadata=_flag("Render on Dask: tcp://HOST:PORT, or local for workers on this machine.", metavar="ADDRESS"),
    )
    scale: float = field(
        default=1.0, metadata=_flag("Filter a smaller picture, with lengths to match: 0.5 is half.", type=float)
    )
    root: Path | None = field(
        default=None, metadata=_flag("Read and write nothing outside DIR, links included.", metavar="DIR", type=Path)
    )
    max_pixels: int = field(
        default=Settings.max_pixels, metadata=_flag("Refuse larger pictures.", metavar="N", type=int, min=1)
    )
    ocio: str | None = field(
        default=None,
        metadata=_flag("An OpenColorIO config. Without it: $OCIO, else the built-in one.", metavar="CONFIG"),
    )

    def __post_init__(self) -> None:
        for option in fields(self):
            value, choices = getattr(self, option.name), flag_of(option).choices
            if choices and value != option.default and value not in choices:
                raise CommandError(
                    f"{option.name}: expected one of {', '.join(choices)}, found {value!r}",
                    code="bad-value",
                    hint=nearest(value, choices),
                    parameter=option.name,
                )
        if self.root is not None:
            refuse_shell_words(os.fspath(self.root))
        scale: Any = self.scale
        if getattr(scale, "ndim", None) == 0:  # NumPy's numbers become Python's
            scale = scale.item()
        if isinstance(scale, bool) or not isinstance(scale, Real) or not 0 < float(scale) <= 1:
            raise ArgumentError(f"scale: expected a number above 0 up to 1, found {scale!r}", parameter="scale")
        object.__setattr__(self, "scale", float(scale))
        for name in ("jobs", "threads", "retries"):
            self._check_count(name)
        timeout: Any = self.timeout
        is_number = isinstance(timeout, Real) and not isinstance(timeout, bool)
        if timeout is not None and not (is_number and float(timeout) > 0):
            raise ArgumentError(f"timeout: expected seconds above 0, found {timeout!r}", parameter="timeout")
        _ = self.memory_bytes
        if self.scheduler is not None and not _SCHEDULER.fullmatch(str(self.scheduler)):
            raise ArgumentError(
                f"scheduler: expected local or tcp://HOST:PORT, found {self.scheduler!r}",
                code="bad-value",
                parameter="scheduler",
            )

    def _check_count(self, name: str) -> None:
        """Raise ArgumentError where an option that counts something is no whole number, or too small."""
        value, least = getattr(self, name), next(flag_of(each).min for each in fields(self) if each.name == name) or 0
        if value is None and name != "retries":
            return
        if isinstance(value, bool) or not isinstance(value, Integral) or value < least:
            raise ArgumentError(
                f"{name}: expected a whole number from {least} up, found {value!r}", code="bad-value", parameter=name
            )
        object.__setattr__(self, name, int(value))

    @property
    def memory_bytes(self) -> int | None:
        """Return ``memory`` in bytes. Raises ArgumentError where it is no size."""
        if self.memory is None:
            return None
        try:
            return parse_memory(self.memory)
        except ValueError as error:
            raise ArgumentError(f"memory: {error}", code="bad-value", parameter="memory") from None

    @property
    def settings(self) -> Settings:
        """Return the options that reading and writing a picture depend on."""
        return Settings(**{each.name: getattr(self, each.name) for each in fields(Settings)})

    def for_frames(self) -> RunOptions:
        """Return the options that a single frame depends on, without those that chose the frames and the graph."""
        return replace(self, input=None, output=None, frames=None, set=None, scheduler=None)


def takes_run_options(function: Function) -> Function:
    """Let ``help`` and ``inspect.signature`` show every option of a run where ``function`` says ``**options``."""
    own = inspect.signature(function)
    parameters = [each for each in own.parameters.values() if each.kind is not inspect.Parameter.VAR_KEYWORD]
    for option in fields(RunOptions):
        how = {"default": option.default, "annotation": option.type}
        parameters.append(inspect.Parameter(option.name, inspect.Parameter.KEYWORD_ONLY, **how))
    function.__signature__ = own.replace(parameters=parameters)  # type: ignore[attr-defined]
    return function
