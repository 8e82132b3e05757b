"""Build the Blender extension with all it needs: ``python -m tools.blender.extension OUT``.

Writes a zip for each Python that Blenders have, and each platform, for Blender's *Install from Disk*. One zip for all
of them would have ten times the size of what an artist needs.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from zipfile import ZIP_DEFLATED, ZIP_STORED, ZipFile, ZipInfo

from flowabs_nodes.errors import FlowabsError
from tools.blender import wheels
from tools.blender.environments import BLENDERS, CHECKOUT, Blender, call, make
from tools.blender.interpreters import find
from tools.blender.wheels import PLATFORMS, Platform

PLUGIN = CHECKOUT / "plugins" / "blender"
SOURCE = PLUGIN / "flowabs_blender"
MANIFEST = "blender_manifest.toml"
LIMIT = 85_000_000  # bytes of a zip


@dataclass(frozen=True)
class Target:
    """Names whom a zip is for: the Blenders of one Python, from one version to before another, on one platform."""

    blender: Blender
    platform: Platform
    versions: Mapping[str, str]


TARGETS = [
    *(
        Target(BLENDERS["4.5"], platform, {"blender_version_min": "4.5.0", "blender_version_max": "5.1.0"})
        for platform in PLATFORMS.values()
    ),
    *(
        Target(BLENDERS["5.2"], platform, {"blender_version_min": "5.1.0"})
        for platform in PLATFORMS.values()
        if platform.name != "macos-x64"  # Blender 5 does not run there
    ),
]


def main(arguments: Sequence[str] | None = None) -> int:
    """Build the zips; return the exit code: 2 where one cannot be built."""
    given = _parser().parse_args(arguments)
    targets = [
        target
        for target in TARGETS
        if given.blender in (None, target.blender.version) and given.platform in (None, target.platform.name)
    ]
    try:
        if not targets:
            raise FlowabsError(f"Blender {given.blender} does not run on {given.platform}")
        for target, made in build(targets, given.out):
            if given.cache is not None:
                validate(made, make(target.blender.clean, find(target.blender.python), given.cache.resolve()))
            print(f"{made}  {made.stat().st_size / 1e6:.1f} MB", flush=True)
    except FlowabsError as error:
        print(f"extension: {error}", file=sys.stderr)
        return 2
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m tools.blender.extension",
        description="Build the Blender extension, with all that it needs, for each Blender and platform.",
    )
    parser.add_argument("out", type=Path, help="folder of the zips; made if it is not there")
    parser.add_argument("--blender", choices=BLENDERS, help="for this one only")
    parser.add_argument("--platform", choices=PLATFORMS, help="for this one only")
    parser.add_argument(
        "--cache", type=Path, help="have Blender's own check read each zip: folder of python -m tools.blender"
    )
    return parser


def build(targets: Sequence[Target], out: Path) -> Iterator[tuple[Target, Path]]:
    """Write a zip for each target into a folder, made if need be; yield each, once it is there."""
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        own = wheels.build(folder)
        for number, target in enumerate(targets):
            needed = wheels.gather(own, target.blender, target.platform, folder / str(number))
            yield target, _write(target, needed, out)


def validate(made: Path, python: Path) -> None:
    """Have Blender's own check read a zip; raise FlowabsError with what it says."""
    call(f"Blender does not take {made.name}", [str(python), str(PLUGIN / "validate.py"), str(made)])


def manifest(target: Target, bundled: Sequence[Path]) -> str:
    """Return the text of the manifest for a target with its wheels."""
    added: dict[str, Any] = {
        **target.versions,
        "license": wheels.licenses(bundled),
        "platforms": [target.platform.name],
        "wheels": [f"./wheels/{wheel.name}" for wheel in bundled],
    }
    top, bracket, tables = (SOURCE / MANIFEST).read_text(encoding="utf-8").partition("\n[")
    kept = [line for line in top.splitlines() if line.partition(" = ")[0] not in added]
    lines = [*kept, *(f"{key} = {json.dumps(value)}" for key, value in added.items())]
    return "\n".join(lines) + "\n" + bracket + tables


def _write(target: Target, needed: Sequence[Path], out: Path) -> Path:
    """Write the zip of a target; nothing is left where it is too large."""
    said = manifest(target, needed)
    version = tomllib.loads(said)["version"]
    made = out / f"flowabs_blender-{version}-blender-{target.blender.version}-{target.platform.name}.zip"
    with ZipFile(made, "w") as file:
        _add(file, MANIFEST, said.encode())
        for source in sorted(SOURCE.rglob("*.py")):
            _add(file, source.relative_to(SOURCE).as_posix(), source.read_bytes())
        for name in ("LICENSE", "NOTICE"):
            _add(file, name, (CHECKOUT / name).read_bytes())
        for wheel in needed:
            _add(file, f"wheels/{wheel.name}", wheel.read_bytes())
    size = made.stat().st_size
    if size > LIMIT:
        made.unlink()
        largest = sorted(needed, key=lambda wheel: wheel.stat().st_size, reverse=True)
        each = ", ".join(f"{wheel.name} {wheel.stat().st_size / 1e6:.1f}" for wheel in largest)
        raise FlowabsError(f"{made.name} would have {size / 1e6:.1f} MB, at most {LIMIT / 1e6:g} are meant: {each}")
    return made


def _add(file: ZipFile, name: str, data: bytes) -> None:
    """Add a file without its date, so that the same sources make the same zip; wheels are packed already."""
    file.writestr(ZipInfo(name), data, ZIP_STORED if name.endswith(".whl") else ZIP_DEFLATED)


if __name__ == "__main__":
    sys.exit(main())
