"""Names that renderers give to the passes of a render, and how they are compared.

Names are compared without the view layer before the last dot, without "VRay" in front, and without case, spaces and
underscores: "ViewLayer.Depth", "VRayZDepth", "Z Depth" and "z_depth" are "depth", "zdepth", "zdepth" and "zdepth".
"""

from __future__ import annotations

from typing import NamedTuple


class Names(NamedTuple):
    """The usual names of a pass, the best first, as :func:`plain_name` gives them; and what its channels are."""

    what: str
    usual: tuple[str, ...]
    channels: str


DEPTH = Names(
    "depth",
    ("depth", "z", "zdepth", "pz"),  # Blender, Karma; OpenEXR, Arnold, RenderMan; V-Ray; Mantra
    "one channel, such as Z",
)
NORMAL = Names(
    "normals",
    ("normal", "n", "nn", "normals"),  # Blender; Arnold, Karma; RenderMan; V-Ray
    "X, Y, Z or R, G, B",
)
MOTION = Names(
    "motion",
    ("vector", "motion", "motionvector", "motionvectors", "velocity"),  # Blender; ours; Arnold, Karma; V-Ray
    "X, Y, Z, W, or X, Y, or R, G, or u, v",
)
#: Motion in a layer for each way: RenderMan's and Nuke's.
MOTION_FORWARD = MOTION._replace(usual=("motionfore", "forward"))
MOTION_BACKWARD = MOTION._replace(usual=("motionback", "backward"))
ID = Names(
    "ids",
    # Arnold, RenderMan, ours; Blender 5, 4.5; V-Ray; Karma; and materials: Blender 5, 4.5, V-Ray
    ("id", "objectindex", "indexob", "objectid", "renderid", "primid", "materialindex", "indexma", "mtlid"),
    "one channel of whole numbers, or a Cryptomatte",
)
CRYPTOMATTE = Names(
    "ids",
    ("cryptoobject00", "cryptomatte00"),  # Blender, Arnold; V-Ray
    "R, G, B, A",
)
#: Found when somebody asks for the ids of the layer "material".
MATERIAL = Names(
    "materials",
    # Blender, Arnold, Karma, each a Cryptomatte; Blender 5, 4.5; V-Ray; V-Ray for Maya
    ("cryptomaterial00", "materialindex", "indexma", "mtlid", "materialid"),
    "one channel of whole numbers, or a Cryptomatte",
)
ANY_MATERIAL = "material"
#: Found when somebody asks for the ids of the layer "cryptomatte", whose real name a renderer makes up.
ANY_CRYPTOMATTE = "cryptomatte"
#: Found when somebody asks for the layer "albedo".
ALBEDO = Names(
    "albedo",
    # Arnold; RenderMan; Blender 5, 4.5; V-Ray; Blender's and Arnold's for denoising
    ("albedo", "diffusealbedo", "diffusecolor", "diffcol", "diffusefilter", "denoisingalbedo", "denoisealbedo"),
    "R, G, B",
)

#: Blender's passes that 5.0 renamed: the plain name of 4.5 and older -> that of 5.0 and newer.
_RENAMED = {
    "diffcol": "diffusecolor",
    "diffdir": "diffusedirect",
    "diffind": "diffuseindirect",
    "glosscol": "glossycolor",
    "glossdir": "glossydirect",
    "glossind": "glossyindirect",
    "transcol": "transmissioncolor",
    "transdir": "transmissiondirect",
    "transind": "transmissionindirect",
    "volumedir": "volumedirect",
    "volumeind": "volumeindirect",
    "emit": "emission",
    "env": "environment",
    "ao": "ambientocclusion",
    "indexob": "objectindex",
    "indexma": "materialindex",
}


def plain_name(layer: str) -> str:
    """Return a layer's name as usual names are compared: "depth" for "ViewLayer.Depth", "zdepth" for "VRayZDepth"."""
    last = layer.rpartition(".")[2].lower()
    return "".join(letter for letter in last if letter.isalnum()).removeprefix("vray") or last


def same_pass(layer: str, asked: str) -> bool:
    """Return whether a layer is the pass that ``asked`` names plainly: "Fg.Diffuse Color" is "DiffCol", "Fg.DiffCol".

    Old and new names of Blender's passes are the same. A view layer in ``asked`` must be the layer's.
    """
    view_layer = asked.rpartition(".")[0]
    if view_layer and view_layer != layer.rpartition(".")[0]:
        return False
    ours, theirs = plain_name(layer), plain_name(asked)
    return _RENAMED.get(ours, ours) == _RENAMED.get(theirs, theirs)
