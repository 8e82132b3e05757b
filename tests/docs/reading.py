"""Do what a page says, block by block, in a folder of its own."""

from __future__ import annotations

import json
import re
import subprocess
import tomllib
from pathlib import Path
from typing import NamedTuple

from tests.docs import interpreter
from tests.docs.blocks import Block

TIMEOUT = 600  # seconds for one block


class Wrong(Exception):
    """A block does not do what the page says."""


class Place(NamedTuple):
    """Where blocks run: the folder they run in, and their environment."""

    folder: Path
    environment: dict[str, str]


class Reading:
    """A page being read: shell blocks each have a shell of their own, Python blocks share one interpreter.

    ``here`` is where the package is installed, ``clone`` a copy of the checkout.
    """

    def __init__(self, here: Place, clone: Place) -> None:
        self._here = here
        self._clone = clone
        self._interpreters: dict[Path, subprocess.Popen[str]] = {}
        self._printed = ""  # by the block before

    def __enter__(self) -> Reading:
        return self

    def __exit__(self, *_: object) -> None:
        for process in self._interpreters.values():
            process.communicate()

    def do(self, block: Block) -> None:
        """Do what a reader does with a block; raise :class:`Wrong` where it does not work."""
        if "not run" in block.marks:
            self._printed = ""
            return
        place = self._clone if "in a clone" in block.marks else self._here
        if "saved as" in block.marks:
            file = place.folder / block.marks["saved as"]
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(block.text, encoding="utf-8")
        kind = {"bash": "sh"}.get(block.language, block.language)
        self._printed = getattr(self, f"_{kind}")(block, place)

    def _sh(self, block: Block, place: Place) -> str:
        return shell(block.text, place)

    def _python(self, block: Block, place: Place) -> str:
        """Run a block, or leave it to later ones to run the file that it is in."""
        compile(block.text, block.place, "exec", dont_inherit=True)
        if "added to" in block.marks:
            with open(place.folder / block.marks["added to"], "a", encoding="utf-8") as file:
                file.write("\n\n" + block.text)
        if {"saved as", "added to"} & block.marks.keys():
            return ""
        process = self._interpreter(place)
        assert process.stdin
        assert process.stdout
        process.stdin.write(json.dumps([block.place, block.text]) + "\n")
        process.stdin.flush()
        printed, failed = json.loads(process.stdout.readline())
        if failed:
            raise Wrong(printed)
        return str(printed)

    def _json(self, block: Block, place: Place) -> str:
        """Check a graph, or the graph that the block's nodes are added to."""
        target = block.marks.get("added to")
        if target:
            file = place.folder / target
            graph = json.loads(file.read_text(encoding="utf-8"))
            graph["nodes"] |= json.loads(f"{{{block.text}}}")
            file.write_text(json.dumps(graph, indent=2), encoding="utf-8")
            return shell(f"flowabs check ./{target}", place)
        graph = json.loads(block.text)
        if "format" not in graph:
            raise Wrong("is no whole graph: mark it 'added to NAME' or 'not run: REASON'")
        name = block.marks.get("saved as")
        if not name:
            name = "graph-of-the-page.json"
            (place.folder / name).write_text(block.text, encoding="utf-8")
        return shell(f"flowabs check ./{name}", place)

    def _toml(self, block: Block, place: Place) -> str:
        """Load what entry points name; the rest of TOML has only to be TOML."""
        points = tomllib.loads(block.text).get("project", {}).get("entry-points", {})
        names = [target for group in points.values() for target in group.values()]
        load = f"from importlib.metadata import EntryPoint; [EntryPoint('', name, '').load() for name in {names}]"
        return shell(f'python -c "{load}"', place)

    def _text(self, block: Block, _: Place) -> str:
        """Compare with what the block before printed: … stands for anything."""
        if not matches(block.text, self._printed):
            raise Wrong(f"expected what the block above prints:\n{self._printed or '(nothing)'}")
        return self._printed

    def _interpreter(self, place: Place) -> subprocess.Popen[str]:
        if place.folder not in self._interpreters:
            self._interpreters[place.folder] = subprocess.Popen(
                ["python", interpreter.__file__],
                cwd=place.folder,
                env=place.environment,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
            )
        return self._interpreters[place.folder]


def shell(script: str, place: Place) -> str:
    """Return what a script prints, on both streams; raise :class:`Wrong` where a command of it fails."""
    done = subprocess.run(
        ["bash", "-e", "-u", "-o", "pipefail", "-c", script],
        cwd=place.folder,
        env=place.environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=TIMEOUT,
    )
    if done.returncode:
        raise Wrong(f"exit code {done.returncode}\n{done.stdout}")
    return done.stdout


def matches(expected: str, printed: str) -> bool:
    """Return whether lines are as expected, spaces at their ends aside; … stands for anything, over lines too."""

    def tidy(text: str) -> str:
        return "\n".join(line.rstrip() for line in text.strip().splitlines())

    pattern = ".*?".join(re.escape(part) for part in tidy(expected).split("…"))
    return re.fullmatch(pattern, tidy(printed), re.DOTALL) is not None
