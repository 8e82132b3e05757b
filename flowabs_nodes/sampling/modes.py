"""How pictures are read along the flow."""

SAMPLINGS = ("bilinear", "nearest")
