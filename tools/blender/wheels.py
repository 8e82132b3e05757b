"""Gather the wheels that flowabs needs in a Blender: its own, built from the checkout, and those of what it runs on."""

from __future__ import annotations

import platform
import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from zipfile import ZipFile

from flowabs_nodes.errors import FlowabsError
from tools.blender.environments import CHECKOUT, Blender, call

PIP = (sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check")

LICENSES: Mapping[str, tuple[str, ...]] = {
    "click": ("BSD-3-Clause",),
    "colorama": ("BSD-3-Clause",),
    "fileseq": ("MIT",),
    "flowabs_nodes": ("Apache-2.0",),
    "llvmlite": ("BSD-2-Clause", "Apache-2.0 WITH LLVM-exception"),
    "numba": ("BSD-2-Clause",),
    "openexr": ("BSD-3-Clause",),
    "openimageio": ("Apache-2.0",),
    "tqdm": ("MPL-2.0", "MIT"),
}
"""What may be bundled, and under which licence: each goes together with Blender's GPL. Each wheel carries the text."""


@dataclass(frozen=True)
class Platform:
    """Names a platform as Blender's manifests do, and the tags of the wheels that run on it."""

    name: str
    tags: tuple[str, ...]
    also: tuple[str, ...] = ()  #: needed there, but left out by pip, which asks what *this* machine needs


PLATFORMS: Mapping[str, Platform] = {
    each.name: each
    for each in (
        Platform("linux-x64", tuple(f"manylinux_2_{minor}_x86_64" for minor in (28, 27, 17))),
        Platform("windows-x64", ("win_amd64",), also=("colorama",)),
        Platform("macos-arm64", ("macosx_12_0_arm64",)),
        Platform("macos-x64", ("macosx_12_0_x86_64",)),
    )
}


def here() -> Platform:
    """Return the platform of this machine; raises FlowabsError where it is none of those that zips are built for."""
    system = {"Linux": "linux", "Windows": "windows", "Darwin": "macos"}.get(platform.system(), platform.system())
    machine = {"AMD64": "x64", "x86_64": "x64", "aarch64": "arm64"}.get(platform.machine(), platform.machine())
    if f"{system}-{machine}" not in PLATFORMS:
        raise FlowabsError(f"no extension is built for {system}-{machine}: only for {', '.join(PLATFORMS)}")
    return PLATFORMS[f"{system}-{machine}"]


def build(folder: Path) -> Path:
    """Build the package's own wheel into a folder, and return its path."""
    call("cannot build flowabs", [*PIP, "wheel", "--no-deps", "--wheel-dir", str(folder), str(CHECKOUT)])
    return next(folder.glob("flowabs_nodes-*.whl"))


def gather(own: Path, blender: Blender, target: Platform, folder: Path) -> list[Path]:
    """Download into a folder what the package's wheel needs in a Blender on a platform; return all wheels, by name.

    NumPy is Blender's own: it takes part in choosing versions, and is not among the wheels. Raises FlowabsError where
    there are no such wheels, and where one is not known to be free to bundle or has no text of its licence.
    """
    command = [*PIP, "download", "--dest", str(folder), "--only-binary", ":all:", "--python-version", blender.python]
    for tag in target.tags:
        command += ["--platform", tag]
    numpy = f"numpy=={blender.numpy}.*"
    call(f"no wheels for {target.name}, Blender {blender.version}", [*command, numpy, *target.also, str(own)])
    wheels = sorted(each for each in folder.glob("*.whl") if distribution(each) != "numpy")
    for wheel in wheels:
        _check_license(wheel)
    return wheels


def distribution(wheel: Path) -> str:
    """Return the name of the package that a wheel holds: "numba" for ``numba-0.68.1-cp311-cp311-win_amd64.whl``."""
    return wheel.name.partition("-")[0].lower()


def licenses(bundled: Sequence[Path]) -> list[str]:
    """Return the licences of wheels, as Blender's manifests name them: what holds for all of an extension."""
    return sorted({f"SPDX:{name}" for wheel in bundled for name in LICENSES[distribution(wheel)]})


def _check_license(wheel: Path) -> None:
    if distribution(wheel) not in LICENSES:
        raise FlowabsError(
            f"{wheel.name} is not known to be free to bundle", hint="say its licence in tools/blender/wheels.py"
        )
    with ZipFile(wheel) as file:
        if not any(re.search(r"\.dist-info/(licenses/)?LICEN[CS]E[^/]*$", name) for name in file.namelist()):
            raise FlowabsError(f"{wheel.name} does not carry its licence")
