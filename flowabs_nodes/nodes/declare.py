"""How a node is declared. CLI help, JSON Schema, docs and validation are all made from these few classes.

A declaration is data: a :class:`Node` holds its :class:`Port` inputs and outputs and its :class:`Param` parameters,
and names the function that does the work::

    LIC = Node(
        type="lic",
        version=1,
        help="Line integral convolution: shows a flow as streaked noise.",
        inputs=(Port("flow", "flow", "The flow to show."),),
        outputs=(Port("image", "mono", "Streaks along the flow, 0 to 1."),),
        params=(
            Param.float("length", 20.0, min=0.0, max=1000.0, soft=(5, 60), unit="px", help="Length of a streak."),
            Param.int("seed", 1, min=0, max=2**31 - 1, help="Seed of the noise."),
        ),
        run=run_lic,
    )

``run(context, **inputs, **parameters)`` gets each connected input as an :class:`~flowabs_nodes.image.Image` (an
optional input that is not connected as ``None``) and each parameter by name, and returns one Image (the first
output) or a dict from output name to Image. It must not change its inputs.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal

from flowabs_nodes.errors import ArgumentError, nearest
from flowabs_nodes.image import PORT_TYPES, Image

#: What may go where: a matte may go where a mono is asked for, and either where a color is. Nothing else converts.
WIDENS_TO: Mapping[str, frozenset[str]] = {
    "matte": frozenset({"matte", "mono", "color"}),
    "mono": frozenset({"mono", "color"}),
    "color": frozenset({"color"}),
    "flow": frozenset({"flow"}),
    "data": frozenset({"data"}),
}

Kind = Literal["float", "int", "bool", "enum", "string", "color", "file", "custom"]


@dataclass(frozen=True)
class Port:
    """An input or output.

    ``types`` is one port type, several joined by "|" (an input that takes each of them as it is), "any", or, for an
    output, ``"=name"``: of the same type as the input of that name.
    """

    name: str
    types: str
    help: str
    optional: bool = False

    @property
    def accepts(self) -> tuple[str, ...]:
        """The port types this input takes without widening (all for "any"; empty for an output like "=image")."""
        if self.types == "any":
            return PORT_TYPES
        return () if self.types.startswith("=") else tuple(self.types.split("|"))

    @property
    def same_as(self) -> str | None:
        """For an output, the input whose type it has; else None."""
        return self.types[1:] if self.types.startswith("=") else None

    def takes(self, port_type: str) -> str | None:
        """The type that a value of ``port_type`` has inside the node, or None where it may not be connected."""
        if port_type in self.accepts:
            return port_type
        return next((wide for wide in self.accepts if wide in WIDENS_TO[port_type]), None)


@dataclass(frozen=True)
class Param:
    """A parameter: type, default, hard range (an error beyond), soft range (what a slider shows), unit, help.

    Use the constructors :meth:`float`, :meth:`int`, :meth:`bool`, :meth:`enum`, :meth:`string`, :meth:`color`,
    :meth:`file` and :meth:`custom`. ``required`` parameters have no default. ``scales`` is +1 for pixel lengths, which
    grow with the plate, -1 for quantities per pixel, which shrink (DESIGN: ``reference_height``), 0 for all others.
    """

    name: str
    kind: Kind
    default: Any
    help: str
    min: float | None = None
    max: float | None = None
    above: bool = False  # the minimum itself is excluded
    soft: tuple[float, float] | None = None
    unit: str = ""
    choices: tuple[str, ...] = ()
    nullable: bool = False
    required: bool = False
    scales: int = 0
    role: Literal["", "input", "output"] = ""  # of a file
    in_key: bool = True  # False: does not change the picture, so not the key either (a written file's path)
    schema: Mapping[str, Any] = field(default_factory=dict, hash=False)  # custom: its JSON Schema
    parse: Callable[[Any], str | None] | None = None  # custom: what is wrong with a value, or None

    @staticmethod
    def float(
        name: str,
        default: float | None,
        *,
        min: float | None = None,
        max: float | None = None,
        above: bool = False,
        soft: tuple[float, float] | None = None,
        unit: str = "",
        nullable: bool = False,
        help: str,
    ) -> Param:
        """A number. Unit "px" makes it a length, which scales with the plate; a unit per pixel ("…/px") the reverse."""
        scales = 1 if unit == "px" else -1 if unit.endswith("/px") else 0
        return Param(name, "float", default, help, min, max, above, soft, unit, nullable=nullable, scales=scales)

    @staticmethod
    def int(
        name: str,
        default: int,
        *,
        min: int | None = None,
        max: int | None = None,
        soft: tuple[float, float] | None = None,
        unit: str = "",
        help: str,
    ) -> Param:
        """A whole number."""
        return Param(name, "int", default, help, min, max, False, soft, unit)

    @staticmethod
    def bool(name: str, default: bool, *, help: str) -> Param:
        """A switch."""
        return Param(name, "bool", default, help)

    @staticmethod
    def enum(name: str, default: str, choices: tuple[str, ...], *, help: str, in_key: bool = True) -> Param:
        """One of a few words."""
        return Param(name, "enum", default, help, choices=choices, in_key=in_key)

    @staticmethod
    def string(name: str, default: str, *, help: str) -> Param:
        """Free text."""
        return Param(name, "string", default, help)

    @staticmethod
    def color(name: str, default: tuple[float, float, float], *, help: str) -> Param:
        """Three scene-linear numbers, red, green, blue."""
        return Param(name, "color", default, help)

    @staticmethod
    def file(name: str, *, role: Literal["input", "output"], help: str) -> Param:
        """A path or sequence pattern; required, but a run may set it from outside."""
        return Param(name, "file", None, help, required=True, role=role, in_key=role == "input")

    @staticmethod
    def custom(
        name: str,
        default: Any,
        *,
        schema: Mapping[str, Any],
        parse: Callable[[Any], str | None],
        scales: int = 0,
        in_key: bool = True,
        unit: str = "",
        help: str,
    ) -> Param:
        """A value of its own shape: ``schema`` says it in JSON Schema, ``parse`` returns what is wrong, or None."""
        return Param(name, "custom", default, help, unit=unit, scales=scales, in_key=in_key, schema=schema, parse=parse)

    @property
    def numeric(self) -> bool:
        """True for a parameter that a curve or a map may drive."""
        return self.kind in ("float", "int")

    def problem(self, value: Any) -> tuple[str, str] | None:
        """What is wrong with ``value``: (code, what was expected), code "wrong-type", "bad-value" or "out-of-range"."""
        if value is None and self.nullable:
            return None
        if self.kind == "custom":
            assert self.parse is not None
            wrong = self.parse(value)
            return ("bad-value", wrong) if wrong else None
        if not self._type_fits(value):
            return "wrong-type", self.expected
        if self.kind == "enum" and value not in self.choices:
            return "bad-value", self.expected
        if self.kind == "color" and not all(math.isfinite(part) for part in value):
            return "bad-value", self.expected
        if self.numeric:
            if not math.isfinite(value):
                return "bad-value", self.expected
            low = self.min is not None and (value < self.min or (self.above and value == self.min))
            if low or (self.max is not None and value > self.max):
                return "out-of-range", self.expected
        return None

    def _type_fits(self, value: Any) -> bool:
        number = isinstance(value, int | float) and not isinstance(value, bool)
        match self.kind:
            case "float":
                return number
            case "int":
                return isinstance(value, int) and not isinstance(value, bool)
            case "bool":
                return isinstance(value, bool)
            case "color":
                return (
                    isinstance(value, list | tuple)
                    and len(value) == 3
                    and all(isinstance(part, int | float) and not isinstance(part, bool) for part in value)
                )
            case _:
                return isinstance(value, str)

    def check(self, value: Any) -> Any:
        """``value`` in the type that ``run`` gets; raises ArgumentError (named after the parameter) if it is wrong."""
        wrong = self.problem(value)
        if wrong:
            hint = nearest(value, self.choices) if self.kind == "enum" else ""
            raise ArgumentError(f"{value!r} is not {wrong[1]}", code=wrong[0], hint=hint, parameter=self.name)
        if value is None:
            return None
        match self.kind:
            case "float":
                return float(value)
            case "color":
                return tuple(float(part) for part in value)
            case _:
                return value

    @cached_property
    def expected(self) -> str:
        """What a value must be, in words: "a number from 0 to 1, or null"."""
        words = {
            "float": "a number",
            "int": "a whole number",
            "bool": "true or false",
            "enum": "one of " + ", ".join(repr(choice) for choice in self.choices),
            "string": "a text",
            "color": "a colour: three finite numbers, scene-linear red, green, blue",
            "file": "a file name or sequence pattern",
            "custom": "another value",
        }[self.kind]
        if self.min is not None or self.max is not None:
            words += " " + self.range_text
        if self.unit and self.numeric:
            words += f" ({self.unit})"
        return words + (", or null" if self.nullable else "")

    @cached_property
    def range_text(self) -> str:
        """The hard range in words: "from 0 to 1", "above 0 up to 100"; empty where there is none."""
        low = "" if self.min is None else f"{'above' if self.above else 'from'} {self.min:g}"
        high = "" if self.max is None else f"{'up to' if self.above or self.min is None else 'to'} {self.max:g}"
        return " ".join(part for part in (low, high) if part)


@dataclass(frozen=True)
class Context:
    """What a node's function may know beside its inputs and parameters.

    ``wanted`` names the outputs that somebody asked for: one that nobody wants need not be made. ``note`` and ``warn``
    tell the person running the graph something about this frame, such as a measured gradient reference.
    """

    frame: int = 1
    node: str = ""
    wanted: frozenset[str] = frozenset()
    note: Callable[[str], None] = lambda text: None
    warn: Callable[[str], None] = lambda text: None
    services: Any = None  # what reading and writing need to know: flowabs_nodes.io.settings.Settings


MASK = Port("mask", "matte", "Where the result replaces the input: 1 there, 0 the input stays.", optional=True)
MIX = Param.float("mix", 1.0, min=0.0, max=1.0, soft=(0, 1), help="How much of the result goes over the input.")


@dataclass(frozen=True)
class Node:
    """A declaration. ``type`` and ``version`` together are what a graph writes as ``type@version``.

    A node whose first output is of the type of its input ``image`` also takes ``mask`` and ``mix``; the engine blends,
    so ``run`` never sees them. ``extra_inputs`` is a port that further inputs of any name are of (``write``'s layers).
    ``upgrades`` maps an older version to a function from that version's parameters to the next one's.
    """

    type: str
    version: int
    help: str
    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...]
    params: tuple[Param, ...]
    run: Callable[..., Image | dict[str, Image]]
    doc: str = ""
    extra_inputs: Port | None = None
    upgrades: Mapping[int, Callable[[dict[str, Any]], dict[str, Any]]] = field(default_factory=dict, hash=False)

    def __post_init__(self) -> None:
        names = [port.name for port in self.inputs] + [param.name for param in self.params]
        if not re.fullmatch(r"[a-z][a-z0-9_]*", self.type) or len(set(names)) != len(names):
            raise ArgumentError(f"node {self.type!r}: type and names must be identifiers, each used once")

    @property
    def name(self) -> str:
        """``type@version``."""
        return f"{self.type}@{self.version}"

    @cached_property
    def mixes(self) -> bool:
        """True for a node that takes an image and gives one: it has ``mask`` and ``mix``."""
        image = next((port for port in self.inputs if port.name == "image"), None)
        first = self.outputs[0] if self.outputs else None
        return (
            image is not None
            and not image.optional
            and first is not None
            and (first.same_as == "image" or (first.types == "color" and image.types == "color"))
        )

    @cached_property
    def all_inputs(self) -> dict[str, Port]:
        """Every declared input by name, ``mask`` included."""
        ports = (*self.inputs, MASK) if self.mixes else self.inputs
        return {port.name: port for port in ports}

    @cached_property
    def all_params(self) -> dict[str, Param]:
        """Every parameter by name, ``mix`` included."""
        params = (*self.params, MIX) if self.mixes else self.params
        return {param.name: param for param in params}

    @cached_property
    def all_outputs(self) -> dict[str, Port]:
        """Every output by name; the first is the default."""
        return {port.name: port for port in self.outputs}

    def input(self, name: str) -> Port | None:
        """The input of that name, extra inputs included."""
        return self.all_inputs.get(name, self.extra_inputs)

    @property
    def file_param(self) -> Param | None:
        """The parameter that names the file of a ``read`` or ``write``; None for all others."""
        return next((param for param in self.params if param.kind == "file"), None)

    def defaults(self) -> dict[str, Any]:
        """Every parameter that has a default, with it."""
        return {name: param.default for name, param in self.all_params.items() if not param.required}
