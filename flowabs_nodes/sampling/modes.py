"""The ways of sampling a picture along the flow."""

#: Interpolating between the four pixels around a point, or taking the nearest pixel.
SAMPLINGS = ("bilinear", "nearest")
