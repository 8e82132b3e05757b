"""The words and limits of the graph file's format: its version, what may be a name, a frame, a knob's type."""

from __future__ import annotations

import re
from typing import Literal, get_args

#: The format this version writes: its number grows when an older flowabs could not read the file.
FORMAT_NAME = "flowabs.graph"
FORMAT_VERSION = 1
FORMAT = f"{FORMAT_NAME}/{FORMAT_VERSION}"

#: Names of nodes, knobs and layers.
LONGEST_NAME = 128
NAME = re.compile(rf"[A-Za-z_][A-Za-z0-9_]{{0,{LONGEST_NAME - 1}}}")
NAME_RULE = f"letters, digits and _, not starting with a digit, at most {LONGEST_NAME}"

#: A key of a curve.
FRAME = re.compile(r"0|-?[1-9][0-9]{0,8}")

MOST_NODES = 10_000

KnobType = Literal["float", "int", "bool", "enum", "string", "color"]
KNOB_TYPES: tuple[KnobType, ...] = get_args(KnobType)
