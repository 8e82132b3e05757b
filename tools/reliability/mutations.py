"""Damage good files in a thousand ways, and read each: ``python -m tools.reliability.mutations [FILE…] --times 1000``.

No reading may crash, hang, end in a traceback or take more than two gigabytes; nor may there be a picture of a file
that OpenEXR refuses or OpenImageIO cannot read whole. ``--as-they-are`` reads the files that are named, and damages
none.
"""

from __future__ import annotations

import argparse
import random
import sys
import tempfile
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
import OpenImageIO as oiio

from tools.reliability.reading import Reading, read_all

COMPRESSIONS = ("zip", "piz", "none", "dwaa")
#: About so many bytes of the files that are made here are header and offset tables.
_HEADER = 700


def good_files(folder: Path) -> list[Path]:
    """Write a small good EXR in each compression, one in tiles, and one of two parts; return them."""
    made = [_write(folder / f"{name}.exr", compression=name) for name in COMPRESSIONS]
    return [*made, _write(folder / "tiles.exr", tile=32), _write(folder / "parts.exr", parts=("beauty", "normal"))]


def _write(path: Path, *, compression: str = "zip", tile: int = 0, parts: tuple[str, ...] = ("",)) -> Path:
    """Write 96 x 80 pixels of four channels as half floats."""
    rows, columns = np.mgrid[:80, :96].astype(np.float32)
    noise = np.random.default_rng(1).random((80, 96, 4), np.float32)
    pixels = (np.sin((rows + columns) / 9)[..., None] + 1 + noise / 20).astype(np.float32)
    specs = []
    for name in parts:
        spec = oiio.ImageSpec(96, 80, 4, oiio.HALF)
        spec.attribute("compression", compression)
        if name:
            spec.attribute("name", name)
            spec.attribute("oiio:subimagename", name)
        spec.tile_width = spec.tile_height = tile
        specs.append(spec)
    output = oiio.ImageOutput.create(str(path))
    assert output is not None
    if not (output.open(str(path), tuple(specs)) if len(specs) > 1 else output.open(str(path), specs[0])):
        raise RuntimeError(output.geterror())
    for index, spec in enumerate(specs):
        if index and not output.open(str(path), spec, "AppendSubimage"):
            raise RuntimeError(output.geterror())
        output.write_image(pixels)
    output.close()
    return path


# ---------------------------------------------------------------------- ways of damaging


def _flip(data: bytearray, chance: random.Random, end: int) -> None:
    for _ in range(chance.choice([1, 1, 2, 8])):
        data[chance.randrange(end)] ^= 1 << chance.randrange(8)


def flip_bits(data: bytearray, chance: random.Random) -> None:
    """Flip one to eight bits anywhere."""
    _flip(data, chance, len(data))


def flip_header_bits(data: bytearray, chance: random.Random) -> None:
    """Flip one to eight bits of the header or the offset tables."""
    _flip(data, chance, min(_HEADER, len(data)))


def cut(data: bytearray, chance: random.Random) -> None:
    """Cut the end off."""
    del data[chance.randrange(len(data)) :]


def insert(data: bytearray, chance: random.Random) -> None:
    """Put bytes in between."""
    place = chance.randrange(len(data))
    data[place:place] = chance.randbytes(chance.choice([1, 4, 100]))


def leave_out(data: bytearray, chance: random.Random) -> None:
    """Take bytes out of the middle."""
    place = chance.randrange(len(data))
    del data[place : place + chance.choice([1, 4, 100])]


def zero(data: bytearray, chance: random.Random) -> None:
    """Set a run of bytes to zero, as a block that was never written reads."""
    place = chance.randrange(len(data))
    size = min(chance.choice([16, 512, 4096]), len(data) - place)
    data[place : place + size] = bytes(size)


def extreme_field(data: bytearray, chance: random.Random) -> None:
    """Set four bytes of the header or the offset tables to a number that no writer writes there."""
    place = chance.randrange(4, min(_HEADER, len(data) - 4))
    number = chance.choice([0, 1, -1, 2**31 - 1, -(2**31), 2**20, chance.randrange(2**31)])
    data[place : place + 4] = number.to_bytes(4, "little", signed=True)


WAYS: tuple[Callable[[bytearray, random.Random], None], ...] = (
    flip_bits,
    flip_header_bits,
    cut,
    insert,
    leave_out,
    zero,
    extreme_field,
)


def mutations(files: list[Path], folder: Path, times: int, seed: int) -> list[Path]:
    """Write ``times`` damaged copies, of each file and in each way in turn, and return them."""
    chance = random.Random(seed)
    made = []
    for index in range(times):
        source, way = files[index % len(files)], WAYS[index // len(files) % len(WAYS)]
        data = bytearray(source.read_bytes())
        way(data, chance)
        made.append(folder / f"{index:05}.{source.stem}.{way.__name__}{source.suffix}")
        made[-1].write_bytes(data)
    return made


def summary(readings: list[Reading]) -> str:
    """Return a sentence on all readings."""
    counts = Counter(reading.answer for reading in readings)
    longest = max(readings, key=lambda reading: reading.seconds)
    faults = sum(bool(reading.fault) for reading in readings)
    answers = ", ".join(f"{count} {answer}" for answer, count in counts.most_common())
    return f"{len(readings)} files: {answers}; {faults} faults; longest {longest.seconds:.2f} s"


def main() -> int:
    """Read many damaged files; return 1 if anything was wrong with one of them."""
    parser = argparse.ArgumentParser(prog="python -m tools.reliability.mutations", description=__doc__)
    parser.add_argument("files", nargs="*", type=Path, metavar="FILE", help="damaged too, besides those made here")
    parser.add_argument("--times", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--as-they-are", action="store_true", help="read the files that are named, damage none")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="copy the files with faults there")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        good = [] if given.as_they_are else [*good_files(Path(name)), *given.files]
        paths = given.files if given.as_they_are else mutations(good, Path(name), given.times, given.seed)
        readings = read_all(paths)
        for reading in filter(lambda each: each.fault, readings):
            print(f"{Path(reading.path).name}: {reading.fault}")
            if given.keep:
                given.keep.mkdir(parents=True, exist_ok=True)
                (given.keep / Path(reading.path).name).write_bytes(Path(reading.path).read_bytes())
    print(summary(readings))
    return int(any(reading.fault for reading in readings))


if __name__ == "__main__":
    sys.exit(main())
