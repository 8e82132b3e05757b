"""Run the tests of ``plugins/blender`` in each Blender: ``python -m tools.blender CACHE``.

CACHE is the folder in which an environment for each Blender is made, and found again the next time.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

from flowabs_nodes.errors import CommandError, FlowabsError, nearest
from tools.blender.environments import BLENDERS
from tools.blender.interpreters import is_version
from tools.blender.suites import SUITES, Workplace


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the tests; return the exit code: 1 where one fails, 2 where the command is wrong or a Blender is missing."""
    given, pytest_arguments = _parser().parse_known_args(arguments)
    failed = []
    try:
        blenders = [BLENDERS[version] for version in _chosen("Blender", given.blender, BLENDERS)]
        place = Workplace(given.cache.resolve(), blenders, dict(_named(text) for text in given.python))
        for suite in _chosen("suite", given.suite, SUITES):
            for run in SUITES[suite](place):
                print(f"+ {run.title}", flush=True)
                if run.start(pytest_arguments, given.timeout):
                    failed.append(run.title)
    except FlowabsError as error:
        print(f"blender: {error}", file=sys.stderr)
        return 2
    if failed:
        print(f"blender: tests failed in {', '.join(failed)}", file=sys.stderr)
    return 1 if failed else 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m tools.blender",
        description="Test plugins/blender in each Blender, in environments of its own: the checkout (tests), the "
        "extension as artists install it (installed), and what needs a window (window).",
        epilog="Further arguments are for pytest.",
    )
    parser.add_argument("cache", type=Path, help="folder of the environments, 6 GB in all; made if it is not there")
    parser.add_argument("--suite", default=",".join(SUITES), metavar="A,B", help="only these (%(default)s)")
    parser.add_argument("--blender", default=",".join(BLENDERS), metavar="A,B", help="only these (%(default)s)")
    parser.add_argument("--python", action="append", default=[], metavar="3.13=PATH", help="the interpreter to use")
    parser.add_argument("--timeout", type=float, default=900.0, help="seconds for the tests of one Blender (900)")
    return parser


def _chosen(kind: str, text: str, known: Iterable[str]) -> list[str]:
    names = [name.strip() for name in text.split(",") if name.strip()]
    for name in names:
        if name not in known:
            raise CommandError(f"{kind} {name} is not one of {', '.join(known)}", hint=nearest(name, known))
    return names


def _named(text: str) -> tuple[str, Path]:
    version, _, path = text.partition("=")
    if not path or not is_version(Path(path), version):
        raise CommandError(
            f"--python {text}: expected a version and an interpreter of it, such as 3.13=/usr/bin/python3"
        )
    return version, Path(path)


if __name__ == "__main__":
    sys.exit(main())
