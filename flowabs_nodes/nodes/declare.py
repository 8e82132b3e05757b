"""Declares nodes. CLI help, JSON Schema, docs, panels and validation are all made from these few classes.

A declaration is data: a :class:`Node` holds its :class:`Port` inputs and outputs and its :class:`Param` parameters,
and names the function that does the work::

    LIC = Node(
        type="lic",
        version=1,
        label="Line integral convolution",
        category="flow",
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

import re
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from importlib.util import find_spec
from typing import Any, Literal

from flowabs_nodes.choices import readable
from flowabs_nodes.errors import ArgumentError, nearest
from flowabs_nodes.image import Image, Window
from flowabs_nodes.nodes.param import Param
from flowabs_nodes.port_types import PORT_TYPES, TYPES

__all__ = ["MASK", "MIX", "Context", "Node", "Param", "Port"]


@dataclass(frozen=True)
class Port:
    """Declares an input or output.

    ``types`` is one port type, several joined by "|" (an input that takes each of them as it is), "any", or, for an
    output, ``"=name"``: of the same type as the input of that name. ``"=one|other"`` is the type among those of these
    inputs that all of them may be used as: color for a color and a matte.

    An input must have all pixels of the data window of the node's first one, to which it is cut. One that may be
    ``cut`` need not, if it is of a picture of the same size: it is its type's value for outside where it has none.
    An optional input that means something only ``beside`` another one names that: without it, it is a mistake.
    """

    name: str
    types: str
    help: str
    optional: bool = False
    cut: bool = False
    beside: str = ""

    @property
    def accepts(self) -> tuple[str, ...]:
        """Return the port types this input takes without widening (all for "any"; none for an output like "=image")."""
        if self.types == "any":
            return tuple(PORT_TYPES)
        return () if self.types.startswith("=") else tuple(self.types.split("|"))

    @property
    def follows(self) -> tuple[str, ...]:
        """Return the names of the inputs whose type this output has; none for all other ports."""
        return tuple(self.types[1:].split("|")) if self.types.startswith("=") else ()

    @property
    def same_as(self) -> str | None:
        """Return the name of the first input whose type this output has; None for all other ports."""
        return self.follows[0] if self.follows else None

    def takes(self, port_type: str) -> str | None:
        """Return the type that an image of ``port_type`` has inside the node, or None if it may not be connected."""
        if port_type in self.accepts:
            return port_type
        return next((wide for wide in self.accepts if wide in TYPES[port_type].widens_to), None)


@dataclass(frozen=True)
class Context:
    """Holds what a node's function may know beside its inputs and parameters.

    ``wanted`` names the outputs that somebody asked for, of which the others need not be made; empty asks for all.
    ``note`` and ``warn`` tell the person running the graph something about this frame, such as a measured gradient
    reference. ``services`` are the run's :class:`~flowabs_nodes.io.settings.Settings`, for nodes that read or write.
    """

    frame: int = 1
    node: str = ""
    wanted: frozenset[str] = frozenset()
    note: Callable[[str], None] = lambda text: None
    warn: Callable[[str], None] = lambda text: None
    services: Any = None


MASK = Port(
    "mask", "matte", "Where the result replaces the input: 1 there, 0 the input stays.", optional=True, cut=True
)
MIX = Param.float("mix", 1.0, min=0.0, max=1.0, soft=(0, 1), help="How much of the result goes over the input.")


@dataclass(frozen=True)
class Node:
    """Declares a node.

    ``type`` and ``version`` together are what a graph writes as ``type@version``. ``label`` is the name that people
    see, by default made of ``type``; ``category`` says where a menu lists the node: a word of
    :data:`flowabs_nodes.choices.CATEGORIES`, or a text of its own. ``help`` is one line, ``doc`` what more there is to
    say. A node whose first output is of the type of its input ``image`` also takes ``mask`` and
    ``mix``; the engine blends, so ``run`` never sees them. ``over`` names another input that the result goes over.
    ``extra_inputs`` is the port of all inputs under names that the graph makes up (``write``'s layers). ``upgrades``
    maps an older version to a function from that version's parameters to the next one's.

    ``windows`` says on which data window a node works. "first": on that of its first input, whose windows its outputs
    have. "display": on one that also holds the display window, where the first input is a mono or a matte, whose 0
    beyond its data window is to become something else. "union": on the smallest window that holds those of all inputs;
    what was not there is transparent. "own":
    inputs come as they are, and outputs have the windows that the node gives them. ``converts`` says that the result is
    in another colour space than the input. A node of windows of its own, or that converts, has neither mask nor mix.

    ``needs(params)`` returns the names of the inputs that the node needs with these parameters. All others are neither
    computed nor read, and no part of the key; ``run`` gets None for them. Without it every connected input is needed.
    ``mask`` needs no word.

    ``one_of`` names optional inputs of which at least one must be connected: ``flowabs check`` and a call say so.

    ``frames(params)`` returns, for each input that the node reads on other frames too, their offsets from its own
    frame, such as ``{"image": (-2, -1, 0, 1, 2)}``: different whole numbers from -64 to 64, 0 among them
    (:mod:`~flowabs_nodes.nodes.frame_offsets`). ``run`` gets such an input as a dict from offset to Image, in order,
    all of one type and on one data window. 0 is always there; a frame beyond the ends of the sequence, or one that
    ``missing: skip`` leaves out, is not.

    ``moment(params, frame)`` returns what the result owes to the number of its frame, beside these parameters and the
    inputs: plain data, which is a part of the key, such as ``frame // hold`` for what changes every few frames; None
    where it owes nothing. A node without it must give the same on every frame. Lengths are not scaled yet.

    ``region`` returns, for a window of the outputs, the window of each input that it is made from; an input that is
    left out is needed whole, and all are where a node has no ``region``. The parameters are those that ``run`` gets:
    all of them, lengths scaled. A window may reach beyond the picture, whose edge is then the input's. A node gets its
    inputs on one data window, hence cut to one that holds all windows returned; the node's result, cut to the window
    asked for, must have the bits of the whole result. ``mask`` needs no word. :mod:`flowabs_nodes.nodes.regions` makes
    a ``region`` of a halo.

    ``packages`` maps each top-level module that ``run`` imports and that may not be installed to what pip installs it
    with, such as ``{"cv2": "flowabs-nodes[compare]"}``. Where one is missing, ``flowabs check`` says so, and a run is
    refused before its first frame.

    Raises ArgumentError where ``type`` is no identifier, an input and a parameter share a name, or an ``enabled_when``
    is wrong: it takes enums and bools of the same node that are always enabled, and parameters that have a default.
    """

    type: str
    version: int
    help: str
    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...]
    params: tuple[Param, ...]
    run: Callable[..., Image | dict[str, Image]]
    doc: str = ""
    label: str = ""
    category: str = "utility"
    extra_inputs: Port | None = None
    over: str = "image"
    windows: Literal["first", "display", "union", "own"] = "first"
    converts: bool = False
    needs: Callable[[Mapping[str, Any]], Collection[str]] | None = field(default=None, hash=False)
    frames: Callable[[Mapping[str, Any]], Mapping[str, tuple[int, ...]]] | None = field(default=None, hash=False)
    moment: Callable[[Mapping[str, Any], int], Any] | None = field(default=None, hash=False)
    region: Callable[[Mapping[str, Any], Window], Mapping[str, Window]] | None = field(default=None, hash=False)
    packages: Mapping[str, str] = field(default_factory=dict, hash=False)
    upgrades: Mapping[int, Callable[[dict[str, Any]], dict[str, Any]]] = field(default_factory=dict, hash=False)
    one_of: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        names = [port.name for port in self.inputs] + [param.name for param in self.params]
        if not re.fullmatch(r"[a-z][a-z0-9_]*", self.type) or len(set(names)) != len(names):
            raise ArgumentError(f"node {self.type!r}: type and names must be identifiers, each used once")
        object.__setattr__(self, "label", self.label or readable(self.type))
        for param in self.params:
            self._check_condition(param)

    def __repr__(self) -> str:
        inputs = [*self.all_inputs, *(["..."] if self.extra_inputs else [])]
        return f"<Node {self.name}({', '.join(inputs)}) -> {', '.join(self.all_outputs) or 'files'}: {self.help}>"

    def _check_condition(self, param: Param) -> None:
        """Raise ArgumentError unless ``param.enabled_when`` names switches of this node and values that they take."""
        owner = f"node {self.type!r}: enabled_when of {param.name!r}"
        if param.enabled_when and param.required:
            raise ArgumentError(f"{owner}: a parameter without a default is always needed")
        declared = {other.name: other for other in self.params}
        for name, values in param.enabled_when.items():
            switch = declared.get(name)
            if switch is None or switch.kind not in ("enum", "bool") or switch.enabled_when:
                expected = "an enum or a bool of the node that is always enabled"
                switches = [each.name for each in self.params if each.kind in ("enum", "bool")]
                raise ArgumentError(f"{owner}: {name!r} is not {expected}", hint=nearest(name, switches))
            if not values or any(switch.problem(value) for value in values):
                raise ArgumentError(f"{owner}: {values!r} is not a tuple of values of {name!r}, {switch.expected}")

    @property
    def name(self) -> str:
        """Return ``type@version``."""
        return f"{self.type}@{self.version}"

    @cached_property
    def mixes(self) -> bool:
        """Return True for a node that takes an image and gives one: it has ``mask`` and ``mix``."""
        image = next((port for port in self.inputs if port.name == self.over), None)
        first = self.outputs[0] if self.outputs else None
        return (
            image is not None
            and not image.optional
            and not self.converts
            and self.windows != "own"
            and first is not None
            and (self.over in first.follows or (first.types == "color" and image.types == "color"))
        )

    @cached_property
    def all_inputs(self) -> dict[str, Port]:
        """Return every declared input by name, ``mask`` included."""
        ports = (*self.inputs, MASK) if self.mixes else self.inputs
        return {port.name: port for port in ports}

    @cached_property
    def all_params(self) -> dict[str, Param]:
        """Return every parameter by name, ``mix`` included."""
        params = (*self.params, MIX) if self.mixes else self.params
        return {param.name: param for param in params}

    @cached_property
    def all_outputs(self) -> dict[str, Port]:
        """Return every output by name; the first is the default."""
        return {port.name: port for port in self.outputs}

    def input(self, name: str) -> Port | None:
        """Return the input of that name, or the port of extra inputs; None if the node has neither."""
        return self.all_inputs.get(name, self.extra_inputs)

    @property
    def file_param(self) -> Param | None:
        """Return the parameter that names the file of a node that reads or writes one; None for all other nodes."""
        return next((param for param in self.params if param.kind == "file"), None)

    def missing(self) -> dict[str, str]:
        """Return those of ``packages`` that are not installed: what pip installs each module with, by module."""
        return {module: source for module, source in self.packages.items() if not find_spec(module)}

    @property
    def uses_config(self) -> bool:
        """Return whether the result may depend on the OCIO config: the node reads or writes files, or names a space."""
        return self.file_param is not None or any(param.colorspace is not None for param in self.params)

    def sections(self) -> dict[str, list[Param]]:
        """Return every parameter by its section of a panel, ``group``; the sections in order of their first one."""
        found: dict[str, list[Param]] = {}
        for param in self.all_params.values():
            found.setdefault(param.group, []).append(param)
        return found

    def is_enabled(self, name: str, params: Mapping[str, Any]) -> bool:
        """Return whether the parameter ``name`` does something beside ``params``; what they lack is at its default."""
        declared = self.all_params
        conditions = declared[name].enabled_when.items()
        return all(params.get(switch, declared[switch].default) in values for switch, values in conditions)

    def needed(self, inputs: Iterable[str], params: Mapping[str, Any]) -> tuple[str, ...]:
        """Return those of ``inputs``, names of inputs that are connected, that the node needs with all its ``params``.

        Raises ArgumentError, code missing-input, where the node needs one that is not among them.
        """
        if self.needs is None:
            return tuple(inputs)
        asked, connected = self.needs(params), tuple(inputs)
        for name in asked:
            if name not in connected:
                raise ArgumentError(
                    f"input {name!r}, which these parameters choose, is not connected",
                    code="missing-input",
                    hint=f"connected: {', '.join(connected) or 'none'}",
                )
        return tuple(name for name in connected if name in (*asked, MASK.name) or self.input(name) is None)

    def defaults(self) -> dict[str, Any]:
        """Return the default of every parameter that has one, by name."""
        return {name: param.default for name, param in self.all_params.items() if not param.required}
