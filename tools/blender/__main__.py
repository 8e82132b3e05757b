"""Run the tests of ``plugins/blender`` in each Blender: ``python -m tools.blender CACHE``.

CACHE is the folder in which an environment for each Blender is made, and found again the next time.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from flowabs_nodes.errors import CommandError, FlowabsError, nearest
from tools.blender.environments import BLENDERS, CHECKOUT, Blender, make
from tools.blender.interpreters import find, is_version

TESTS = CHECKOUT / "plugins" / "blender" / "tests"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the tests; return the exit code: 1 where one fails, 2 where the command is wrong or a Blender is missing."""
    given, pytest_arguments = _parser().parse_known_args(arguments)
    failed = []
    try:
        pythons = dict(_named(text) for text in given.python)
        for blender in _chosen(given.blender):
            python = pythons.get(blender.python) or find(blender.python)
            own = make(blender, python, given.cache.resolve())
            print(f"+ Blender {blender.version}, Python {blender.python}", flush=True)
            if _run(own, pytest_arguments, given.timeout):
                failed.append(blender.version)
    except FlowabsError as error:
        print(f"blender: {error}", file=sys.stderr)
        return 2
    if failed:
        print(f"blender: tests failed in Blender {', '.join(failed)}", file=sys.stderr)
    return 1 if failed else 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m tools.blender",
        description="Test plugins/blender in each Blender, in an environment of its own.",
        epilog="Further arguments are for pytest.",
    )
    parser.add_argument("cache", type=Path, help="folder of the environments, 1.5 GB each; made if it is not there")
    parser.add_argument("--blender", default=",".join(BLENDERS), metavar="A,B", help="only these (%(default)s)")
    parser.add_argument("--python", action="append", default=[], metavar="3.13=PATH", help="the interpreter to use")
    parser.add_argument("--timeout", type=float, default=900.0, help="seconds for the tests of one Blender (900)")
    return parser


def _chosen(text: str) -> list[Blender]:
    names = [name.strip() for name in text.split(",") if name.strip()]
    for name in names:
        if name not in BLENDERS:
            raise CommandError(f"Blender {name} is not one of {', '.join(BLENDERS)}", hint=nearest(name, BLENDERS))
    return [BLENDERS[name] for name in names]


def _named(text: str) -> tuple[str, Path]:
    version, _, path = text.partition("=")
    if not path or not is_version(Path(path), version):
        raise CommandError(
            f"--python {text}: expected a version and an interpreter of it, such as 3.13=/usr/bin/python3"
        )
    return version, Path(path)


def _run(python: Path, arguments: list[str], timeout: float) -> int:
    """Run pytest in an environment, and return its exit code; one that hangs is ended, which is a failure."""
    command = [str(python), "-m", "pytest", "--rootdir", str(TESTS.parent), str(TESTS), *(arguments or ["-q"])]
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    try:
        return subprocess.run(command, cwd=CHECKOUT, env=environment, timeout=timeout, check=False).returncode
    except subprocess.TimeoutExpired:
        print(f"blender: no end after {timeout:g} seconds", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
