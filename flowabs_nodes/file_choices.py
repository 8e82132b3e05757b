"""The lists of words that say how files are read and written, and what a host's picture is."""

from __future__ import annotations

from flowabs_nodes.choices import Choices

#: What the alpha of a file means.
ALPHAS = Choices(
    {
        "auto": "premultiplied, straight in PNG; opaque where it is 0 in every pixel",
        "ignore": "nothing: the picture is opaque",
        "premultiplied": "colour is already multiplied by it",
        "straight": "colour is not yet multiplied by it",
    }
)

#: What happens to NaN and Inf in a plate.
NONFINITE = Choices(
    {
        "repair": "they are replaced from their neighbours, and counted",
        "error": "the frame fails",
    }
)

#: What the numbers of a motion pass say.
MOTION_CONVENTIONS = Choices(
    {
        "auto": "by the layer's name and channels",
        "blender": "four channels, y up: X, Y to the previous frame, -Z, -W to the next",
        "forward": "the first two channels, y up, to the next frame",
        "backward": "the first two channels, y up, to the previous frame",
    }
)

#: What is read in place of a frame that is not there.
MISSING = Choices(
    {
        "error": "nothing: the frame fails",
        "hold": "the last frame before it",
        "nearest": "the nearest frame",
        "black": "black, of the nearest frame's size",
        "skip": "nothing: the frame is left out",
    }
)

#: What is read in place of a pass that a file does not have.
ABSENT = Choices(
    {
        "error": "nothing: the frame fails",
        "empty": "a pass that shows nothing, with a warning: lines go without it",
        "optional": "the same, with a note: few renders have it",
    }
)

#: What happens to an output file that is there already.
EXISTING = Choices(
    {
        "resume": "it stays if whole and made from the same; else only its own graph replaces it",
        "overwrite": "it is made again",
        "error": "the frame fails",
    }
)

#: The data type of the channels that are written.
DATA_TYPES = Choices(
    {
        "auto": "the plate's, else half; flow layers float; PNG uint8, TIFF uint16",
        "half": "16 bit floating point, EXR",
        "float": "32 bit floating point, EXR and TIFF",
        "uint8": "8 bit, PNG and TIFF",
        "uint16": "16 bit, PNG and TIFF",
    },
    {"uint8": "8 bit", "uint16": "16 bit"},
)

#: The compression of an EXR.
COMPRESSIONS = Choices(
    {
        "auto": "the plate's if it is lossless, else zip",
        "none": "uncompressed",
        "rle": "run lengths, lossless",
        "zips": "deflate of single rows, lossless",
        "zip": "deflate of 16 rows, lossless",
        "piz": "wavelets, lossless",
        "pxr24": "deflate, lossless for half; float is rounded to 24 bit",
        "b44": "4 x 4 blocks, lossy for half",
        "b44a": "4 x 4 blocks, flat ones smaller; lossy for half",
        "dwaa": "DCT of 32 rows, lossy",
        "dwab": "DCT of 256 rows, lossy",
    },
    {
        "rle": "RLE",
        "zips": "ZIPS",
        "zip": "ZIP",
        "piz": "PIZ",
        "pxr24": "PXR24",
        "b44": "B44",
        "b44a": "B44A",
        "dwaa": "DWAA",
        "dwab": "DWAB",
    },
)

#: Which row of a host's picture comes first.
ROWS = Choices({"top-down": "the top row comes first", "bottom-up": "the lowest row comes first"})

#: How the colours in a host's picture stand to its alpha.
HOST_ALPHAS = Choices(
    {"premultiplied": "colours are multiplied by alpha", "straight": "colours are not multiplied by alpha"}
)
