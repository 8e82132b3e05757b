"""The last steps of a picture, each pixel on its own: quantise, decode and ink in one pass."""
