"""Tell by its name whether a part or a layer of a file is the picture, or something else that also has R, G and B."""

from __future__ import annotations

import re

#: Names of the picture itself, the best first: OpenEXR's own tools, Nuke and Arnold; RenderMan, V-Ray, Redshift, Karma;
#: Blender; then what people say.
PICTURES = ("rgba", "beauty", "combined", "rgb", "main", "master", "color", "colour", "image", "c", "ci")
#: Names of what has three channels and is no picture, by the letters before any digit.
OTHERS = frozenset(
    (
        *("n", "nn", "ng", "normal", "normals", "bump", "bumpnormals", "tangent", "p", "pref", "pworld", "position"),
        *("z", "depth", "zdepth", "mist", "vector", "motion", "motionvector", "motionvectors", "velocity", "forward"),
        *("backward", "motionback", "motionfore", "uv", "st", "id", "objectid", "materialid", "crypto", "cryptomatte"),
        *("cryptoobject", "cryptomaterial", "cryptoasset", "index", "matte", "mask", "shadow", "ao", "occlusion"),
        *("albedo", "diffuse", "specular", "reflection", "refraction", "emission", "sss", "variance", "samples"),
        *("denoisingnormal", "denoisingalbedo", "denoisingdepth", "noise", "alpha", "a"),
    )
)


def rank(name: str) -> tuple[int, int]:
    """Return a sort key for a part's or layer's name: pictures first, what is known to be none last.

    "ViewLayer.Combined.left" and "beauty_v02" are judged by their words; of two equal ones the render goes before
    Blender's "Composite", what its compositor made, to which the passes do not belong.
    """
    words = [word for word in re.split(r"[^a-z]+", re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name).lower()) if word]
    joined = re.sub(r"[^a-z]", "", name.rpartition(".")[2].lower())
    best = min((PICTURES.index(word) for word in words if word in PICTURES), default=len(PICTURES))
    if best < len(PICTURES):
        return best, 1 if "composite" in words else 0
    known = joined in OTHERS or any(word in OTHERS for word in words)
    return len(PICTURES) + known, 1


def is_picture(name: str) -> bool:
    """Return whether a name is one that is given to the picture itself."""
    return rank(name)[0] < len(PICTURES)


def is_other(name: str) -> bool:
    """Return whether a name is one of something that is no picture."""
    return rank(name)[0] > len(PICTURES)
