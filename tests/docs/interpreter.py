"""Run the Python blocks of a page one after the other in one namespace, as somebody would who types them in.

Run as a script, by the Python that is to find the package. Each line on standard input is JSON, ``[place, code]``, and
each is answered by a line of JSON, ``[what was printed, whether it failed]``.
"""

from __future__ import annotations

import contextlib
import io
import json
import linecache
import sys
from code import InteractiveInterpreter


class Reader(InteractiveInterpreter):
    """An interpreter that knows whether the last block failed; what it prints has the traceback."""

    failed = False

    def showtraceback(self) -> None:
        self.failed = True
        super().showtraceback()

    def read(self, place: str, code: str) -> tuple[str, bool]:
        """Run a block; return what it printed, and whether it failed."""
        linecache.cache[place] = (len(code), None, code.splitlines(True), place)  # tracebacks show the line
        self.failed = False
        said = io.StringIO()
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            self.runcode(compile(code, place, "exec", dont_inherit=True))
        return said.getvalue(), self.failed


def main() -> None:
    """Answer until the input ends."""
    sys.path[0] = ""  # the current folder, in place of this script's
    reader = Reader({"__name__": "__main__"})
    for line in sys.stdin:
        print(json.dumps(reader.read(*json.loads(line))), flush=True)


if __name__ == "__main__":
    main()
