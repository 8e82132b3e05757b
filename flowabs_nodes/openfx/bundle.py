"""Build the OpenFX plug-in as a bundle that hosts find: the compiled library, and what it has to know beside it.

::

    Flowabs.ofx.bundle/Contents/Linux-x86-64/Flowabs.ofx   the library
                                Resources/effects.json     the effects (effects.py)
                                Resources/server.txt       the Python that filters
"""

from __future__ import annotations

import json
import os
import platform
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import flowabs_nodes
from flowabs_nodes.engine.child_python import can_start
from flowabs_nodes.errors import CommandError, WriteError
from flowabs_nodes.openfx.effects import effects_document

NAME = "Flowabs"

#: The folder of the library for each system, as OpenFX names them, and what the compiler needs to make one.
ARCHITECTURES = {
    "linux": ("Linux-x86-64", ("-fPIC", "-shared", "-pthread", "-ldl", "-lm")),
    "darwin": ("MacOS", ("-fPIC", "-bundle")),
    "win32": ("Win64", ("-shared", "-static-libgcc", "-D__USE_MINGW_ANSI_STDIO=1")),
}

#: Variables that a host may have set for its own Python, and that the plug-in takes away.
HOST_VARIABLES = ("PYTHONHOME", "PYTHONPATH", "LD_LIBRARY_PATH", "LD_PRELOAD")


def default_folder() -> Path:
    """Return the folder that bundles are built into unless another is said: ``OFX/Plugins`` in the user's home."""
    return Path.home() / "OFX" / "Plugins"


def source_folder() -> Path:
    """Return the folder of the plug-in's C source: inside an installed package, or beside it in a checkout."""
    package = Path(flowabs_nodes.__file__).resolve().parent
    installed = package / "openfx" / "source"
    return installed if installed.is_dir() else package.parent / "plugins" / "openfx"


def build(folder: Path, graphs: Iterable[Path] | None = None, flags: Iterable[str] = ()) -> tuple[Path, list[str]]:
    """Compile the plug-in, and write its bundle into a folder; what was there of it is replaced.

    Parameters
    ----------
    folder
        Where hosts look, one of ``$OFX_PLUGIN_PATH``.
    graphs
        Folders of graphs of the user's own; None: those of ``$FLOWABS_GRAPHS``.
    flags
        More words for the compiler.

    Returns
    -------
    tuple
        The bundle, and a sentence for each graph that can be no effect.

    Raises
    ------
    CommandError
        There is no C compiler, it fails, or this program has no Python of its own to start.
    WriteError
        The bundle cannot be written.
    """
    bundle = folder.expanduser().absolute() / f"{NAME}.ofx.bundle"
    architecture, needed = _architecture()
    try:
        library = bundle / "Contents" / architecture / f"{NAME}.ofx"
        library.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=library.parent, prefix=".build") as scratch:
            made = Path(scratch) / library.name
            _compile(made, (*needed, *flags))
            os.replace(made, library)  # a host may hold the old one open
        if sys.platform == "darwin":
            _write(bundle / "Contents" / "Info.plist", _INFO.format(version=flowabs_nodes.__version__))
        _write(bundle / "Contents" / "Resources" / "server.txt", _server())
        return bundle, _write_effects(bundle, graphs)
    except OSError as error:
        raise WriteError(f"{bundle}: cannot be written: {error}") from error


def refresh(folder: Path, graphs: Iterable[Path] | None = None) -> tuple[Path, list[str]]:
    """Describe the graphs anew in a bundle that is there; return as :func:`build` does.

    The library is touched: hosts remember what a library held until its time changes.

    Raises CommandError where there is no bundle, WriteError where it cannot be written.
    """
    bundle = folder.expanduser().absolute() / f"{NAME}.ofx.bundle"
    libraries = list(bundle.glob(f"Contents/*/{NAME}.ofx"))
    if not libraries:
        raise CommandError(f"{bundle}: no bundle is there", hint="flowabs openfx build makes it", code="no-bundle")
    try:
        problems = _write_effects(bundle, graphs)
        for library in libraries:
            os.utime(library)
    except OSError as error:
        raise WriteError(f"{bundle}: cannot be written: {error}") from error
    return bundle, problems


def _architecture() -> tuple[str, tuple[str, ...]]:
    """Return the folder of the library on this system, and the words that its compiler needs."""
    folder, words = ARCHITECTURES.get(sys.platform, ARCHITECTURES["linux"])
    machine = platform.machine().lower()
    if folder.startswith("Linux") and machine not in ("x86_64", "amd64"):
        folder = f"Linux-{machine}"
    return folder, words


def _compile(made: Path, words: Iterable[str]) -> None:
    """Compile the C source into a library."""
    compiler = shlex.split(os.environ.get("CC", "")) or ["cc" if shutil.which("cc") else "gcc"]
    if shutil.which(compiler[0]) is None:
        raise CommandError(
            f"no C compiler: {compiler[0]} is not found",
            hint="install one (apt install gcc, xcode-select --install, MinGW-w64), or name it in CC",
            code="no-compiler",
        )
    source = [str(path) for path in sorted(source_folder().glob("*.c"))]
    command = [*compiler, "-std=c99", "-O2", "-fvisibility=hidden", *source, "-o", str(made), *words]
    done = subprocess.run(command, capture_output=True, text=True, errors="replace", check=False)
    if done.returncode:
        told = "\n".join(done.stderr.strip().splitlines()[:20])
        raise CommandError(f"the C compiler {compiler[0]} fails:\n{told}", code="compiler-failed")


def _server() -> str:
    """Return ``server.txt``: the Python of this process; on a second line where the package is, if it is not found."""
    if not can_start():
        raise CommandError("this program has no Python of its own that the plug-in could start", code="no-python")
    place = Path(flowabs_nodes.__file__).resolve().parents[1]
    clean = {name: value for name, value in os.environ.items() if name not in HOST_VARIABLES}
    asked = [sys.executable, "-P", "-c", "import flowabs_nodes; print(flowabs_nodes.__file__)"]
    found = subprocess.run(asked, env=clean, capture_output=True, text=True, check=False).stdout.strip()
    there = bool(found) and Path(found).resolve().parents[1] == place
    return f"{sys.executable}\n" if there else f"{sys.executable}\n{place}\n"


def _write_effects(bundle: Path, graphs: Iterable[Path] | None) -> list[str]:
    """Write ``effects.json``; return a sentence for each graph that can be no effect."""
    document, problems = effects_document(graphs)
    _write(bundle / "Contents" / "Resources" / "effects.json", json.dumps(document, indent=1, ensure_ascii=False))
    return problems


def _write(path: Path, text: str) -> None:
    """Write a file whole: a host may read it at any time."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile("w", encoding="utf-8", dir=path.parent, delete=False) as file:
        scratch: Any = Path(file.name)
        file.write(text)
    os.chmod(scratch, 0o644)
    os.replace(scratch, path)


_INFO = """<?xml version="1.0" encoding="UTF-8"?>
<!DOCTYPE plist PUBLIC "-//Apple//DTD PLIST 1.0//EN" "http://www.apple.com/DTDs/PropertyList-1.0.dtd">
<plist version="1.0">
<dict>
  <key>CFBundleExecutable</key><string>Flowabs.ofx</string>
  <key>CFBundleIdentifier</key><string>org.flowabs.openfx</string>
  <key>CFBundleName</key><string>Flowabs</string>
  <key>CFBundlePackageType</key><string>BNDL</string>
  <key>CFBundleVersion</key><string>{version}</string>
</dict>
</plist>
"""
