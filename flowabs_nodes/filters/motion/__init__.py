"""Steadiness in motion: where the surface of a pixel is on other frames, and means along its way."""
