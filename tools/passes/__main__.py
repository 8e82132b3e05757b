"""Measure and show what is drawn from render passes: ``python -m tools.passes COMMAND ...``; ``-h`` says how."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from flowabs_nodes.engine.frame_numbers import frame_numbers
from flowabs_nodes.errors import CommandError, FlowabsError
from flowabs_nodes.image import Image
from flowabs_nodes.io.read import read_image
from flowabs_nodes.io.read_motion import read_motion
from flowabs_nodes.io.read_passes import read_depth
from flowabs_nodes.io.sequences import Sequence
from tools.gallery.sheet import Bytes, display
from tools.passes import edges, showing, steadiness

Plane = steadiness.Plane


def main(arguments: list[str] | None = None) -> int:
    """Do what a command says; return the exit code, 2 where the command is wrong."""
    given = _parser().parse_args(arguments)
    try:
        given.work(given)
    except FlowabsError as error:
        print(f"passes: {error}", file=sys.stderr)
        return 2 if isinstance(error, CommandError) else 1
    return 0


# ---------------------------------------------------------------------- what is measured


def _edges(given: argparse.Namespace) -> None:
    """Print how lines meet true edges, a row a frame, and the mean."""
    rows = {}
    for frame, lines in _frames(given.lines, given.frames, _plane(False)):
        truth = edges.Truth.load(Path(Sequence.to_read(str(given.truth)).path(frame)))
        rows[str(frame)] = truth.compare(1 - lines)
    print(edges.table(rows | {"mean": edges.mean(list(rows.values()))}))


def _boil(given: argparse.Namespace) -> None:
    """Print the boil of each frame that was drawn from two draws of noise, and the mean."""
    others = dict(_frames(given.other, given.frames, _plane(given.codes)))
    values = []
    for frame, one in _frames(given.one, given.frames, _plane(given.codes)):
        difference = float(np.abs(one - others[frame]).mean())
        values.append(difference if given.codes else steadiness.boil(one, others[frame]))
        print(f"{frame:6} {values[-1]:.4f}")
    print(f"{'mean':>6} {np.mean(values):.4f} {'codes' if given.codes else 'of the ink'}")


def _change(given: argparse.Namespace) -> None:
    """Print the change along the motion, and with ``--alone`` the ghost; write sheets of the differences."""
    alone = dict(_frames(given.alone, given.frames, _plane(given.codes))) if given.alone else {}
    plates = dict(_frames(given.render, given.frames, _plane(True)))
    motions = dict(_frames(given.render, given.frames, lambda file: read_motion(file).pixels))
    depths = dict(_frames(given.render, given.frames, lambda file: read_depth(file).pixels[..., 0]))
    numbers: list[tuple[float, float]] = []
    shown: dict[int, Bytes] = {}
    before: tuple[int, Plane] | None = None
    for frame, here in _frames(given.pictures, given.frames, _plane(given.codes)):
        if before and before[0] == frame - 1:
            step = steadiness.Step.between(*((each[frame - 1], each[frame]) for each in (motions, depths, plates)))
            change, ghost = step.change(before[1], here), step.ghost(here, alone[frame]) if alone else np.nan
            if not given.codes:  # of the ink that is there
                change /= max(steadiness.mean_over(here, step.still), 1e-9)
                ghost /= max(steadiness.mean_over(alone[frame], step.changed), 1e-9) if alone else 1
            numbers.append((change, ghost))
            print(f"{frame:6} {change:.4f}" + (f" ghost {ghost:.4f}" if alone else ""))
            difference = step.difference(before[1], here) * (4 if given.codes else 255)
            shown[frame] = np.rint(255 - difference.clip(0, 255))[..., None].repeat(3, axis=2).astype(np.uint8)
        before = frame, here
    if not numbers:
        raise CommandError("change needs two frames in a row at least", code="no-frames")
    change, ghost = np.mean(numbers, axis=0)
    unit = "codes" if given.codes else "of the ink"
    print(f"{'mean':>6} {change:.4f}" + (f" ghost {ghost:.4f}" if alone else "") + f" {unit}")
    if given.sheet:
        print(showing.contact_sheet(shown, given.sheet, 6, 200, 600_000))


# ---------------------------------------------------------------------- what is shown


def _sheet(given: argparse.Namespace) -> None:
    frames = dict(_frames(given.pictures, given.frames, _shown))
    file = showing.contact_sheet(frames, given.out, given.columns, given.width, given.limit * 1000)
    print(f"{file}  {file.stat().st_size / 1000:.0f} kB")


def _animate(given: argparse.Namespace) -> None:
    frames = [pixels for _, pixels in _frames(given.pictures, given.frames, _shown)]
    file = showing.animation(frames, given.out, given.rate, given.width, given.colors)
    print(f"{file}  {file.stat().st_size / 1000:.0f} kB")


# ---------------------------------------------------------------------- frames on disk


def _frames(pattern: str, frames: str | None, read: Callable[[str], Any]) -> Iterator[tuple[int, Any]]:
    """Yield the number and the picture of each frame asked for; of each on disk without ``frames``."""
    sequence = Sequence.to_read(pattern)
    numbers = frame_numbers(frames) if frames else sequence.frames_on_disk()
    if not numbers:
        raise CommandError("there are no frames of this sequence", code="no-frames", file=pattern)
    for number in numbers:
        yield number, read(sequence.path(number))


def _plane(codes: bool) -> Callable[[str], Plane]:
    """Return how a file is read: as ink, 1 - its first channel, or as code values of its lightness."""

    def read(file: str) -> Plane:
        image = read_image(file)
        return image.encoded_mono("lab") if codes else 1 - np.asarray(image.pixels[..., 0], np.float64)

    return read


def _shown(file: str) -> Bytes:
    image: Image = read_image(file)
    return display(image)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m tools.passes", description=__doc__)
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    def command(work: Callable[[argparse.Namespace], None], name: str, help: str) -> argparse.ArgumentParser:
        found = commands.add_parser(name, help=help, description=help)
        found.set_defaults(work=work)
        found.add_argument("--frames", metavar="RANGE", help="such as 1-24; without it all on disk")
        return found

    codes: dict[str, Any] = {
        "action": "store_true",
        "help": "they are colours: compare code values of the lightness, not ink",
    }
    one = command(_edges, "edges", "Hold lines to the true edges of a scene.")
    one.add_argument("truth", type=Path, help="edges.####.npz")
    one.add_argument("lines", help="lines.####.exr: 1 is paper")
    one = command(_boil, "boil", "Compare frames that were drawn from two draws of noise.")
    one.add_argument("one", help="lines.####.exr, or colours")
    one.add_argument("other", help="the same of the other draw")
    one.add_argument("--codes", **codes)
    one = command(_change, "change", "Measure the change from frame to frame along the motion.")
    one.add_argument("pictures", help="lines.####.exr, or colours")
    one.add_argument("render", help="render.####.exr without noise, with depth and motion")
    one.add_argument("--alone", metavar="FILES", help="the same without other frames: measures how far pictures lag")
    one.add_argument("--sheet", type=Path, metavar="FILE", help="a contact sheet of the differences")
    one.add_argument("--codes", **codes)
    one = command(_sheet, "sheet", "Write a contact sheet.")
    one.add_argument("pictures", help="toon.####.exr")
    one.add_argument("out", type=Path, help="a PNG, or a JPEG where that would be large")
    one.add_argument("--columns", type=int, default=6, help="frames in a row (%(default)s)")
    one.add_argument("--width", type=int, default=200, help="of a frame in pixels (%(default)s)")
    one.add_argument("--limit", type=int, default=240, help="of the file in kB (%(default)s)")
    one = command(_animate, "animate", "Write a GIF that plays.")
    one.add_argument("pictures", help="toon.####.exr")
    one.add_argument("out", type=Path, help="a GIF")
    one.add_argument("--width", type=int, default=320, help="in pixels (%(default)s)")
    one.add_argument("--rate", type=int, default=12, help="frames a second (%(default)s)")
    one.add_argument("--colors", type=int, default=32, help="of all frames together (%(default)s)")
    return parser


if __name__ == "__main__":
    sys.exit(main())
