"""Small OCIO configs, as studios write them."""

from pathlib import Path

_HEAD = """ocio_profile_version: 2
roles: {default: lin, scene_linear: lin, aces_interchange: ap0}
file_rules: [!<Rule> {name: Default, colorspace: default}]
displays:
"""

_SPACES = """
colorspaces:
  - !<ColorSpace> {name: ap0, isdata: false}
  - !<ColorSpace>
    name: lin
    to_scene_reference: !<BuiltinTransform> {style: ACEScg_to_ACES2065-1}
  - !<ColorSpace>
    name: Screen
    aliases: [srgb_display]
    from_scene_reference: !<GroupTransform>
      children:
        - !<BuiltinTransform> {style: ACEScg_to_ACES2065-1, direction: inverse}
        - !<ExponentTransform> {value: 2, direction: inverse}
  - !<ColorSpace> {name: numbers, isdata: true}
"""


def with_displays(path: Path) -> str:
    """Write a config with the displays "wall" and "desk", whose view "film" takes the square root in ACEScg."""
    views = """  wall:
    - !<View> {name: film, colorspace: Screen}
    - !<View> {name: as numbers, colorspace: numbers}
  desk:
    - !<View> {name: film, colorspace: Screen}
active_displays: [wall, desk]
"""
    path.write_text(_HEAD + views + _SPACES, encoding="utf-8")
    return str(path)


def without_displays(path: Path) -> str:
    """Write a config that says nothing of screens."""
    path.write_text(_HEAD.replace("displays:\n", "displays: {}\n") + _SPACES, encoding="utf-8")
    return str(path)
