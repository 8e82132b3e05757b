"""Merges, grades, channels and formats: what a comp needs beside the filters, by OpenImageIO's ImageBufAlgo."""
