"""Find the files of a sequence, ``shot.####.exr`` (fileseq's tokens, Nuke's widths), and parse frame ranges.

Ranges are Nuke's: ``1-100x2,200``.
"""

from __future__ import annotations

import os
import re
from bisect import bisect
from dataclasses import dataclass
from functools import cached_property

from flowabs_nodes.errors import CommandError, ReadError
from flowabs_nodes.io.settings import refuse_shell_words

#: The most frames one range may come to.
MAX_FRAMES = 1_000_000

#: The most digits that a frame number may be padded to.
MAX_WIDTH = 20

_RANGE = re.compile(r"(-?\d{1,18})(?:-(-?\d{1,18})(?:x(\d{1,18}))?)?")
#: A frame's number in the name of one picture: digits between dots, before the extension.
_NUMBER_IN_NAME = re.compile(r"\.(-?\d{1,9})\.[^.]+$")
#: One # or @ before a digit is none: "icon@2x.png" and "take#2.exr" are names, and 1 before 2 would read as 12.
_TOKEN = re.compile(r"#{2,}|#(?!\d)|@{2,}|@(?!\d)|%\d*d(?![A-Za-z])|\$F\d*+(?![A-Za-z])")


def parse_frames(text: str) -> tuple[int, ...]:
    """Return the frames of a range such as ``1001-1100x2,200`` or ``-5-5``, each once, in the order given.

    Raises CommandError where the text is no range, or comes to more than a million frames.
    """
    frames: dict[int, None] = {}
    for part in text.split(","):
        match = _RANGE.fullmatch(part.strip())
        if not match or match[3] == "0":
            hint = _stepped_with_x(part.strip())
            raise CommandError(
                f"{part.strip()!r} is not a frame range such as 1001-1100x2,200", code="bad-frames", hint=hint
            )
        first, last = int(match[1]), int(match[2] if match[2] is not None else match[1])
        step = int(match[3] or 1)
        numbers = range(first, last + 1, step) if last >= first else range(first, last - 1, -step)
        if len(frames) + len(numbers) > MAX_FRAMES:
            raise CommandError(f"{text!r} is more than {MAX_FRAMES:,} frames", code="bad-frames")
        frames.update(dict.fromkeys(numbers))
    return tuple(frames)


def _stepped_with_x(part: str) -> str:
    """Return the hint for a range with a ``:``, which is a step to Open Job Description and a stagger to fileseq."""
    if ":" not in part:
        return ""
    corrected = part.replace(":", "x")
    match = _RANGE.fullmatch(corrected)
    example = corrected if match and match[3] != "0" else "1-10x4"
    return f"a step is written with x: {example}; a stagger (:) is not for rendering"


@dataclass(frozen=True)
class Source:
    """The file that a frame's pixels come from, once it is known what to do about a missing one.

    ``path`` is the file to read: of another frame for "hold" and "nearest"; for ``black`` the nearest frame's, whose
    windows and metadata the black frame takes; None where the frame is to be left out (``skip``).
    """

    path: str | None
    frame: int
    black: bool = False
    skip: bool = False


@dataclass(frozen=True)
class Sequence:
    """A file name, with or without one frame token (``####``, ``%04d``, ``$F4``, ``@@@``) in its last part.

    Widths are strict, as in Nuke: ``####`` is 0001 and 12345, never 1. A negative frame is read from either of its
    names, -001 as printf writes it, and -0001 as Blender does; it is written as the first. Folders are taken literally.

    ``literal`` takes the whole name literally, as that of a single picture. Raises CommandError for a name with two
    tokens or with a range in it, and for one that only a shell would understand.
    """

    pattern: str
    literal: bool = False

    def __post_init__(self) -> None:
        refuse_shell_words(self.pattern)
        _ = self._parts

    @classmethod
    def to_read(cls, pattern: str) -> Sequence:
        """Return the sequence to read; a single picture where a file has this very name."""
        return cls(pattern, literal=os.path.exists(pattern))

    @property
    def has_token(self) -> bool:
        """True for a sequence, False for a single picture."""
        return self._parts is not None

    @property
    def number_in_name(self) -> int | None:
        """Return the number that stands between dots before a single picture's extension, as in ``move.0004.exr``."""
        match = None if self.has_token else _NUMBER_IN_NAME.search(os.path.basename(self.pattern))
        return int(match[1]) if match else None

    @cached_property
    def _parts(self) -> tuple[str, int, str] | None:
        """Return the text before the number, the number's width, and the text after it; None for a single picture."""
        folder, name = os.path.split(self.pattern)
        tokens = list(_TOKEN.finditer(name))
        if not tokens or self.literal:
            return None
        if len(tokens) > 1:
            found = " and ".join(token[0] for token in tokens)
            raise CommandError(f"a name has one frame token, found {found}", code="bad-sequence", file=self.pattern)
        width = int(digits[0]) if (digits := re.search(r"\d{1,9}", tokens[0][0])) else len(tokens[0][0])
        if width > MAX_WIDTH:
            text = f"a frame number is padded to at most {MAX_WIDTH} digits, found {width}"
            raise CommandError(text, code="bad-sequence", file=self.pattern[:200])
        import fileseq  # a parser that single pictures need not wait for

        token = tokens[0]
        before, after = (re.sub("[#@]", "_", text) for text in (name[: token.start()], name[token.end() :]))
        try:
            numbered = fileseq.FileSequence(before + token[0] + after, pad_style=fileseq.PAD_STYLE_HASH1)
        except fileseq.FileSeqException as error:
            raise CommandError(f"not a sequence: {error}", code="bad-sequence", file=self.pattern) from None
        if numbered.frameSet():
            found = numbered.frameRange()
            raise CommandError(f"a range, {found}, does not belong in the name", code="bad-sequence", file=self.pattern)
        return os.path.join(folder, name[: token.start()]), numbered.zfill(), name[token.end() :]

    def path(self, frame: int) -> str:
        """Return the file of a frame; a single picture is the file of every frame."""
        if self._parts is None:
            return self.pattern
        before, width, after = self._parts
        return f"{before}{frame:0{width}d}{after}"

    def paths(self, frame: int) -> tuple[str, ...]:
        """Return every name that a frame's file may have, the one of :meth:`path` first."""
        if self._parts is None or frame >= 0:
            return (self.path(frame),)
        before, width, after = self._parts
        return tuple(dict.fromkeys((self.path(frame), f"{before}-{-frame:0{width}d}{after}")))

    def on_disk(self, frame: int) -> str | None:
        """Return the file of a frame that is there; None where none is."""
        return next((path for path in self.paths(frame) if os.path.exists(path)), None)

    def frame_of(self, name: str) -> int | None:
        """Return the frame of a file name without folder; None for a file that is not of this sequence."""
        if self._parts is None:
            return 1 if name == os.path.basename(self.pattern) else None
        frame = self._number_in(name)
        if frame is None:
            return None
        return frame if name in map(os.path.basename, self.paths(frame)) else None

    def _number_in(self, name: str) -> int | None:
        """Return the number that stands in a file name where this sequence has its token, of any width; else None."""
        assert self._parts is not None
        before, _, after = self._parts
        match = re.fullmatch(re.escape(os.path.basename(before)) + r"(-?\d{1,18})" + re.escape(after), name)
        return int(match[1]) if match else None

    def passed_over(self) -> tuple[str, ...]:
        """Return the files beside the sequence's own that have a number of another width, in order; without folder.

        A second file of one negative frame is among them. A folder that cannot be listed has none.
        """
        if self._parts is None:
            return ()
        try:
            names = os.listdir(os.path.dirname(self.pattern) or ".")
        except OSError:
            return ()
        numbers = {name: number for name in names if (number := self._number_in(name)) is not None}
        read = {os.path.basename(self.on_disk(number) or "") for number in numbers.values()}
        return tuple(sorted(name for name in numbers if name not in read))

    def frames_on_disk(self) -> tuple[int, ...]:
        """Return the frames that are on disk, in order; a single picture is frame 1. Raises ReadError."""
        folder = os.path.dirname(self.pattern) or "."
        if not self.has_token:
            return (1,) if os.path.exists(self.pattern) else ()
        try:
            found = {self.frame_of(name) for name in os.listdir(folder)}
        except FileNotFoundError:
            return ()
        except OSError as error:
            raise ReadError(f"the folder cannot be listed: {error.strerror}", file=self.pattern) from error
        return tuple(sorted(frame for frame in found if frame is not None))

    def resolve(self, frame: int, missing: str = "error", on_disk: tuple[int, ...] | None = None) -> Source:
        """Return the file to read for ``frame``; ``missing`` is one of :data:`MISSING`.

        ``on_disk`` is what :meth:`frames_on_disk` returned, where the folder need not be listed again. Raises
        ReadError where the file is missing and the policy finds no other.
        """
        path = self.path(frame)
        found = self.on_disk(frame)
        if found is not None:
            return Source(found, frame)
        if missing == "skip":
            return Source(None, frame, skip=True)
        there: tuple[int, ...] = ()
        if missing != "error" and self.has_token:
            listed = self.frames_on_disk() if on_disk is None else on_disk
            after = bisect(listed, frame)
            there = listed[max(0, after - 1) : after + (missing != "hold")]
        if not there:
            _check_access(path, frame)
            message, hint = "no such file", ""
            if missing == "hold" and self.has_token:
                message, hint = "no such file, and no earlier frame to hold", 'missing: "nearest" takes a later one too'
            elif self.has_token and missing != "error":
                message = "no such file, nor any other frame of the sequence"
            elif not os.path.isdir(os.path.dirname(path) or "."):
                message = "no such file: its folder does not exist"
            raise ReadError(message, code="missing-file", file=path, frame=frame, hint=hint)
        nearest = min(there, key=lambda other: (abs(other - frame), other))
        return Source(self.on_disk(nearest) or self.path(nearest), frame, black=missing == "black")


def _check_access(path: str, frame: int) -> None:
    """Raise ReadError where a file may be there, but the system does not let us look."""
    try:
        os.stat(path)
    except PermissionError as error:
        raise ReadError(f"cannot be read: {error.strerror}", file=path, frame=frame) from error
    except (OSError, ValueError):
        pass
