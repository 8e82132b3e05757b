"""List the names that a colour space may be given by: ours, and those of an OCIO config."""

from __future__ import annotations

from typing import Any

from flowabs_nodes.color import config, config_files
from flowabs_nodes.color.config import Ocio, opened
from flowabs_nodes.color.named import CINEON_NAMES, DATA_NAMES, SRGB_NAMES, find
from flowabs_nodes.color.spaces import SOURCES, STANDARD


def listing(ocio: Ocio = None) -> dict[str, Any]:
    """Return every name that can be used with a config, as plain data.

    Returns
    -------
    dict
        "config": the config's name. "flowabs": our names, each with "name", "aliases" and "kind" (scene-linear, sRGB,
        Cineon or data); names that the config has itself are the config's, and left out. "spaces": those of the config,
        as :func:`described` gives them. "roles": role -> space. "displays": display -> its views. "default_display"
        and "default_view".
    """
    own = opened(ocio)
    found = config.config(own)
    displays = [str(each) for each in found.getDisplayNames()]
    default = str(found.getDefaultDisplayName() or "")
    return {
        "config": own.name,
        "flowabs": [each for each in map(_without_the_configs(own), _OURS) if each["name"]],
        "spaces": [described(str(name), own) for name in found.getColorSpaceNames()],
        "roles": {str(role): str(found.getColorSpaceNameByRole(role)) for role in found.getRoles()},
        "displays": {display: [str(view) for view in found.getViewNames(display)] for display in displays},
        "default_display": default,
        "default_view": str(found.getDefaultViewName(default) or "") if default else "",
    }


def described(name: str, ocio: Ocio = None) -> dict[str, Any]:
    """Return what a config says of one of its spaces: "name", "family", "encoding", "aliases", "scene_linear".

    ``encoding`` is the config's word for it, or else "data", "scene-linear" or ""; ``scene_linear`` is None where
    OpenImageIO (3.0) does not tell.
    """
    own = opened(ocio)
    found = config.config(own)
    aliases = [str(alias) for alias in found.getAliases(name)]
    is_linear = getattr(found, "isColorSpaceLinear", None)
    display = name in config_files.display_names(own.path) or any(each.endswith("_display") for each in aliases)
    linear = None if is_linear is None else bool(is_linear(name)) and not display
    said = "data" if config.is_data(name, own) else "scene-linear" if linear else ""
    return {
        "name": name,
        "family": str(found.getColorSpaceFamilyByName(name) or ""),
        "encoding": config_files.said_of_spaces(own.path, "encoding").get(name) or said,
        "aliases": aliases,
        "scene_linear": linear,
    }


def explained(name: str, ocio: Ocio = None) -> dict[str, Any]:
    """Return what a name means to `read` and `write`, from a trial conversion.

    Beside what :func:`described` returns of a space of the config: "kind" (linear, srgb, cineon, encoded or data),
    "linear_space" (the scene-linear space that its pixels are brought to), and "config", which knows it; None for a
    name of ours. Raises ColorError for a name that nobody knows, with the nearest name, or that cannot be converted.
    """
    meaning = find(name, ocio)
    known = config.has(meaning.name, meaning.config)
    ours = not known or (meaning.name == name and (name in STANDARD or name.lower() in DATA_NAMES))
    about = (
        {"name": meaning.name} if ours else described(config.canonical(meaning.name, meaning.config), meaning.config)
    )
    return {
        **about,
        "kind": meaning.kind,
        "linear_space": None if meaning.kind == "data" else meaning.space.name,
        "config": None if ours else meaning.config.name,
    }


_OURS: tuple[dict[str, Any], ...] = (
    *({"name": name, "aliases": list(aliases), "kind": "scene-linear"} for name, (_, aliases) in SOURCES.items()),
    {"name": "sRGB", "aliases": sorted(SRGB_NAMES - {"srgb"}), "kind": "sRGB"},
    {"name": "cineon", "aliases": sorted(CINEON_NAMES - {"cineon"}), "kind": "Cineon"},
    {"name": "data", "aliases": sorted(DATA_NAMES - {"data"}), "kind": "data"},
)
_ALWAYS_OURS = STANDARD | DATA_NAMES | {"srgb_rec709_scene", "srgb_rec709_display"}


def _without_the_configs(own: config.Config) -> Any:
    """Return a function that leaves out of our names those that another config than the pinned one has itself."""

    def kept(ours: dict[str, Any]) -> dict[str, Any]:
        names = [
            name
            for name in (ours["name"], *ours["aliases"])
            if not own.content or name in _ALWAYS_OURS or not config.has(name, own)
        ]
        return {**ours, "name": names[0] if names else "", "aliases": names[1:]}

    return kept
