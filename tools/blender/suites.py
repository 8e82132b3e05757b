"""Says which tests of ``plugins/blender`` run where: with the checkout, with the extension installed, in a window."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from flowabs_nodes.errors import CommandError
from tools.blender import extension, wheels
from tools.blender.environments import BLENDERS, CHECKOUT, Blender, Environment, make
from tools.blender.interpreters import find

PLUGIN = CHECKOUT / "plugins" / "blender"


@dataclass(frozen=True)
class Workplace:
    """Has the folder of the environments, the interpreters that were named, and the Blenders that were chosen."""

    cache: Path
    blenders: Sequence[Blender] = tuple(BLENDERS.values())
    pythons: Mapping[str, Path] = field(default_factory=dict)

    def make(self, environment: Environment) -> Path:
        """Return the interpreter of an environment, made if need be."""
        return make(environment, self.pythons.get(environment.python) or find(environment.python), self.cache)


@dataclass(frozen=True)
class Run:
    """Names a folder of tests, the interpreter that runs them, and what they are told by environment variables."""

    title: str
    python: Path
    tests: str
    told: Mapping[str, str] = field(default_factory=dict)

    def start(self, arguments: Sequence[str], timeout: float) -> int:
        """Run pytest, and return its exit code; one that hangs is ended, which is a failure."""
        tests = str(PLUGIN / self.tests)
        command = [str(self.python), "-m", "pytest", "--rootdir", str(PLUGIN), tests, *(arguments or ["-q"])]
        environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"} | dict(self.told)
        try:
            return subprocess.run(command, cwd=CHECKOUT, env=environment, timeout=timeout, check=False).returncode
        except subprocess.TimeoutExpired:
            print(f"blender: no end after {timeout:g} seconds", file=sys.stderr)
            return 1


def with_checkout(place: Workplace) -> Iterable[Run]:
    """Return the tests of the checkout itself in each Blender's module."""
    return [Run(f"Blender {each.version}", place.make(each.with_flowabs), "tests") for each in place.blenders]


def installed(place: Workplace) -> Iterable[Run]:
    """Yield the tests of the extension's zip in each Blender's module, where flowabs is nowhere else."""
    here = wheels.here()
    targets = [each for each in extension.TARGETS if each.blender in place.blenders and each.platform == here]
    for target, made in extension.build(targets, place.cache / "extensions"):
        python = place.make(target.blender.clean)
        told = {"FLOWABS_EXTENSION": str(made)}
        yield Run(f"the extension in Blender {target.blender.version}", python, "tests_installed", told)


def in_window(place: Workplace) -> Iterable[Run]:
    """Yield the tests that need a window, in the Blender of this machine, on a display of their own."""
    blender, _ = _program("blender"), _program("xvfb-run")
    show = "import sys; print('PYTHON', '%d.%d' % sys.version_info[:2])"
    said = subprocess.run([blender, "-b", "--python-expr", show], capture_output=True, text=True, check=False).stdout
    version = next((line.split()[1] for line in said.splitlines() if line.startswith("PYTHON ")), "")
    own = Environment(f"window-{version}", version, ("--editable", str(CHECKOUT), "pytest>=8"))
    yield Run("a window", place.make(own), "tests_window", {"FLOWABS_BLENDER": blender})


SUITES: Mapping[str, Callable[[Workplace], Iterable[Run]]] = {
    "tests": with_checkout,
    "installed": installed,
    "window": in_window,
}


def _program(name: str) -> str:
    found = shutil.which(name)
    if found is None:
        raise CommandError(
            f"no program {name} is installed here",
            code="no-interpreter",
            hint="install Debian's packages blender and xvfb, or leave the window out: --suite tests,installed",
        )
    return found
