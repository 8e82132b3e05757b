"""``flowabs colorspaces``: lists the names that a colour space may be given by."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any

import click

from flowabs_nodes.engine.options import RunOptions, flag_of


@click.command()
@click.argument("name", required=False)
@click.option("--ocio", metavar="CONFIG", help=flag_of(RunOptions.__dataclass_fields__["ocio"]).help)
@click.option("--json", "as_json", is_flag=True, help="One JSON document.")
def colorspaces(name: str | None, ocio: str | None, as_json: bool) -> None:
    """The colour spaces that read and write know, or what one NAME means.

    That is our names, and the spaces, roles, displays and views of the OCIO config that flowabs run would use.
    """
    from flowabs_nodes.color.config import PINNED
    from flowabs_nodes.color.listing import explained, listing
    from flowabs_nodes.engine.ocio_choice import choose_config

    options, notes = choose_config(RunOptions(ocio=ocio))
    if as_json:
        found = listing(options.ocio) if name is None else explained(name, options.ocio)
        click.echo(json.dumps(found, indent=2, ensure_ascii=False))
        return
    if name is not None:
        click.echo("\n".join(_about(explained(name, options.ocio))))
        return
    for line in notes or [f"colour config {PINNED}, the built-in one"]:
        click.echo(line)
    click.echo("\n".join(_listed(listing(options.ocio))))


def _about(found: dict[str, Any]) -> Iterable[str]:
    """Yield the lines that say what a name means."""
    from flowabs_nodes.color.spaces import KNOWN

    kind, space = found["kind"], found["linear_space"]
    means = {
        "linear": f"scene-linear, {space if space in KNOWN else 'with primaries of its own'}",
        "data": "data, no colour: pixels stay as they are",
    }.get(kind, f"code values; read brings them to {space}, scene-linear")
    yield found["name"]
    yield f"  means     {means}"
    yield f"  known to  {found['config'] or 'flowabs, in every config'}"
    for key in ("family", "encoding", "aliases"):
        value = found.get(key)
        if value:
            yield f"  {key:8}  {value if isinstance(value, str) else ', '.join(value)}"


def _listed(found: dict[str, Any]) -> Iterable[str]:
    """Yield the lines of the whole list."""
    yield "\nNames of flowabs, in every config:"
    for each in found["flowabs"]:
        yield from _entry(f"  {each['name']:22} {each['kind']:13}", each["aliases"])
    yield "\nColour spaces of the config (* scene-linear):"
    for family in sorted({each["family"] for each in found["spaces"]}):
        yield f"  {family or 'no family'}"
        for each in (each for each in found["spaces"] if each["family"] == family):
            mark = "*" if each["scene_linear"] else " "
            yield from _entry(f"  {mark} {each['name']:36} {each['encoding']:13}", each["aliases"])
    yield "\nRoles:"
    for role, space in found["roles"].items():
        yield f"  {role:26} {space}"
    yield "\nDisplays and views (* the default):"
    for display, views in found["displays"].items():
        default = display == found["default_display"]
        shown = [f"{view} *" if default and view == found["default_view"] else view for view in views]
        yield from _entry(f"  {display + ' *' if default else display:30}", shown)


def _entry(head: str, words: list[str]) -> Iterable[str]:
    """Yield a line of words after a head, as several lines where they are long; no word is broken."""
    line = head
    for index, word in enumerate(words):
        part = word + ("," if index < len(words) - 1 else "")
        if len(line) + len(part) >= 120:
            yield line
            line = " " * 5
        line += " " + part
    yield line.rstrip()
