"""Small OCIO configs of a studio, made in a folder of a test."""

AP1_TO_AP0 = (
    "0.6954522, 0.1406787, 0.1638691, 0, 0.0447946, 0.8596711, 0.0955343, 0, "
    "-0.0055259, 0.0040252, 1.0015007, 0, 0, 0, 0, 1"
)

STUDIO = """ocio_profile_version: 2
description: a show of $SHOW
search_path: luts
roles:
  scene_linear: show_lin
  default: bytes
INTERCHANGE
file_rules:
  - !<Rule> {name: Default, colorspace: default}
displays:
  monitor:
    - !<View> {name: Film, colorspace: show_film}
    - !<View> {name: Raw, colorspace: bytes}
colorspaces:
  - !<ColorSpace> {name: house_reference, family: Reference, encoding: scene-linear}
  - !<ColorSpace> {name: bytes, isdata: true, encoding: data}
  - !<ColorSpace>
    name: show_lin
    aliases: [plate_lin]
    family: Show
    encoding: scene-linear
    to_scene_reference: !<MatrixTransform> {matrix: [MATRIX]}
  - !<ColorSpace>
    name: show_log
    family: Show
    encoding: log
    to_scene_reference: !<GroupTransform>
      children:
        - !<LogTransform> {base: 10, direction: inverse}
        - !<MatrixTransform> {matrix: [MATRIX]}
  - !<ColorSpace>
    name: show_film
    family: Show
    to_scene_reference: !<FileTransform> {src: film.cube, interpolation: linear}
  - !<ColorSpace>
    name: sRGB
    to_scene_reference: !<ExponentTransform> {value: 1.8}
"""


def studio(folder, *, interchange="  aces_interchange: house_reference", gain=1.0, text=STUDIO, name="config.ocio"):
    """Write a config and its only table, of which 1 becomes ``gain`` (None: no table), and return the config's path."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / name
    path.write_text(text.replace("INTERCHANGE", interchange).replace("MATRIX", AP1_TO_AP0))
    if gain is not None:
        table(folder, gain)
    return str(path)


def table(folder, gain):
    """Write the table of :func:`studio`."""
    (folder / "luts").mkdir(exist_ok=True)
    (folder / "luts" / "film.cube").write_text(f"LUT_1D_SIZE 2\n0 0 0\n{gain} {gain} {gain}\n")
