"""Finishing: decode, quantise and ink each pixel of a picture, in one pass where that is possible."""
