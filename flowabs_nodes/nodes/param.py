"""Declares a parameter of a node, for the code and for panels.

For the code: type, default, range and unit (:mod:`~flowabs_nodes.nodes.value_rule`). For panels: label, help, section,
and when the parameter does something.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, Literal, TypedDict, Unpack

from flowabs_nodes.choices import Choices, readable
from flowabs_nodes.nodes.value_rule import ValueRule

# Inside the class, float, int and bool are its constructors.
Number = float
Whole = int
Flag = bool


class Panel(TypedDict, total=False):
    """What a panel has to know about a parameter of any kind; :class:`Param` says what each is."""

    label: str
    group: str
    enabled_when: Mapping[str, tuple[Any, ...]]
    animatable: bool


@dataclass(frozen=True, repr=False)
class Param(ValueRule):
    """Declares a parameter: type, default, hard range (an error beyond), soft range (what a slider shows), unit, help.

    Use the constructors :meth:`float`, :meth:`int`, :meth:`bool`, :meth:`enum`, :meth:`string`, :meth:`color`,
    :meth:`file` and :meth:`custom`. ``required`` parameters have no default. ``scales`` is +1 for pixel lengths, which
    grow with the plate where a graph has a ``reference_size``, -1 for quantities per pixel, which shrink, 0 else. Of a
    custom parameter each number of a list scales. ``of_run`` is for the size of a picture to make: it shrinks with the
    run's ``--scale`` and knows no ``reference_size``.

    ``label`` is the name that people see, by default made of ``name``; ``group`` the section of a panel that the
    parameter is in. ``enabled_when`` maps other parameters of the node, each an enum or a bool, to the values beside
    which this one does something, such as ``{"form": ("paper",)}``; beside all others it is ignored. ``animatable``
    says whether a graph may give it a curve: numbers do unless they say no, all other kinds do not.
    """

    help: str
    _: KW_ONLY
    soft: tuple[Number, Number] | None = None
    scales: Whole = 0
    of_run: Flag = False
    role: Literal["", "input", "output"] = ""  # of a file
    pictures: Flag = False  # of a file to read: it is of a format in flowabs_nodes.io.formats, which is checked first
    colorspace: tuple[str, ...] | None = None  # a text that names a colour space, or is one of these words
    of_config: Literal["", "display", "view"] = ""  # a text that names one of the OCIO config, checked before a run
    in_key: Flag = True  # False: does not change the picture, so not the key either (a written file's path)
    later: Flag = False  # came when files had keys without it: at its default it is in no key, so that they stay valid
    thin_below: Number | None = None  # scaled to less pixels than this, what is drawn depends on the picture's size
    floor: Number | None = None  # scaling makes a length no shorter than this, below which a filter sees single pixels
    label: str = ""
    group: str = ""
    enabled_when: Mapping[str, tuple[Any, ...]] = field(default_factory=dict, hash=False)
    animatable: Flag = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "label", self.label or readable(self.name))
        object.__setattr__(self, "animatable", self.animatable and self.numeric)

    @staticmethod
    def float(
        name: str,
        default: Number | None,
        *,
        min: Number | None = None,
        max: Number | None = None,
        above: Flag = False,
        soft: tuple[Number, Number] | None = None,
        unit: str = "",
        nullable: Flag = False,
        thin_below: Number | None = None,
        floor: Number | None = None,
        later: Flag = False,
        help: str,
        **panel: Unpack[Panel],
    ) -> Param:
        """Declare a number. Unit "px" makes it a length, which grows with the plate; with a unit "…/px" it shrinks."""
        return Param(
            name,
            "float",
            default,
            help,
            min=min,
            max=max,
            above=above,
            soft=soft,
            unit=unit,
            nullable=nullable,
            scales=1 if unit == "px" else -1 if unit.endswith("/px") else 0,
            thin_below=thin_below,
            floor=floor,
            later=later,
            **panel,
        )

    @staticmethod
    def int(
        name: str,
        default: Whole,
        *,
        min: Whole | None = None,
        max: Whole | None = None,
        soft: tuple[Number, Number] | None = None,
        unit: str = "",
        help: str,
        **panel: Unpack[Panel],
    ) -> Param:
        """Declare a whole number."""
        return Param(name, "int", default, help, min=min, max=max, soft=soft, unit=unit, **panel)

    @staticmethod
    def bool(name: str, default: Flag, *, help: str, **panel: Unpack[Panel]) -> Param:
        """Declare a switch."""
        return Param(name, "bool", default, help, **panel)

    @staticmethod
    def enum(
        name: str,
        default: str,
        choices: tuple[str, ...],
        *,
        later: Flag = False,
        help: str,
        in_key: Flag = True,
        **panel: Unpack[Panel],
    ) -> Param:
        """Declare one of a few words; a list of flowabs' own stands in :mod:`flowabs_nodes.choices`.

        ``choices`` may be a :class:`~flowabs_nodes.choices.Choices`, which also holds their labels and meanings.
        """
        return Param(name, "enum", default, help, choices=choices, in_key=in_key, later=later, **panel)

    @staticmethod
    def string(
        name: str,
        default: str,
        *,
        examples: tuple[str, ...] = (),
        colorspace: tuple[str, ...] | None = None,
        of_config: Literal["", "display", "view"] = "",
        later: Flag = False,
        help: str,
        **panel: Unpack[Panel],
    ) -> Param:
        """Declare a free text; ``examples`` of it are for editors, and for tests.

        ``colorspace`` says that the text is the name of a colour space, or one of the words that it gives, and
        ``of_config`` that it names a display or a view: names are checked before a run, and the OCIO config is then a
        part of the node's key.
        """
        schema = {"examples": list(examples)} if examples else {}
        own: Any = {"colorspace": colorspace, "of_config": of_config, "later": later, **panel}
        return Param(name, "string", default, help, schema=schema, **own)

    @staticmethod
    def color(name: str, default: tuple[Number, Number, Number], *, help: str, **panel: Unpack[Panel]) -> Param:
        """Declare a colour: three scene-linear numbers, red, green, blue."""
        return Param(name, "color", default, help, **panel)

    @staticmethod
    def file(
        name: str, *, role: Literal["input", "output"], pictures: Flag = False, help: str, **panel: Unpack[Panel]
    ) -> Param:
        """Declare a path or sequence pattern; required, but a run may set it from outside.

        ``pictures`` says of files to read that they are pictures of the formats of :mod:`flowabs_nodes.io.formats`: a
        file of another kind is then refused before the first frame, and never read to its end.
        """
        kept = role == "input"
        return Param(name, "file", None, help, required=True, role=role, pictures=pictures, in_key=kept, **panel)

    @staticmethod
    def custom(
        name: str,
        default: Any,
        *,
        schema: Mapping[str, Any],
        parse: Callable[[Any], str | None],
        scales: Whole = 0,
        of_run: Flag = False,
        in_key: Flag = True,
        unit: str = "",
        help: str,
        **panel: Unpack[Panel],
    ) -> Param:
        """Declare a value of its own shape: ``schema`` is its JSON Schema, ``parse`` returns what is wrong, or None."""
        return Param(
            name,
            "custom",
            default,
            help,
            unit=unit,
            scales=scales,
            of_run=of_run,
            in_key=in_key,
            schema=schema,
            parse=parse,
            **panel,
        )

    @property
    def choice_labels(self) -> dict[str, str]:
        """Return the label of each choice, by default made of its word."""
        known = self.choices.label if isinstance(self.choices, Choices) else {}
        return {word: known.get(word, readable(word)) for word in self.choices}

    @property
    def choice_meanings(self) -> Mapping[str, str]:
        """Return what each choice does, in a line; nothing where the declaration does not say."""
        return self.choices.meaning if isinstance(self.choices, Choices) else {}
