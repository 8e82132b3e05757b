"""Choose the OCIO config of a run: the one that is asked for, else ``$OCIO``, else the pinned built-in one."""

from __future__ import annotations

import os
from dataclasses import replace

from flowabs_nodes.color.config import PINNED, opened
from flowabs_nodes.engine.options import RunOptions
from flowabs_nodes.engine.report import Note
from flowabs_nodes.errors import ColorError

VARIABLE = "OCIO"


def choose_config(options: RunOptions) -> tuple[RunOptions, tuple[Note, ...]]:
    """Return the options with the config that the run uses, and a note that says which it is and from where.

    The environment is read now, and the config opened. The pinned config is None, and nothing is noted unless it was
    asked for. Raises ColorError (bad-ocio-config) for a config that is missing, unreadable or broken.
    """
    found = os.environ.get(VARIABLE) or None
    chosen = options.ocio or found
    if chosen is None:
        return replace(options, ocio=None), ()
    source = "the option ocio" if options.ocio else f"${VARIABLE}"
    if options.ocio and found and found != options.ocio:
        source += f", which goes before ${VARIABLE}"
    chosen = str(chosen)
    try:
        opened(chosen)
    except ColorError as error:
        if not options.ocio:
            error.hint = f"it is what ${VARIABLE} says: give --ocio CONFIG, or unset it to use {PINNED}"
        raise
    note = Note(f"colour config {chosen}, from {source}")
    return replace(options, ocio=None if chosen == PINNED else chosen), (note,)
