"""An option with one value may be given once: of two files to read, none is passed over in silence."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import click


class OnceOption(click.Option):
    """An option whose value may be given once. Click itself takes the last of several."""

    def add_to_parser(self, parser: Any, ctx: click.Context) -> None:
        """Have the parser collect every value."""
        self.multiple = not self.is_flag
        try:
            super().add_to_parser(parser, ctx)
        finally:
            self.multiple = False

    def consume_value(self, ctx: click.Context, opts: Mapping[str, Any]) -> Any:
        """Return the only value; raise UsageError where there are several."""
        values = opts.get(self.name or "")
        if isinstance(values, list):
            if len(values) > 1:
                flag = min(self.opts, key=len)
                found = ", ".join(map(str, values))
                raise click.UsageError(f"{flag} is given {len(values)} times, but takes one value: {found}", ctx)
            opts = {**opts, self.name or "": values[0]}
        return super().consume_value(ctx, opts)
